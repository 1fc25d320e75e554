"""Brings a system to life: FMUs unpacked, loaded and initialised, a stepper over them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from . import extraction
from .config import Simulation
from .errors import RunError
from .fmi2 import Slave2
from .fmi3 import Slave3
from .graph import SystemGraph
from .log import RunLog
from .loops import Tolerance
from .plan import Plan
from .slave import Slave
from .stepper import PythonStepper, Stepper

STEPPER = "SIGHTLINE_STEPPER"  # environment variable: python or compiled


def stepper_class() -> type[Stepper]:
    """The compiled stepper where it was built, unless the environment asks for Python's."""
    wanted = os.environ.get(STEPPER, "")
    if wanted == "python":
        return PythonStepper
    try:
        from .compiled import CompiledStepper
    except ImportError:
        if wanted == "compiled":
            raise
        return PythonStepper
    return CompiledStepper


def start(
    graph: SystemGraph, plan: Plan, simulation: Simulation, log: RunLog, stack: ExitStack
) -> tuple[Stepper, bool]:
    """A stepper at the start of a run, and whether outputs came to rest there.

    The stack frees all FMUs. Raises RunError if an FMU fails, FmuError if an archive is damaged.
    """
    slaves = load(graph, log, stack)
    for node, slave in zip(graph.nodes, slaves, strict=True):
        slave.initialise(node.settings, simulation.start_time, simulation.stop_time)
    tolerance = Tolerance(simulation.loop_tolerance, simulation.loop_iterations)
    stepper = stepper_class()(plan, slaves, simulation.start_time, simulation.step, tolerance)
    return stepper, stepper.initialise(simulation.steps)


def load(graph: SystemGraph, log: RunLog, stack: ExitStack) -> list[Slave]:
    """All FMUs instantiated, each archive unpacked once; the stack frees them."""
    stack.enter_context(_python_as_it_was(extraction.root()))
    stack.callback(log.close)
    folders: dict[Path, Path] = {}
    slaves: list[Slave] = []
    alone: dict[Path, str] = {}
    for node in graph.nodes:
        path = node.fmu.path
        if path not in folders:
            folders[path] = extraction.unpacked(path)
        if node.fmu.only_once and path in alone:
            what = f"its FMU allows one instance in a process, {alone[path]} is another"
            raise RunError(node.name, 0.0, "loading", "error", what)
        alone[path] = node.name
        slave = (Slave3 if node.fmu.version_3 else Slave2)(node, folders[path], log)
        stack.callback(slave.free)
        slaves.append(slave)
    return slaves


@contextmanager
def _python_as_it_was(root: Path) -> Iterator[None]:
    """Python FMUs run in this interpreter and import from where they were unpacked: undo that."""
    path = list(sys.path)
    try:
        yield
    finally:
        sys.path[:] = path
        for name, module in list(sys.modules.items()):
            if str(getattr(module, "__file__", None) or "").startswith(str(root)):
                del sys.modules[name]
