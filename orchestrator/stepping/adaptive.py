"""Variable steps under error control: one step of 2h against two of h, from the same state.

The error of a step is estimated by the difference of both, over all outputs that are real and
vary continuously, relative to tolerance · (1 + |value|). The two small steps are kept. Steps end
exactly at the stop time and at all instants of the grid: records, and samples of FMUs that have a
period or step at every n-th point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..errors import RunError
from ..schedule.plan import Indices
from .startup import Restore, saved
from .stepper import Stepper

SAFETY, SHRINK, GROW = 0.9, 0.2, 2.0
SMALLEST = 1e-12  # step, relative to the time that has passed and the first step
SMALL = 1e-6  # step, relative to the first, at which an FMU that fails has failed
NEAR = 1e-9  # of a step: instants this close are one


@dataclass
class Control:
    """What error control has done so far, and the step that it tries next."""

    stepper: Stepper
    tolerance: float
    controlled: Indices  # positions of the values that are watched
    width: float = 0.0
    accepted: int = 0
    rejected: int = 0
    past: list[float] = field(default_factory=list)  # communication points, the newest first

    def __post_init__(self) -> None:
        self.width = self.width or self.stepper.step
        start, step = self.stepper.start, self.stepper.step
        self.past = self.past or [start, start - step, start - 2 * step]
        self._power = -1.0 / (self.stepper.plan.order + 2)

    def reach(self, end: float) -> Iterator[float]:
        """Step until an instant, exactly; gives the time after each step. Raises RunError."""
        time = self.past[0]
        while time < end:
            left = end - time
            count = max(1, math.ceil(left / self.width * (1 - NEAR)))
            width = left if count == 1 else min(self.width, left / 2)
            time = self._step(time, width, end if width == left else time + width)
            yield time

    def _step(self, time: float, width: float, end: float) -> float:
        """One accepted step, the one asked for or a smaller one; where it ends."""
        with saved(self.stepper) as restore:
            while True:
                error = self._error(time, width, end, restore)
                factor = SAFETY * error**self._power if error > 0.0 else GROW
                wish = width * min(GROW, max(SHRINK, factor))
                if error <= 1.0:
                    self.width = max(wish, self.width) if width < self.width else wish
                    break
                self.rejected += 1
                restore()
                width = self.width = min(wish, SAFETY * width)
                end = time + width
                if width < SMALLEST * max(abs(time), self.stepper.step):
                    raise self._underflow(time, width)
        self.accepted += 1
        self.past = [end, time + width / 2, time]
        return end

    def _error(self, time: float, width: float, end: float, restore: Restore) -> float:
        """The error of the small steps, in units of the tolerance; they have been taken."""
        values, middle = self.stepper.values, time + width / 2
        try:
            self._take(self.past, time, end)
            big = values[self.controlled]
            restore()
            self._take(self.past, time, middle)
            self._take([middle, *self.past], middle, end)
        except RunError:
            if any(s.dead for s in self.stepper.slaves) or width < SMALL * self.stepper.step:
                raise
            return math.inf
        small = values[self.controlled]
        scale = self.tolerance * (1.0 + np.abs(small))
        order = self.stepper.plan.order + 1
        worst = float(np.max(np.abs(big - small) / scale, initial=0.0))
        return worst / (2.0**order - 1.0)

    def _take(self, past: list[float], time: float, end: float) -> None:
        self.stepper.bend([end - time, *(t - time for t in past[:3])])
        self.stepper.take(time, end - time)

    def _underflow(self, time: float, width: float) -> RunError:
        what = f"the tolerance {self.tolerance:g} cannot be met"
        return RunError("error control", time, f"a step of {width:.3g} s", "rejection", what)


def grid(
    start: float, stop: float, records: Sequence[float], periods: Sequence[float]
) -> Iterator[tuple[float, bool]]:
    """All instants that are a multiple of a period from the start, and the stop, in order.

    With each: whether it is a multiple of one of ``records``, or the stop.
    """
    every = [*records, *periods]
    counts = [1] * len(every)
    while True:
        instants = [start + n * p for n, p in zip(counts, every, strict=True)]
        end = min([*instants, stop])
        if end >= stop - NEAR * (stop - start):
            yield stop, True
            return
        met = [i <= end + NEAR * p for i, p in zip(instants, every, strict=True)]
        yield end, any(met[:len(records)])
        counts = [n + m for n, m in zip(counts, met, strict=True)]
