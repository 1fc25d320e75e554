"""Brings a system to life: FMUs unpacked, loaded and initialised, a stepper over them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from functools import partial
from pathlib import Path

from ..config.model import Simulation
from ..errors import RunError, each
from ..fmi import arithmetic, extraction
from ..fmi.fmi2 import Slave2
from ..fmi.fmi3 import Slave3
from ..fmi.log import RunLog
from ..fmi.slave import Slave
from ..isolation.process import Process
from ..isolation.slave import Isolated, values_of
from ..schedule.plan import Plan
from ..wiring.graph import Node, SystemGraph
from .loops import Tolerance
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
    graph: SystemGraph, plan: Plan, simulation: Simulation, log: RunLog, stack: ExitStack,
    stop: float | None = None,
) -> tuple[Stepper, bool]:  # fmt: skip
    """A stepper at the start of a run, and whether outputs came to rest there.

    ``stop``: where the run ends for certain, which FMUs are told. The stack frees all FMUs.
    Raises RunError if an FMU fails, FmuError if an archive is damaged.
    """
    slaves = load(graph, log, stack)
    tolerance = Tolerance(simulation.loop_tolerance, simulation.loop_iterations)
    with arithmetic.kept():
        each(
            partial(slave.initialise, node.settings, simulation.start_time, stop)
            for node, slave in zip(graph.nodes, slaves, strict=True)
        )
        stepper = stepper_class()(plan, slaves, simulation.start_time, simulation.step, tolerance)
        return stepper, stepper.initialise(simulation.steps)


def load(graph: SystemGraph, log: RunLog, stack: ExitStack) -> list[Slave]:
    """All FMUs instantiated, each archive unpacked once; the stack frees them."""
    stack.enter_context(_python_as_it_was(extraction.root()))
    stack.callback(log.close)
    folders: dict[Path, Path] = {}
    slaves: list[Slave] = []
    processes = {n.name: _process(n, stack) for n in graph.nodes if n.isolated}  # start meanwhile
    alone: dict[Path, str] = {}
    for node in graph.nodes:
        path = node.fmu.path
        if path not in folders:
            folders[path] = extraction.unpacked(path)
        slave: Slave
        if node.isolated:
            slave = Isolated(node, folders[path], log, processes[node.name])
        else:
            if node.fmu.only_once and path in alone:
                what = f"its FMU allows one instance in a process, {alone[path]} is another"
                remedy = "isolate = true gives it a process of its own"
                raise RunError(node.name, 0.0, "loading", "error", f"{what}; {remedy}")
            alone[path] = node.name
            with arithmetic.kept():
                slave = (Slave3 if node.fmu.version_3 else Slave2)(node, folders[path], log)
        stack.callback(slave.free)
        slaves.append(slave)
    return slaves


def _process(node: Node, stack: ExitStack) -> Process:
    """The process of an isolated FMU; the stack ends it. Raises RunError."""
    try:
        process = Process(node.time_limit, values_of(node.fmu))
    except OSError as error:
        raise RunError(node.name, 0.0, "the start of its process", "error", str(error)) from None
    stack.callback(process.close)
    return process


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
