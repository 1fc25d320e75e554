"""Example 5.1 at 1 ms, from the same native FMU files, in several tools side by side.

Run from the project's folder: python -m tests.benchmarks.compare_tools [ROUNDS]
Only stepping is timed. Sightline and the loop in C record all outputs every 0.1 s, Sightline into
its file; the other tools record nothing. Needs libcosimpy and ecospy.
"""

from __future__ import annotations

import ctypes
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import numpy as np
from rich.console import Console

from sightline.orchestrator.fmi.log import RunLog
from sightline.orchestrator.stepping.compiled import CompiledStepper
from sightline.orchestrator.stepping.starting import start, stepper_class

from ..external.formation import Formation, formation
from ..external.tools import FmpyLoop, done, ecos_simulation, libcosim_execution
from .c_loop import CLoop
from .rounds import Timing, table, timed

STEP, RECORD = 0.001, 0.1  # s
COUNT = 200_000  # steps of what is fast: 200 s
SHORT = 10_000  # steps of what is slow


def microseconds(action: Callable[[], object], count: int) -> float:
    """What each of so many steps takes."""
    began = time.perf_counter()
    action()
    return (time.perf_counter() - began) / count * 1e6


@contextmanager
def c_loop(folder: Path) -> Iterator[Timing]:
    """The same calls as our Gauss-Seidel makes, written out in C."""
    own = folder / "c"
    own.mkdir()
    system = formation(own, STEP, COUNT * STEP, "gauss-seidel", RECORD).system
    rows = np.empty(((COUNT // 100 + 1), len(system.plan.recorded)))
    pointer = rows.ctypes.data_as(ctypes.POINTER(ctypes.c_double))

    def run() -> float:
        with ExitStack() as stack:
            simulation = system.loaded.config.simulation
            stepper, _ = start(system.graph, system.plan, simulation, RunLog(None), stack)
            loop = CLoop(stepper, own)
            return microseconds(lambda: loop.run(COUNT, round(RECORD / STEP), pointer), COUNT)

    yield run


@contextmanager
def ours(algorithm: str, folder: Path) -> Iterator[Timing]:
    """Our orchestrator's compiled loop."""
    assert stepper_class() is CompiledStepper, "the compiled loop was not built"
    own = folder / algorithm
    own.mkdir()
    system = formation(own, STEP, COUNT * STEP, algorithm, RECORD).system
    yield lambda: system.execute(own / "run").seconds / COUNT * 1e6


@contextmanager
def libcosim(system: Formation) -> Iterator[Timing]:
    """libcosim; its first step initialises."""

    def run() -> float:
        with libcosim_execution(system, STEP) as (execution, _):
            done(execution.step(1))
            return microseconds(lambda: done(execution.step(SHORT)), SHORT)

    yield run


@contextmanager
def ecos(system: Formation) -> Iterator[Timing]:
    """Ecos."""

    def run() -> float:
        with ecos_simulation(system, STEP) as simulation:
            return microseconds(lambda: simulation.step(SHORT), SHORT)

    yield run


@contextmanager
def fmpy(system: Formation) -> Iterator[Timing]:
    """A loop over FMPy's slaves."""

    def run() -> float:
        with ExitStack() as stack:
            loop = FmpyLoop(system, STEP, stack)
            return microseconds(lambda: loop.advance(SHORT), SHORT)

    yield run


def main(rounds: int) -> None:
    """Print the table."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory()))
        system = formation(folder, STEP, COUNT * STEP)
        tools = {
            "C loop": c_loop(folder),
            "Sightline": ours("gauss-seidel", folder),
            "Sightline, Jacobi": ours("jacobi", folder),
            "libcosim": libcosim(system),
            "Ecos": ecos(system),
            "FMPy loop": fmpy(system),
        }
        found = timed({n: stack.enter_context(tool) for n, tool in tools.items()}, rounds)
    title = f"example 5.1, {len(system.fmus)} FMUs, 1 ms, {rounds} rounds"
    Console().print(table(title, "µs per step", found, "C loop"))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
