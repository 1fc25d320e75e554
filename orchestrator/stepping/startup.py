"""The start of a run: outputs carried through the system to rest; the past that courses need.

A polynomial of order k through past values needs values before the start. They are found by trial:
take the first k steps, continue the course that the inputs took backwards, restore all FMUs, and
try again; each round gains an order. Without it the first step would hold its inputs, and leave an
error of order h² however exact the rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np

from ..schedule.plan import Act, Array
from .courses import through

if TYPE_CHECKING:
    from .stepper import Stepper


def settle(stepper: Stepper) -> bool:
    """Carry outputs through the system, in initialisation mode. Returns False if they do not rest.

    Raises RunError, LoopError.
    """
    known = np.zeros(stepper.plan.size, dtype=bool)
    for move in stepper.moves:
        move.write_known(stepper.start, known)
        move.read(stepper.start)
    for _ in range(len(stepper.moves) + 1):
        before = stepper.values.copy()
        pass_on(stepper)
        change = np.abs(stepper.values - before)
        near = 1e-12 * np.abs(before) if stepper.loops else 0.0
        if np.all(change <= near) or np.array_equal(stepper.values, before, equal_nan=True):
            return True
    return False


def pass_on(stepper: Stepper) -> None:
    """Carry outputs through the system once, as in a step but without one. Raises RunError."""
    for act, which in stepper.plan.acts:
        if act in (Act.WRITE, Act.UPDATE):
            stepper.moves[which].write(stepper.start)
        elif act is Act.READ:
            stepper.moves[which].read(stepper.start)
        elif act is Act.SOLVE:
            stepper.loops[which].solve(stepper.start)


def invent_past(stepper: Stepper, steps: int) -> None:
    """Set the histories of all courses for a run of so many steps. Raises RunError."""
    followed = [m for m in stepper.moves if m.unit.course is not None]
    if not followed:
        return
    for move in followed:
        move.copy()
        course = move.unit.course
        assert course is not None
        move.older[:] = move.oldest[:] = stepper.values[course.inputs]
    order = stepper.plan.order
    period = math.lcm(*(m.unit.every for m in stepper.moves))
    if order * period > steps or not all(s.fmu.can_restore for s in stepper.slaves):
        return
    with saved(stepper) as restore:
        for _ in range(order + 1):
            past = _trial(stepper, order, period)
            restore()
            for move, (older, oldest) in zip(followed, past, strict=True):
                move.older[:], move.oldest[:] = older, oldest


def _trial(stepper: Stepper, order: int, period: int) -> list[tuple[Array, Array]]:
    """What the histories would be if the first steps had gone on before the start."""
    followed = [m for m in stepper.moves if m.unit.course is not None]
    none = np.empty((1, 0))
    seen = [[_inputs(stepper, i)] for i in range(len(followed))]
    for number in range(order * period):
        stepper.advance(number, number + 1, number + 2, none)
        for i, move in enumerate(followed):
            if (number + 1) % move.unit.every == 0 and len(seen[i]) <= order:
                seen[i].append(_inputs(stepper, i))
    past = []
    for move, values in zip(followed, seen, strict=True):
        course, width = move.unit.course, move.unit.every * stepper.step
        assert course is not None
        newest = width - np.array(course.newest) * stepper.step
        instants = [k * width for k in range(len(values))]
        past.append((through(instants, values, newest - width),
                     through(instants, values, newest - 2 * width)))
    return past


def _inputs(stepper: Stepper, number: int) -> Array:
    """The inputs of a followed FMU at the instant reached; they stay as they are."""
    move = [m for m in stepper.moves if m.unit.course is not None][number]
    course = move.unit.course
    assert course is not None
    before = move.inputs.copy()
    move.copy()
    values = stepper.values[course.inputs]
    move.inputs[:] = before
    return values


@contextmanager
def saved(stepper: Stepper) -> Iterator[Restore]:
    """The state of all FMUs and values; calling it goes back to them."""
    restore = Restore(stepper)
    try:
        yield restore
    finally:
        restore.release()


class Restore:
    """A state of the whole system. Raises RunError if an FMU refuses."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper = stepper
        self._values = stepper.values.copy()
        self._states = [(s, s.save()) for s in stepper.slaves]

    def __call__(self) -> None:
        for slave, state in self._states:
            slave.restore(state)
        self._stepper.values[:] = self._values

    def release(self) -> None:
        """Forget the states."""
        for slave, state in self._states:
            slave.release(state)
