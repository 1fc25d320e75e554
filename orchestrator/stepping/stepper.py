"""Steps a plan: the reference in Python; :mod:`.compiled` does the same over C pointers.

A communication step is the plan's acts in order. Gauss-Seidel, for each FMU: copy its inputs from
the array of values (already at t_n+1 if their source stepped before, else at t_n), set, step from
t_n to t_n+1, get. Jacobi: first all copies and sets, then all steps, then all gets. An FMU that
steps at every k-th communication point catches up from t_n+1-k: at its points all values are of
one instant. t_n = start + n · step, never a sum of steps.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from ..errors import each
from ..fmi.log import DISCARD, OK, WARNING
from ..fmi.slave import Slave
from ..schedule.plan import Act, Array, Plan
from .courses import weights
from .loops import LoopSolver, Tolerance
from .moves import Moves
from .startup import invent_past, pass_on, settle

HALVINGS = 20  # of a step that an FMU does not take


class Stepper:
    """What both steppers share. ``values`` with the number of the step is all they remember.

    ``rows`` counts the rows recorded by the last :meth:`advance`.
    """

    def __init__(
        self, plan: Plan, slaves: Sequence[Slave], start: float, step: float,
        tolerance: Tolerance | None = None,
    ) -> None:  # fmt: skip
        self.plan = plan
        self.slaves = slaves
        self.start = start
        self.step = step
        self.values = np.zeros(plan.size)
        self.moves = [Moves(u, slaves[u.node], self.values) for u in plan.units]
        self.loops = [
            LoopSolver(loop, self.moves, self.values, tolerance or Tolerance())
            for loop in plan.loops
        ]
        self.rows = 0
        self.free: tuple[float, float] | None = None  # time and width of a step off the grid
        self.equidistant()

    def time(self, number: int) -> float:
        """The time after a number of steps."""
        return self.start + number * self.step

    def span(self, move: Moves, number: int) -> tuple[float, float]:
        """The start and the width of an FMU's step that ends the communication step."""
        if self.free is not None:
            return self.free
        every = move.unit.every
        return self.start + (number + 1 - every) * self.step, every * self.step

    def initialise(self, steps: int) -> bool:
        """Make the start consistent for a run of so many steps; leave initialisation mode.

        Returns False if outputs did not come to rest. Raises RunError.
        """
        rested = settle(self)
        answers = [loop.responds(self.start) for loop in self.loops]
        each(move.slave.start for move in self.moves)
        for move in self.moves:
            move.read(self.start)
        for loop, expected in zip(self.loops, answers, strict=True):
            for number, responds in enumerate(loop.responds(self.start)):
                if expected[number] and not responds:
                    raise loop.refuse(number, self.start)
        if self.loops:
            pass_on(self)
        invent_past(self, steps)
        return rested

    def advance(self, first: int, last: int, stride: int, buffer: Array) -> None:
        """Take the steps from number ``first`` up to ``last``, recording every ``stride``.

        Raises RunError; the rows recorded until then stay in the buffer.
        """
        raise NotImplementedError

    def take(self, time: float, width: float) -> None:
        """Take one step off the grid, of all FMUs. Raises RunError."""
        self.free = time, width
        try:
            self.advance(0, 1, 2, np.empty((1, 0)))
        finally:
            self.free = None

    def equidistant(self) -> None:
        """Let inputs follow their courses through equidistant instants."""
        for move in self.moves:
            if (course := move.unit.course) is not None:
                width = move.unit.every * self.step
                newest = width - np.array(course.newest) * self.step
                nodes = newest - width * np.arange(3.0)[:, None]
                move.weights[:] = weights(course.order, nodes)

    def bend(self, instants: Sequence[float]) -> None:
        """Let inputs follow their courses through these instants, counted from the step's start.

        ``instants``: the end of the step, its start, and the points before it.
        """
        for move in self.moves:
            if (course := move.unit.course) is not None:
                late = np.array([n > 0 for n in course.newest], dtype=int)
                nodes = np.array([[instants[k + i] for i in late] for k in range(3)])
                move.weights[:] = weights(course.order, nodes)

    def refuse(self, move: Moves, status: int, time: float, width: float) -> None:
        """Go on after a step that was discarded, in smaller steps. Raises RunError."""
        slave, end, part = move.slave, time + width, width
        near = 1e-9 * width
        slave.time = time
        for _ in range(HALVINGS):
            if status != DISCARD:
                slave.check(f"the step of {width:g} s", status, time)
            reached = slave.reached()
            if reached is None or reached < time - near or not slave.fmu.variable_step:
                break
            if reached >= end - near:
                return
            time, part = reached, part / 2
            status = OK
            while status <= WARNING and time < end - near:
                part = min(part, end - time)
                slave.time = time
                status = slave.step(time, part)
                time = time + part if status <= WARNING else time
            if status <= WARNING:
                return
        slave.check(f"the step of {width:g} s", status, time)


class PythonStepper(Stepper):
    """The reference."""

    def advance(self, first: int, last: int, stride: int, buffer: Array) -> None:
        """See :meth:`Stepper.advance`."""
        self.rows = 0
        acts = self._program()
        for number in range(first, last):
            for every, act in acts:
                if (number + 1) % every == 0 or self.free is not None:
                    act(number)
            if (number + 1) % stride == 0:
                self.values.take(self.plan.recorded, out=buffer[self.rows], mode="clip")
                self.rows += 1

    def _program(self) -> list[tuple[int, Callable[[int], None]]]:
        does = {Act.WRITE: self._write, Act.STEP: self._step, Act.READ: self._read,
                Act.UPDATE: self._update}  # fmt: skip
        program: list[tuple[int, Callable[[int], None]]] = []
        for act, which in self.plan.acts:
            if act is Act.SOLVE:
                every = self.plan.units[self.plan.loops[which].units[0]].every
                program.append((every, partial(self._solve, self.loops[which])))
            else:
                move = self.moves[which]
                program.append((move.unit.every, partial(does[act], move)))
        return program

    def _write(self, move: Moves, number: int) -> None:
        move.copy()
        if move.unit.course is not None:
            move.follow(self.span(move, number)[1])
        self._put(move, number)

    def _put(self, move: Moves, number: int) -> None:
        for call in move.set:
            if (status := call()) > WARNING:
                move.slave.check("setting inputs", status, self.span(move, number)[0])

    def _step(self, move: Moves, number: int, first: int = 0) -> None:
        time, width = self.span(move, number)
        parts = move.unit.parts
        part = width / parts
        for i in range(first, parts):
            if i and move.unit.course is not None:
                move.follow_on(i * part)
                self._put(move, number)
            if (status := move.slave.step(time + i * part, part)) > WARNING:
                self.refuse(move, status, time + i * part, part)

    def _read(self, move: Moves, number: int) -> None:
        for call in move.get:
            if (status := call()) > WARNING:
                time, width = self.span(move, number)
                move.slave.check("getting outputs", status, time + width)

    def _update(self, move: Moves, number: int) -> None:
        move.copy()
        for call in move.set_values:
            if (status := call()) > WARNING:
                time, width = self.span(move, number)
                move.slave.check("setting inputs", status, time + width)

    def _solve(self, loop: LoopSolver, number: int) -> None:
        loop.solve(sum(self.span(loop.moves[0], number)))
