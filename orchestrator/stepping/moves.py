"""What moves the values of one FMU between it and the array of values."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..fmi.slave import Slave
from ..schedule.plan import Array, Unit

UNIT = 1e-9  # how far the squared norm of a unit vector may be from one


class Moves:
    """``copy`` the inputs within the array, ``set`` them, ``get`` the outputs."""

    def __init__(self, unit: Unit, slave: Slave, values: Array) -> None:
        self.unit = unit
        self.slave = slave
        self.copy = _copy(unit, values)
        self.set_values = slave.transfers(unit.inputs.blocks, values, read=False)
        self.set = list(self.set_values)
        self.get = slave.transfers(unit.outputs.blocks, values, read=True)
        self.inputs = values[unit.inputs.first:unit.inputs.last]
        self._values = values
        if unit.course is not None:
            self._prepare_course()

    def write(self, time: float) -> None:
        """Copy and set the inputs. Raises RunError."""
        self.copy()
        self.put(time)

    def put(self, time: float) -> None:
        """Set the inputs as they are in the array. Raises RunError."""
        for call in self.set_values:
            self.slave.check("setting inputs", call(), time)

    def write_known(self, time: float, known: NDArray[np.bool_]) -> None:
        """Copy and set the inputs; those whose source is not known yet keep their own value."""
        for call in self.slave.transfers(self.unit.inputs.blocks, self._values, read=True):
            self.slave.check("getting inputs", call(), time)
        own = self.inputs.copy()
        self.copy()
        unknown = ~known[self.unit.sources]
        self.inputs[unknown] = own[unknown]
        self.put(time)
        known[self.unit.outputs.first:self.unit.outputs.last] = True

    def read(self, time: float) -> None:
        """Get the outputs. Raises RunError."""
        for call in self.get:
            self.slave.check("getting outputs", call(), time)

    def _prepare_course(self) -> None:
        course = self.unit.course
        assert course is not None
        count = len(course.inputs)
        self.weights = np.zeros((3, 3, count))
        self.polynomial = np.zeros((3, count))  # base, slope, curvature
        self.derivatives = np.zeros(2 * count)  # slopes, curvatures: what the FMU gets
        self.older = self._values[course.history:course.history + count]
        self.oldest = self._values[course.history + count:course.history + 2 * count]
        orders = [k for k in range(1, course.order + 1) for _ in range(count)]
        references = course.references * course.order
        self.set.append(self.slave.derive(references, orders, self.derivatives))

    def follow(self, width: float) -> None:
        """Turn the copied inputs into base, slope and curvature of a step; remember them."""
        assert self.unit.course is not None
        inputs = self.unit.course.inputs
        newest = self._values[inputs]
        for (a, b, c), out in zip(self.weights, self.polynomial, strict=True):
            out[:] = a * newest + b * self.older + c * self.oldest
        for first, count in self.unit.course.directions:
            self._end_on_sphere(newest, slice(first, first + count), width)
        self.oldest[:] = self.older
        self.older[:] = newest
        self._values[inputs] = self.polynomial[0]
        self.derivatives[:] = self.polynomial[1:].reshape(-1)

    def _end_on_sphere(self, newest: Array, some: slice, width: float) -> None:
        """Let inputs that form a unit vector form one at the end of the step too."""
        base, slope, curvature = (row[some] for row in self.polynomial)
        end = base + width * (slope + 0.5 * width * curvature)
        square = _square(end)
        if abs(_square(newest[some]) - 1.0) <= UNIT and square > 0.0:
            slope += (1.0 / math.sqrt(square) - 1.0) / width * end

    def follow_on(self, time: float) -> None:
        """The course from a time after the step's start on."""
        assert self.unit.course is not None
        base, slope, curvature = self.polynomial
        self._values[self.unit.course.inputs] = base + time * (slope + 0.5 * time * curvature)
        self.derivatives[:len(base)] = slope + time * curvature


def _square(vector: Array) -> float:
    """The squared norm, summed in the order in which the compiled loop does."""
    total = 0.0
    for element in vector.tolist():
        total += element * element
    return total


def _copy(unit: Unit, values: Array) -> Callable[[], object]:
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
