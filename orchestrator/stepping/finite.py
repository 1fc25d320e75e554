"""Looks for outputs that are NaN or infinite though their FMU reported success."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..errors import NotFinite, RunError
from ..schedule.plan import Array
from .stepper import Stepper


class Watch:
    """Watches all outputs of a stepper's FMUs."""

    def __init__(self, stepper: Stepper) -> None:
        self._stepper = stepper
        self._recorded = stepper.plan.recorded
        ranges = [np.arange(u.outputs.first, u.outputs.last) for u in stepper.plan.units]
        self._outputs: NDArray[np.intp] = np.concatenate(ranges)

    def bad_row(self, rows: Array) -> int | None:
        """The first row of recorded values that has some; None if all are finite."""
        finite = np.isfinite(rows)
        return None if finite.all() else int(np.argmin(finite.all(axis=1)))

    def refuse(self, row: Array, time: float) -> NotFinite:
        """The error of a row that has some: of the output whose FMU steps first."""
        columns = np.flatnonzero(~np.isfinite(row))
        first = columns[np.argmin(self._recorded[columns])]
        return self._error(int(self._recorded[first]), float(row[first]), time)

    def look(self, time: float, failure: RunError | None = None) -> None:
        """Raise NotFinite if present outputs have some, unless their FMU is what failed."""
        values = self._stepper.values[self._outputs]
        finite = np.isfinite(values)
        if finite.all():
            return
        first = int(np.argmin(finite))
        error = self._error(int(self._outputs[first]), float(values[first]), time)
        if failure is None or failure.instance != error.instance:
            raise error from failure

    def _error(self, position: int, value: float, time: float) -> NotFinite:
        units = self._stepper.plan.units
        (unit,) = (u for u in units if u.outputs.first <= position < u.outputs.last)
        (block,) = (b for b in unit.outputs.blocks if b.first <= position < b.last)
        slave, element = self._stepper.slaves[unit.node], position - block.first
        for port in (p for p in slave.fmu.outputs.values() if p.type == block.type):
            if element < port.size:
                return NotFinite(slave.name, time, port.label(element), str(value))
            element -= port.size
        raise AssertionError
