"""Runs a compiled system: starts the FMUs, steps, records, and leaves nothing behind."""

from __future__ import annotations

import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from . import archive
from .config import Simulation
from .fmi2 import Slave
from .graph import SystemGraph
from .log import RunLog
from .plan import Array, Plan
from .results import ResultsWriter
from .stepper import PythonStepper

ROWS = 1000  # rows in memory before they are written
FLUSH = 1.0  # s between writes
GLANCE = 0.1  # s between looks at progress and interrupts


class Interrupted(Exception):
    """The user stopped the run; what was recorded until then is in the results."""

    def __init__(self, time: float) -> None:
        super().__init__(f"stopped at t = {time:.6g} s")
        self.time = time


@dataclass(frozen=True)
class Statistics:
    """What a finished run did."""

    steps: int
    seconds: float
    rested: bool


def run(
    graph: SystemGraph,
    plan: Plan,
    simulation: Simulation,
    stride: int,
    writer: ResultsWriter,
    log: RunLog,
    show: Callable[[float], None] = lambda _: None,
) -> Statistics:
    """Run from start to stop time.

    Raises RunError if an FMU fails, FmuError if an archive is damaged, Interrupted on Ctrl-C; what
    was recorded until then is written.
    """
    with ExitStack() as stack:
        slaves = _slaves(graph, log, stack)
        for node, slave in zip(graph.nodes, slaves, strict=True):
            slave.initialise(node.settings, simulation.start_time, simulation.stop_time)
        stepper = PythonStepper(plan, slaves, simulation.start_time, simulation.step)
        rested = stepper.initialise()
        recorder = _Recorder(stepper, writer, stride)
        recorder.first()
        stopped = stack.enter_context(_interrupts())
        began = time.perf_counter()
        _loop(stepper, recorder, simulation.steps, stopped, show)
        writer.complete()
        return Statistics(simulation.steps, time.perf_counter() - began, rested)


def _loop(
    stepper: PythonStepper,
    recorder: _Recorder,
    steps: int,
    stopped: threading.Event,
    show: Callable[[float], None],
) -> None:
    """Step in parts that last about as long as a glance, so that looking costs nothing."""
    number, part = 0, 1
    while number < steps:
        last = min(number + part, number + recorder.room(number), steps)
        began = time.perf_counter()
        try:
            recorder.advance(number, last)
        except BaseException:
            recorder.flush()
            raise
        spent = time.perf_counter() - began
        part = max(1, min(2 * part, int((last - number) * GLANCE / max(spent, 1e-9))))
        number = last
        if stopped.is_set() and number < steps:
            recorder.flush()
            raise Interrupted(stepper.time(number))
        show(stepper.time(number))
    recorder.flush()


class _Recorder:
    """Keeps rows until they are written."""

    def __init__(self, stepper: PythonStepper, writer: ResultsWriter, stride: int) -> None:
        self.stepper = stepper
        self.writer = writer
        self.stride = stride
        self.rows: Array = np.zeros((ROWS, len(stepper.plan.recorded)))
        self.times: Array = np.zeros(ROWS)
        self.count = 0
        self.written = time.perf_counter()

    def first(self) -> None:
        """Record the start and write it, so that even a run that fails at once leaves a row."""
        self.stepper.values.take(self.stepper.plan.recorded, out=self.rows[0], mode="clip")
        self.times[0] = self.stepper.time(0)
        self.count = 1
        self.flush()

    def room(self, number: int) -> int:
        """How many steps may be taken from here before rows must be written."""
        return (ROWS - self.count) * self.stride - number % self.stride

    def advance(self, first: int, last: int) -> None:
        """Take steps; write if it is time to."""
        try:
            self.stepper.advance(first, last, self.stride, self.rows[self.count:])
        finally:
            row = first // self.stride + 1
            for i in range(self.stepper.rows):
                self.times[self.count + i] = self.stepper.time((row + i) * self.stride)
            self.count += self.stepper.rows
        if self.count == ROWS or time.perf_counter() - self.written > FLUSH:
            self.flush()

    def flush(self) -> None:
        """Write what is in memory."""
        self.writer.append(self.times[:self.count], self.rows[:self.count])
        self.count = 0
        self.written = time.perf_counter()


def _slaves(graph: SystemGraph, log: RunLog, stack: ExitStack) -> list[Slave]:
    """All FMUs loaded, each archive unpacked once; the stack frees and removes them."""
    root = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="sightline-")))
    stack.enter_context(_python_as_it_was(root))
    stack.callback(log.close)
    folders: dict[Path, Path] = {}
    slaves = []
    for node in graph.nodes:
        if node.fmu.path not in folders:
            folders[node.fmu.path] = root / str(len(folders))
            archive.extract(node.fmu, folders[node.fmu.path])
        slave = Slave(node, folders[node.fmu.path], log)
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


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """Ctrl-C sets an event instead of breaking into an FMU; a second one breaks."""
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped
        return

    def stop(number: int, frame: Any) -> None:
        if stopped.is_set():
            signal.default_int_handler(number, frame)
        stopped.set()

    before = signal.signal(signal.SIGINT, stop)
    try:
        yield stopped
    finally:
        signal.signal(signal.SIGINT, before)
