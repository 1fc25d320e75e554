"""Runs a compiled system: starts the FMUs, steps, records, and leaves nothing behind."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import Any

from .config.model import Config, Simulation
from .errors import RunError
from .fmi.log import RunLog
from .fmi.sampling import sample_period
from .results.file import ResultsWriter
from .schedule.plan import Plan
from .stepping.adaptive import Control, grid
from .stepping.keeper import Keeper
from .stepping.recorder import Recorder
from .stepping.starting import start
from .stepping.stepper import Stepper
from .wiring.graph import SystemGraph

UNSTABLE = (
    'under algorithm = "jacobi" inputs are extrapolated, through every FMU of a chain again: this '
    'is unstable for all but small steps; set algorithm = "gauss-seidel", coupling = "hold" or a '
    "smaller step"
)
GLANCE = 0.1  # s between looks at progress and interrupts


class Interrupted(Exception):
    """The user stopped the run; what was recorded until then is in the results."""

    def __init__(self, time: float) -> None:
        super().__init__(f"stopped at t = {time:.6g} s")
        self.time = time


@dataclass(frozen=True)
class Statistics:
    """What a finished run did. ``rejected`` counts steps that error control took again."""

    steps: int
    seconds: float
    rested: bool
    rejected: int = 0


def run(
    graph: SystemGraph,
    plan: Plan,
    config: Config,
    writer: ResultsWriter,
    log: RunLog,
    show: Callable[[float], None] = lambda _: None,
    keeper: Keeper | None = None,
) -> Statistics:
    """Run from start to stop time, or with a ``keeper`` from where it resumes.

    Raises RunError if an FMU fails, FmuError if an archive is damaged, Interrupted on Ctrl-C or
    SIGTERM, OSError if results cannot be written; what was recorded until then is written.
    """
    simulation = config.simulation
    with ExitStack() as stack:
        stack.enter_context(_advice(simulation))
        stopped = stack.enter_context(_interrupts())
        keeper = keeper or Keeper()
        stop = None if keeper.goes_on else simulation.stop_time
        stepper, rested = start(graph, plan, simulation, log, stack, stop)
        recorder = Recorder(stepper, writer, config.record_stride)
        number = keeper.begin(stepper, recorder)
        began = time.perf_counter()
        steps, rejected = simulation.steps, 0
        if simulation.adaptive:
            control = Control(stepper, simulation.tolerance, plan.smooth)
            instants = _instants(graph, plan, config)
            keeper.control = control
            keeper.put_control()
            instants = (i for i in instants if i[0] > control.past[0])
            everything = config.record.every is None
            _adapt(control, recorder, instants, everything, stopped, show, keeper)
            steps, rejected = control.accepted, control.rejected
        else:
            _loop(stepper, recorder, number, steps, stopped, show, keeper)
        writer.complete(steps, rejected)
        return Statistics(steps, time.perf_counter() - began, rested, rejected)


@contextmanager
def _advice(simulation: Simulation) -> Iterator[None]:
    """Adds to an error what may be the reason."""
    try:
        yield
    except RunError as error:
        if simulation.algorithm == "jacobi" and simulation.coupling != "hold":
            error.add_note(UNSTABLE)
        raise


def _instants(
    graph: SystemGraph, plan: Plan, config: Config
) -> Iterator[tuple[float, bool]]:
    """Instants that steps must not pass, and whether they are recorded."""
    simulation = config.simulation
    step = simulation.step
    periods = {sample_period(node) for node in graph.nodes} - {0.0}
    periods |= {u.every * step for u in plan.units if u.every > 1}
    records = [] if config.record.every is None else [config.record.every]
    return grid(simulation.start_time, simulation.stop_time, records, sorted(periods))


def _adapt(
    control: Control,
    recorder: Recorder,
    instants: Iterator[tuple[float, bool]],
    everything: bool,
    stopped: threading.Event,
    show: Callable[[float], None],
    keeper: Keeper,
) -> None:
    """Step from instant to instant, recording those of the records, or every step."""
    try:
        for instant, recorded in instants:
            for reached in control.reach(instant):
                if everything or (recorded and reached == instant):
                    recorder.add(reached)
                keeper.reached(control.accepted, reached)
                if stopped.is_set():
                    keeper.keep(control.accepted)
                    raise Interrupted(reached)
                show(reached)
    finally:
        recorder.flush()


def _loop(
    stepper: Stepper,
    recorder: Recorder,
    number: int,
    steps: int,
    stopped: threading.Event,
    show: Callable[[float], None],
    keeper: Keeper,
) -> None:
    """Step in parts that last about as long as a glance, so that looking costs nothing."""
    part = 1
    while number < steps:
        room = min(recorder.room(number), keeper.room(number))
        last = min(number + part, number + room, steps)
        began = time.perf_counter()
        try:
            recorder.advance(number, last)
        except BaseException:
            recorder.flush()
            raise
        spent = time.perf_counter() - began
        part = max(1, min(2 * part, int((last - number) * GLANCE / max(spent, 1e-9))))
        number = last
        keeper.reached(number, stepper.time(number))
        if stopped.is_set() and number < steps:
            recorder.flush()
            keeper.keep(number)
            raise Interrupted(stepper.time(number))
        show(stepper.time(number))
    recorder.flush()


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """Ctrl-C or a request to terminate sets an event instead of breaking into an FMU.

    A second one breaks.
    """
    stopped = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stopped
        return

    def stop(number: int, frame: Any) -> None:
        if stopped.is_set():
            signal.default_int_handler(number, frame)
        stopped.set()

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield stopped
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
