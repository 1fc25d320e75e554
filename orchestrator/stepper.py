"""The reference stepper: one set, one step and one get call per FMU and communication step.

Gauss-Seidel, for each FMU in order: copy its inputs from the array of values (already at t_n+1 if
their source stepped before, else at t_n), set, step from t_n to t_n+1, get. Jacobi: first all
copies and sets, then all steps, then all gets. t_n = start + n · step, never a sum of steps.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .fmi2 import Slave
from .log import WARNING
from .plan import Array, Plan, Unit

Copy = Callable[[], object]


class Moves:
    """What moves the values of one FMU: ``copy`` its inputs, ``set`` them, ``get`` its outputs."""

    def __init__(
        self, unit: Unit, slave: Slave, values: Array, clock: ctypes.c_double, step: float
    ) -> None:
        self.slave = slave
        self.copy = _copy(unit, values)
        self.set = slave.transfers(unit.inputs.blocks, values, read=False)
        self.get = slave.transfers(unit.outputs.blocks, values, read=True)
        self.step = slave.stepper(clock, step)
        self.inputs = values[unit.inputs.first:unit.inputs.last]
        self._unit, self._values = unit, values

    def write(self, time: float) -> None:
        """Copy and set the inputs. Raises RunError."""
        self.copy()
        for call in self.set:
            self.slave.check("setting inputs", call(), time)

    def write_known(self, time: float, known: NDArray[np.bool_]) -> None:
        """Copy and set the inputs; those whose source is not known yet keep their own value."""
        for call in self.slave.transfers(self._unit.inputs.blocks, self._values, read=True):
            self.slave.check("getting inputs", call(), time)
        own = self.inputs.copy()
        self.copy()
        unknown = ~known[self._unit.sources]
        self.inputs[unknown] = own[unknown]
        for call in self.set:
            self.slave.check("setting inputs", call(), time)
        known[self._unit.outputs.first:self._unit.outputs.last] = True

    def read(self, time: float) -> None:
        """Get the outputs. Raises RunError."""
        for call in self.get:
            self.slave.check("getting outputs", call(), time)


class PythonStepper:
    """Steps a plan. ``rows`` counts the rows recorded by the last :meth:`advance`."""

    def __init__(self, plan: Plan, slaves: Sequence[Slave], start: float, step: float) -> None:
        self.plan = plan
        self.start = start
        self.step = step
        self.values = np.zeros(plan.size)
        self.clock = ctypes.c_double(start)
        self.moves = [
            Moves(u, slaves[u.node], self.values, self.clock, step) for u in plan.units
        ]
        self.rows = 0
        self._one = self._jacobi if plan.jacobi else self._gauss_seidel

    def time(self, number: int) -> float:
        """The time after a number of steps."""
        return self.start + number * self.step

    def initialise(self) -> bool:
        """Carry outputs through the system until they rest, then leave initialisation mode.

        Returns False if they did not rest. Raises RunError.
        """
        rested = self._settle()
        for move in self.moves:
            move.slave.start()
        for move in self.moves:
            move.read(self.start)
        return rested

    def advance(self, first: int, last: int, stride: int, buffer: Array) -> None:
        """Take the steps from number ``first`` up to ``last``, recording every ``stride``.

        Raises RunError; the rows recorded until then stay in the buffer.
        """
        self.rows = 0
        recorded, values, one = self.plan.recorded, self.values, self._one
        for number in range(first, last):
            one(number)
            if (number + 1) % stride == 0:
                values.take(recorded, out=buffer[self.rows], mode="clip")
                self.rows += 1

    def _gauss_seidel(self, number: int) -> None:
        self.clock.value = time = self.start + number * self.step
        for move in self.moves:
            move.copy()
            for call in move.set:
                if (status := call()) > WARNING:
                    move.slave.check("setting inputs", status, time)
            if (status := move.step()) > WARNING:
                self._failed(move, status, number)
            for call in move.get:
                if (status := call()) > WARNING:
                    move.slave.check("getting outputs", status, time + self.step)

    def _jacobi(self, number: int) -> None:
        self.clock.value = time = self.start + number * self.step
        for move in self.moves:
            move.write(time)
        for move in self.moves:
            if (status := move.step()) > WARNING:
                self._failed(move, status, number)
        for move in self.moves:
            move.read(self.time(number + 1))

    def _failed(self, move: Moves, status: int, number: int) -> None:
        move.slave.check(f"the step of {self.step:g} s", status, self.time(number))

    def _settle(self) -> bool:
        known = np.zeros(self.plan.size, dtype=bool)
        for move in self.moves:
            move.write_known(self.start, known)
            move.read(self.start)
        for _ in range(len(self.moves) + 1):
            before = self.values.tobytes()
            for move in self.moves:
                move.write(self.start)
                move.read(self.start)
            if self.values.tobytes() == before:
                return True
        return False


def _copy(unit: Unit, values: Array) -> Copy:
    """The copy of an FMU's inputs within the array of values."""
    sources, gain, shift = unit.sources, unit.gain, unit.shift
    inputs = values[unit.inputs.first:unit.inputs.last]
    if not len(sources):
        return lambda: None
    if gain is None or shift is None:
        if np.all(np.diff(sources) == 1):
            return partial(np.copyto, inputs, values[sources[0]:sources[-1] + 1])

        def plain() -> None:
            values.take(sources, out=inputs, mode="clip")

        return plain

    def converting() -> None:
        values.take(sources, out=inputs, mode="clip")
        np.multiply(inputs, gain, out=inputs)
        np.add(inputs, shift, out=inputs)

    return converting
