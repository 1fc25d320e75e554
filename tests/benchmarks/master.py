"""Microseconds per communication step: a loop written in C, both steppers, a whole run.

Run from the project's folder: python -m tests.benchmarks.master
All run the same FMUs from the same start.
"""

from __future__ import annotations

import ctypes
import tempfile
import time
from contextlib import ExitStack
from functools import partial
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from sightline.orchestrator.fmi.log import RunLog
from sightline.orchestrator.stepping.compiled import CompiledStepper
from sightline.orchestrator.stepping.starting import load
from sightline.orchestrator.stepping.stepper import PythonStepper, Stepper
from sightline.orchestrator.system import System

from . import ring
from .c_loop import CLoop
from .rounds import table, timed

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_formation" / "system.toml"
ROUNDS = 7
C_LOOP, COMPILED, PYTHON = "C loop", "compiled stepper", "Python stepper"
WHOLE = "whole run: results file, progress, Ctrl-C"
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
        kind = PythonStepper if name == PYTHON else CompiledStepper
        stepper = started(system, kind, stack)
        rows = np.zeros((steps // stride + 1, len(system.plan.recorded)))
        if name == C_LOOP:
            loop = CLoop(stepper, folder)
            pointer = rows.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
            began = time.perf_counter()
            loop.run(steps, stride, pointer)
        else:
            if name == PYTHON:
                steps //= PYTHON_SHARE
            began = time.perf_counter()
            stepper.advance(0, steps, stride, rows)
        return (time.perf_counter() - began) / steps * 1e6, rows


def whole(system: System, folder: Path) -> float:
    """Microseconds per step of a run as users have it."""
    statistics = system.execute(folder / "out", lambda _: None)
    return statistics.seconds / statistics.steps * 1e6


def compare(title: str, system: System, folder: Path) -> Table:
    """All, in turn."""
    rows: dict[str, np.ndarray] = {}

    def timing(name: str) -> float:
        spent, rows[name] = measure(system, name, folder)
        return spent

    timings = {n: partial(timing, n) for n in (C_LOOP, COMPILED, PYTHON)}
    found = timed({**timings, WHOLE: partial(whole, system, folder)}, ROUNDS)
    assert np.array_equal(rows[C_LOOP], rows[COMPILED])
    return table(title, "µs per step", found, C_LOOP)


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
