"""A ring of 2 to 1000 spacecraft: cost of an FMU's step, time to the start, memory.

Run from the project's folder: python -m tests.benchmarks.consensus_ring
The cost is that of the stepping loop; steps are recorded as the example says. Checking reads and
checks the config, starting loads and initialises the FMUs; memory counts the libraries too.
"""

from __future__ import annotations

import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from sightline.orchestrator.fmi.log import RunLog
from sightline.orchestrator.stepping.starting import start
from sightline.orchestrator.stepping.stepper import Stepper
from sightline.orchestrator.system import System

from .rounds import ratio, timed

EXAMPLE = Path(__file__).parents[2] / "examples" / "consensus_ring" / "system.toml"
CRAFT = (2, 10, 100, 1000)
ROUNDS = 15
WORK = 200_000  # FMU steps of a round
STOP = 1e6  # s, never reached


def resident() -> float:
    """Memory of this process, kB."""
    status = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) for line in status if line.startswith("VmRSS"))


class Ring:
    """A started system, and what its start took."""

    def __init__(self, craft: int, stack: ExitStack) -> None:
        settings = {"repeat.i": craft, "simulation.stop_time": STOP}
        before, began = resident(), time.perf_counter()
        self.system = System.from_toml(EXAMPLE, settings)
        checked = time.perf_counter()
        config = self.system.loaded.config
        log = RunLog(None)
        self.stepper: Stepper
        self.stepper, _ = start(self.system.graph, self.system.plan, config.simulation, log, stack)
        self.checking, self.starting = checked - began, time.perf_counter() - checked
        self.memory = resident() - before
        self.fmus = len(self.system.graph.nodes)
        self.stride = config.record_stride
        self.number = 0

    def nanoseconds(self) -> float:
        """Per FMU step, in the steps that come next."""
        steps = WORK // self.fmus
        rows = np.empty((steps // self.stride + 1, len(self.system.plan.recorded)))
        began = time.perf_counter()
        self.stepper.advance(self.number, self.number + steps, self.stride, rows)
        self.number += steps
        return (time.perf_counter() - began) / steps / self.fmus * 1e9


def main() -> None:
    """Print the table."""
    System.from_toml(EXAMPLE)  # builds the FMUs if they are not
    table = Table(title="consensus ring", title_justify="left")
    for heading in ("craft", "FMUs", "ns per FMU step", "ratio to 10", "checking, s", "starting, s",
                    "kB per FMU"):  # fmt: skip
        table.add_column(heading, justify="right")
    with ExitStack() as stack:
        rings = {str(craft): Ring(craft, stack) for craft in CRAFT}
        timings = {craft: partial(Ring.nanoseconds, ring) for craft, ring in rings.items()}
        found = timed(timings, ROUNDS)
        for craft, ring in rings.items():
            table.add_row(
                craft, str(ring.fmus), f"{np.median(found[craft]):.0f}",
                f"{ratio(found, craft, '10'):.2f}", f"{ring.checking:.2f}", f"{ring.starting:.2f}",
                f"{ring.memory / ring.fmus:.1f}",
            )  # fmt: skip
    Console().print(table)


if __name__ == "__main__":
    main()
