"""Values that nobody should set: an error status with a message, or finite results; never NaN."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from ..driver import Driver, good
from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..session import Session
from ..subject import INTEGERS, Variable

BUDGET = 2.5  # s; all values if thorough
HUGE = 1.7976931348623157e308
FLOAT32 = 3.4028234663852886e38
REALS = (math.nan, math.inf, -math.inf, 5e-324, -0.0, 0.0, -1.0, 1e308, 1e30, 1e-300)


def special_values(variable: Variable) -> list[float]:
    """Values at and beyond the edges of a variable's type and limits."""
    edges = [m for m in (variable.min, variable.max) if math.isfinite(m)]
    if variable.real:
        largest = FLOAT32 if variable.type == "Float32" else HUGE
        beyond = [np.nextafter(variable.min, -math.inf), np.nextafter(variable.max, math.inf)]
        reals = [*REALS, largest, -largest, *edges,
                 *(float(b) for b in beyond if math.isfinite(b))]
        return [v for v in reals if not largest < abs(v) < math.inf]
    if variable.type == "Boolean":
        return [0.0, 1.0, 2.0, -1.0]
    low, high = INTEGERS[variable.type]
    values = {low, high, 0, -1, *(int(e) for e in edges), *(int(e) - 1 for e in edges),
              *(int(e) + 1 for e in edges)}
    kept = [v for v in values if low <= v <= high or variable.type == "Enumeration"]
    return [float(v) for v in sorted(kept) if abs(v) < 2**53]


def _trials(variables: Sequence[Variable]) -> Iterator[tuple[Variable, int, float]]:
    """Variable, element and value: first one element of every port, then the others."""
    seen: set[str] = set()
    later = []
    for variable in variables:
        for element in range(variable.size):
            trials = [(variable, element, v) for v in special_values(variable)]
            if variable.port in seen:
                later += trials
            else:
                seen.add(variable.port)
                yield from trials
    yield from later


class _Trial:
    """One value on one instance: how the FMU answers until a refusal or the end."""

    def __init__(self, session: Session, lab: Lab, notes: Notes, what: str) -> None:
        self.session, self.lab, self.notes, self.what = session, lab, notes, what
        self.driver: Driver = session.driver
        self.alive = True

    def did(self, status: int, action: str) -> bool:
        """Note a refusal without a message; whether to go on."""
        if good(status):
            return True
        self.alive = False
        self.notes.tried["refused"] += 1
        if not self.driver.log:
            self.notes.wrong(self.what, f"refused on {action} without a message",
                             "a message that names the variable")
        return False

    def stepped(self, status: int) -> bool:
        """Likewise for a step, in which the FMU may also ask for the end of the simulation."""
        if self.driver.ended(status):
            self.notes.tried["ends"] += 1
            return False
        return self.did(status, "the step")

    def read(self, when: str) -> bool:
        """Read everything; what is not finite must not come with status OK."""
        status, values = self.driver.get(self.lab.watched)
        if not self.did(status, f"reading {when}"):
            return False
        if not np.all(np.isfinite(values)):
            names = [n for v in self.lab.watched for n in v.elements]
            bad = [n for n, x in zip(names, values, strict=True) if not np.isfinite(x)]
            self.notes.wrong(self.what, f"{', '.join(bad[:4])} not finite {when}, with status OK",
                             "an error status and a message, or finite values")
            return False
        return True


def _fresh(lab: Lab, session: Session | None) -> Session:
    """The same instance, reset; or a new one where that does not help."""
    if session is not None and not session.driver.fatal and good(session.driver.reset()):
        session.driver.log.clear()
        return session
    if session is not None:
        session.driver.free()
    return lab.session("trial")


@check("inputs.running", "special values of inputs give an error with a message, or finite outputs",
       seconds=30.0)
def running(lab: Lab, notes: Notes) -> None:
    if not lab.subject.inputs:
        raise NotApplicable("the FMU has no numeric inputs")
    lab.must_run()
    session: Session | None = None
    began = time.monotonic()
    for variable, element, value in _trials(lab.subject.inputs):
        if time.monotonic() - began > BUDGET * lab.effort and not lab.thorough:
            break
        notes.tried["values"] += 1
        if not lab.trial(what := f"{variable.elements[element]} = {value:g}"):
            continue
        session = _fresh(lab, session)
        session.begin(inputs=lab.excitation.at(0))
        session.driver.log.clear()
        trial = _Trial(session, lab, notes, what)
        _status, values = session.driver.get([variable])
        values[element] = value
        if not trial.did(session.driver.set([variable], values), "setting"):
            continue
        if trial.read("after setting") and lab.interface == "cs":
            h, start = lab.subject.step, lab.subject.start_time
            if trial.stepped(session.driver.do_step(start, h)):
                trial.read("after the step")


@check("inputs.start", "special values of parameters and start values are answered likewise",
       seconds=30.0)
def start(lab: Lab, notes: Notes) -> None:
    variables = [v for v in lab.subject.settable_at_start() if v.causality != "input"]
    if not variables:
        raise NotApplicable("the FMU has no numeric parameters and no start values")
    lab.must_run()
    session: Session | None = None
    began = time.monotonic()
    for variable, element, value in _trials(variables):
        if time.monotonic() - began > BUDGET * lab.effort and not lab.thorough:
            break
        notes.tried["values"] += 1
        if not lab.trial(what := f"{variable.elements[element]} = {value:g}"):
            continue
        session = _fresh(lab, session)
        _initialise(lab, session, _Trial(session, lab, notes, what), variable, element, value)


def _initialise(
    lab: Lab, session: Session, trial: _Trial, variable: Variable, element: int, value: float
) -> None:
    driver, begin = session.driver, lab.subject.start_time
    values = np.zeros(variable.size) if variable.start is None else variable.start.copy()
    values[element] = value
    calls: tuple[tuple[Callable[[], int], str], ...] = (
        (lambda: driver.setup(begin), "setup"),
        (lambda: driver.set([variable], values), "setting"),
        (lambda: driver.set(lab.subject.inputs, lab.excitation.at(0)), "setting inputs"),
        (driver.enter_initialization, "entering initialisation"),
        (driver.exit_initialization, "leaving initialisation"),
    )
    for call, action in calls:
        if not trial.did(call(), action):
            return
    if not trial.read("after initialisation") or lab.interface == "me":
        return
    h = lab.subject.step
    if trial.stepped(driver.do_step(begin, h)):
        trial.read("after the step")
