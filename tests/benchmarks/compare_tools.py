"""Example 5.1 at 10 ms for 200 s, from the same native FMU files, in several tools side by side.

Run from the project's folder: python -m tests.benchmarks.compare_tools [ROUNDS]
Only stepping is timed, with no results recorded. Needs libcosimpy and ecospy.
"""

from __future__ import annotations

import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from rich.console import Console
from rich.table import Table

from ..external.formation import Formation, formation
from ..external.tools import FmpyLoop, done, ecos_simulation, libcosim_execution

STEP, STOP = 0.01, 200.0  # s
COUNT = round(STOP / STEP)
Timing = Callable[[], float]


def seconds(action: Callable[[], object]) -> float:
    """How long an action takes."""
    began = time.perf_counter()
    action()
    return time.perf_counter() - began


@contextmanager
def ours(algorithm: str, folder: Path) -> Iterator[Timing]:
    """Our orchestrator, whichever stepper it takes."""
    own = folder / algorithm
    own.mkdir()
    system = formation(own, STEP, STOP, algorithm, record=STOP).system
    yield lambda: system.execute(own / "run").seconds


@contextmanager
def libcosim(system: Formation) -> Iterator[Timing]:
    """libcosim; its first step initialises."""

    def run() -> float:
        with libcosim_execution(system, STEP) as (execution, _):
            done(execution.step(1))
            return seconds(lambda: done(execution.step(COUNT - 1)))

    yield run


@contextmanager
def ecos(system: Formation) -> Iterator[Timing]:
    """Ecos."""

    def run() -> float:
        with ecos_simulation(system, STEP) as simulation:
            return seconds(lambda: simulation.step(COUNT))

    yield run


@contextmanager
def fmpy(system: Formation) -> Iterator[Timing]:
    """A loop over FMPy's slaves."""

    def run() -> float:
        with ExitStack() as stack:
            loop = FmpyLoop(system, STEP, stack)
            return seconds(lambda: loop.advance(COUNT))

    yield run


def main(rounds: int) -> None:
    """Print the table."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        system = formation(folder, STEP, STOP)
        timings = {
            "Sightline, Jacobi": ours("jacobi", folder),
            "Sightline, Gauss-Seidel": ours("gauss-seidel", folder),
            "libcosim": libcosim(system),
            "Ecos": ecos(system),
            "FMPy loop": fmpy(system),
        }
        timed = {name: stack.enter_context(timing) for name, timing in timings.items()}
        taken: dict[str, list[float]] = {name: [] for name in timed}
        for _ in range(rounds):
            for name, timing in timed.items():
                taken[name].append(timing())
    table = Table(title=f"example 5.1, {len(system.fmus)} FMUs, {COUNT} steps, {rounds} rounds")
    for heading in ("tool", "s", "us per step", "ratio"):
        table.add_column(heading, justify="left" if heading == "tool" else "right")
    medians = {name: statistics.median(values) for name, values in taken.items()}
    for name, median in medians.items():
        ratio = median / medians["Sightline, Jacobi"]
        table.add_row(name, f"{median:.3f}", f"{median / COUNT * 1e6:.1f}", f"{ratio:.2f}")
    Console().print(table)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
