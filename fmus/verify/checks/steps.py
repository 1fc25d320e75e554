"""Communication steps: of any size, off the grid, across sample instants, ten million of them."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence

import numpy as np

from ..driver import good, status_name
from ..lab import Lab, deviation
from ..registry import NotApplicable, Notes, check
from ..session import Ended, Refused, Session
from ..subject import Array, names_of

LENGTH = 20  # usual steps
TOLERANCE = 1e-3  # of a value's size: solvers may step differently
FLOOR = 1e-6  # values below count as of this size
MANY = 10_000_000
PARTS = 20  # large steps for the same time
BUDGET = 0.5  # s of many small steps


def _require(lab: Lab) -> None:
    if lab.interface == "me":
        raise NotApplicable("the FMU offers no co-simulation")
    if not lab.subject.variable_step:
        raise NotApplicable("communication steps have a fixed size")


@check("steps.partition", "many small steps lead where one large step leads, on and off the grid")
def partition(lab: Lab, notes: Notes) -> None:
    _require(lab)
    rng = np.random.default_rng(lab.seed)
    cuts = np.sort(rng.random(3 * LENGTH))
    near = np.arange(1, LENGTH) / LENGTH  # around every point of the grid
    plans = {
        "one step": np.array([]),
        "usual steps": near,
        "steps of a tenth": np.arange(1, 10 * LENGTH) / (10 * LENGTH),
        "steps of 0.7": np.arange(0.7 / LENGTH, 1.0, 0.7 / LENGTH),
        "random steps": cuts,
        "steps that straddle the grid": np.sort(np.concatenate([near - 1e-4, near + 1e-4])),
        "steps that miss the grid by rounding": np.sort(
            np.concatenate([near * (1 - 1e-15), near * (1 + 1e-15) + 1e-6])),
    }  # fmt: skip
    expected = _end(lab, plans["one step"])
    for name, points in plans.items():
        notes.tried["partitions"] += 1
        _compare(lab, notes, name, _end(lab, points), expected)


def _end(lab: Lab, points: Array) -> Array:
    """The values at the end of the length, with steps between points given as fractions."""
    session = lab.begun()
    length, start = LENGTH * lab.subject.step, lab.subject.start_time
    times = [start, *(start + length * points), start + length]
    for a, b in itertools.pairwise(times):
        if b > a:
            session.step(b - a, a)
    return session.read(lab.watched)


def _compare(lab: Lab, notes: Notes, where: str, found: Array, expected: Array) -> None:
    names = names_of(lab.watched)
    exact = np.repeat([v.variability == "discrete" and not v.real for v in lab.watched],
                      [v.size for v in lab.watched])
    floor = np.where(exact, 0.0, FLOOR)
    error, column = deviation(found[None], expected[None], floor)
    if not error <= TOLERANCE:
        notes.wrong(where, f"{names[column]} = {found[column]:.9g}", f"{expected[column]:.9g}")


@check("steps.drift", "ten million steps of time end where they should")
def drift(lab: Lab, notes: Notes) -> None:
    _require(lab)
    h, origin = lab.subject.step, lab.subject.start_time
    count = MANY if lab.thorough else _affordable(lab, h)
    count -= count % PARTS
    first = MANY - count
    session = lab.session().begin(origin + first * h, inputs=lab.excitation.base)
    # the last steps of ten million, where adding up loses most; all of them if thorough
    step = session.driver.stepper(h)
    for k in range(first, MANY):
        status = step(origin + k * h)
        if session.driver.ended(status):
            raise Ended(origin + (k + 1) * h)
        if not good(status):
            if not _reaches(lab, origin + first * h, origin + (k + 1) * h):
                raise NotApplicable("the model itself ends before")
            notes.wrong(f"step {k} from {origin + k * h:.9g} s", status_name(status), "OK")
            return
    notes.tried["steps"] = count
    end = origin + MANY * h
    told = session.driver.last_time()
    if told is not None and not abs(told - end) <= _slack(lab, end):
        notes.wrong("internal time at the end", f"{told:.17g}", f"{end:.17g}",
                    "end each step at its communication point plus its size; do not add up")
    _compare(lab, notes, "against few large steps", session.read(lab.watched),
             _far(lab, origin + first * h, end, PARTS).read(lab.watched))


def _slack(lab: Lab, time: float) -> float:
    """How far the internal time may be from that of the communication point, in s.

    FMI 2.0, 4.2.2: not at all, the slave integrates exactly to it. FMI 3.0, 4.2.1: a solver with
    steps of its own may not reach it; but if it does so at first, it must do so at the end.
    """
    may_lag = lab.subject.version == 3 and _lags(lab)
    return _rounding(time) + (lab.subject.step if may_lag else 0.0)


def _rounding(time: float) -> float:
    return 8 * math.ulp(time) + 1e-12


def _lags(lab: Lab) -> bool:
    """Whether the internal time misses a communication point in the first steps."""
    session, h = lab.begun(), lab.subject.step
    for k in range(LENGTH):
        session.step(h, lab.subject.start_time + k * h)
        told, point = session.driver.last_time(), lab.subject.start_time + (k + 1) * h
        if told is not None and not abs(told - point) <= _rounding(point):
            return True
    return False


def _affordable(lab: Lab, h: float) -> int:
    """Number of small steps within the budget."""
    session = lab.begun()
    step = session.driver.stepper(h)
    began = time.perf_counter()
    for k in range(50):
        step(lab.subject.start_time + k * h)
    each = (time.perf_counter() - began) / 50
    return int(min(MANY, max(BUDGET * lab.effort / each, 500)))


def _far(lab: Lab, start: float, end: float, parts: int) -> Session:
    session = lab.session("far").begin(start, inputs=lab.excitation.base)
    times: Sequence[float] = [start + (end - start) * i / parts for i in range(parts)] + [end]
    for a, b in itertools.pairwise(times):
        session.step(b - a, a)
    return session


def _reaches(lab: Lab, start: float, end: float) -> bool:
    try:
        _far(lab, start, end, 1)
    except (Refused, Ended):
        return False
    return True
