"""Microseconds per communication step with none, one and all FMUs in processes of their own.

Run from the project's folder: python -m tests.benchmarks.isolation

The same systems from the same start, in turn; medians of several rounds. Each communication step of
an isolated FMU takes two round trips between processes: set and step, get.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from sightline.orchestrator.fmi.log import RunLog
from sightline.orchestrator.stepping.starting import start
from sightline.orchestrator.system import System

from . import ring
from .master import EXAMPLE

ROUNDS = 5
STEPS = {"none": 20_000, "one": 5_000, "all": 2_000}


def isolating(system: System, which: str) -> System:
    """The system with none, one or all of its FMUs isolated."""
    count = {"none": 0, "one": 1, "all": len(system.graph.nodes)}[which]
    nodes = tuple(replace(n, isolated=i < count) for i, n in enumerate(system.graph.nodes))
    return replace(system, graph=replace(system.graph, nodes=nodes))


def measure(system: System, which: str) -> float:
    """Microseconds per step of one run."""
    simulation = system.loaded.config.simulation
    nothing = np.empty((1, 0))
    with ExitStack() as stack:
        isolated = isolating(system, which)
        stepper, _ = start(isolated.graph, system.plan, simulation, RunLog(None), stack)
        steps = STEPS[which]
        began = time.perf_counter()
        stepper.advance(0, steps, steps + 1, nothing)
        return (time.perf_counter() - began) / steps * 1e6


def compare(title: str, system: System) -> Table:
    """None, one and all, in turn."""
    times: dict[str, list[float]] = {w: [] for w in STEPS}
    for _ in range(ROUNDS):
        for which in STEPS:
            times[which].append(measure(system, which))
    table = Table("isolated", "µs per step", "ratio", "µs per isolated FMU", title=title)
    plain = statistics.median(times["none"])
    for which, found in times.items():
        median = statistics.median(found)
        count = sum(n.isolated for n in isolating(system, which).graph.nodes)
        each = f"{(median - plain) / count:.1f}" if count else ""
        table.add_row(which, f"{median:.2f}", f"{median / plain:.0f}", each)
    return table


def main() -> None:
    """Print both comparisons."""
    console = Console()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        ring.build(folder)
        console.print(compare("4 trivial FMUs", System.from_toml(ring.config(folder))))
        console.print(compare("line-of-sight formation, 12 FMUs", System.from_toml(EXAMPLE)))


if __name__ == "__main__":
    main()
