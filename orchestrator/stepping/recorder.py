"""Keeps rows of results in memory until they are written."""

from __future__ import annotations

import time
from collections.abc import Sequence

import numpy as np

from ..errors import RunError
from ..results.file import ResultsWriter
from ..schedule.plan import Array
from .finite import Watch
from .stepper import Stepper

ROWS = 1000  # rows in memory before they are written
FLUSH = 1.0  # s between writes


class Recorder:
    """Records a stepper's values every ``stride`` steps."""

    def __init__(self, stepper: Stepper, writer: ResultsWriter, stride: int) -> None:
        self.stepper = stepper
        self.writer = writer
        self.stride = stride
        self.watch = Watch(stepper)
        self.rows: Array = np.zeros((ROWS, len(stepper.plan.recorded)))
        self.times: Array = np.zeros(ROWS)
        self.count = 0
        self.written = time.perf_counter()

    def first(self) -> None:
        """Record the start and write it, so that even a run that fails at once leaves a row."""
        self.add(self.stepper.time(0))
        self.flush()

    def add(self, instant: float) -> None:
        """Record the present values."""
        stepper = self.stepper
        stepper.values.take(stepper.plan.recorded, out=self.rows[self.count], mode="clip")
        self._took([instant])
        self.watch.look(instant)

    def room(self, number: int) -> int:
        """How many steps may be taken from here before rows must be written."""
        return (ROWS - self.count) * self.stride - number % self.stride

    def advance(self, first: int, last: int) -> None:
        """Take steps; write if it is time to. Raises NotFinite, RunError."""
        try:
            self.stepper.advance(first, last, self.stride, self.rows[self.count:])
            self.watch.look(self.stepper.time(last))
        except RunError as error:
            self.watch.look(error.time, error)
            raise
        finally:
            row, rows = first // self.stride + 1, self.stepper.rows
            self._took([self.stepper.time((row + i) * self.stride) for i in range(rows)])

    def flush(self) -> None:
        """Write what is in memory."""
        self.writer.append(self.times[:self.count], self.rows[:self.count])
        self.count = 0
        self.written = time.perf_counter()

    def _took(self, instants: Sequence[float]) -> None:
        first, self.count = self.count, self.count + len(instants)
        self.times[first:self.count] = instants
        bad = self.watch.bad_row(self.rows[first:self.count])
        if bad is not None:
            self.count = first + bad + 1
            raise self.watch.refuse(self.rows[first + bad], float(self.times[first + bad]))
        if self.count == ROWS or time.perf_counter() - self.written > FLUSH:
            self.flush()
