"""Microseconds per communication step: Python stepper, compiled stepper, a loop written in C.

Run: python tests/benchmarks/master.py

All three run the same FMUs from the same start, in turn; medians of several rounds.
"""

from __future__ import annotations

import ctypes
import statistics
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import ring
from c_loop import CLoop
from rich.console import Console
from rich.table import Table

from sightline.orchestrator.compiled import CompiledStepper
from sightline.orchestrator.log import RunLog
from sightline.orchestrator.starting import load
from sightline.orchestrator.stepper import PythonStepper, Stepper
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_formation" / "system.toml"
ROUNDS = 7
PYTHON_SHARE = 50  # the Python stepper takes this many times fewer steps


def formation(folder: Path) -> Path:
    """The example at 1 ms for 200 s, recorded every 0.1 s."""
    path = folder / "formation.toml"
    path.write_text(
        f'extends = "{EXAMPLE.as_posix()}"\nplots = []\n'
        "[simulation]\nstop_time = 200.0\nstep = 0.001\n[record]\nevery = 0.1\n",
        encoding="utf-8",
    )
    return path


def started(system: System, kind: type[Stepper], stack: ExitStack) -> Stepper:
    """A stepper at the start of a run."""
    simulation = system.loaded.config.simulation
    slaves = load(system.graph, RunLog(None), stack)
    for node, slave in zip(system.graph.nodes, slaves, strict=True):
        slave.initialise(node.settings, simulation.start_time, simulation.stop_time)
    stepper = kind(system.plan, slaves, simulation.start_time, simulation.step)
    stepper.initialise(simulation.steps)
    return stepper


def measure(system: System, name: str, folder: Path) -> tuple[float, np.ndarray]:
    """Microseconds per step of one run, and what it recorded."""
    config = system.loaded.config
    steps, stride = config.simulation.steps, config.record_stride
    with ExitStack() as stack:
        kind = PythonStepper if name == "Python stepper" else CompiledStepper
        stepper = started(system, kind, stack)
        rows = np.zeros((steps // stride + 1, len(system.plan.recorded)))
        if name == "C loop":
            loop = CLoop(stepper, folder)
            pointer = rows.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
            began = time.perf_counter()
            loop.run(steps, stride, pointer)
        else:
            if name == "Python stepper":
                steps //= PYTHON_SHARE
            began = time.perf_counter()
            stepper.advance(0, steps, stride, rows)
        return (time.perf_counter() - began) / steps * 1e6, rows


def compare(title: str, system: System, folder: Path) -> Table:
    """All three, in turn."""
    names = ("C loop", "compiled stepper", "Python stepper")
    times: dict[str, list[float]] = {n: [] for n in names}
    for _ in range(ROUNDS):
        rows = {}
        for name in names:
            spent, rows[name] = measure(system, name, folder)
            times[name].append(spent)
        assert np.array_equal(rows["C loop"], rows["compiled stepper"])
    table = Table(title=title, title_justify="left")
    for heading in ("", "us per communication step", "ratio", "fastest"):
        table.add_column(heading, justify="left" if not heading else "right")
    reference = statistics.median(times["C loop"])
    for name, found in times.items():
        median = statistics.median(found)
        table.add_row(name, f"{median:.3f}", f"{median / reference:.2f}", f"{min(found):.3f}")
    return table


def main() -> None:
    """Print the tables."""
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        system = System.from_toml(ring.config(folder))
        console.print(compare("ring of 4 FMUs, 40 connections", system, folder))
        system = System.from_toml(formation(folder))
        count = len(system.graph.nodes)
        title = f"los_formation, {count} FMUs, 1 ms for 200 s, recorded every 0.1 s"
        console.print(compare(title, system, folder))


if __name__ == "__main__":
    main()
