"""Keeps snapshots while a system runs, and lets a run go on from one."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from ..errors import ConfigError, Problem
from ..results.file import copy_rows
from .adaptive import Control
from .recorder import Recorder
from .snapshot import Damaged, Snapshot, put, recall, take
from .stepper import Stepper

NEAR = 1e-6  # of a step: instants this close are one


@dataclass
class Keeper:
    """Writes ``path`` every ``every`` seconds of simulated time; 0 keeps nothing.

    ``resumed``: where to begin, with ``recorded``, the results file that holds the rows until
    then. ``system``: what says that a snapshot is of this system.
    """

    path: Path | None = None
    every: float = 0.0
    resumed: Snapshot | None = None
    recorded: Path | None = None
    system: str = ""
    control: Control | None = None

    @property
    def goes_on(self) -> bool:
        """Whether a run may go on from here beyond its stop time, which FMUs' states would keep."""
        return self.every > 0.0 or self.resumed is not None

    def begin(self, stepper: Stepper, recorder: Recorder) -> int:
        """Bring a system to where it begins; the number of steps taken until there."""
        self.stepper, self.recorder = stepper, recorder
        if self.resumed is None or self.recorded is None:
            recorder.first()
            self.due = stepper.start + self.every
            return 0
        put(stepper, self.resumed)
        copy_rows(self.recorded, self.resumed.rows, recorder.writer)
        self.due = self._next(self.resumed.time)
        return self.resumed.number

    def put_control(self) -> None:
        """Let error control go on as it would have."""
        if self.control is not None and self.resumed is not None and self.resumed.control:
            recall(self.control, self.resumed)

    def room(self, number: int) -> int:
        """How many fixed steps may be taken until the next snapshot."""
        if not self.every:
            return sys.maxsize
        left = (self.due - self.stepper.time(number)) / self.stepper.step
        return max(1, round(left))

    def reached(self, number: int, time: float) -> None:
        """Keep a snapshot if it is time to."""
        if self.every and time >= self.due - NEAR * self.stepper.step:
            self.keep(number)
            self.due = self._next(time)

    def keep(self, number: int) -> None:
        """Keep a snapshot, if snapshots are kept."""
        if self.path is not None and self.every:
            self.recorder.flush()
            rows = self.recorder.writer.samples
            take(self.stepper, number, rows, self.control, self.system).write(self.path)

    def _next(self, time: float) -> float:
        start = self.stepper.start
        return start + (1 + round((time - start) / self.every)) * self.every if self.every else 0.0


def resumed(
    path: Path, system: str, instances: Iterable[str], size: int, stop: float
) -> Snapshot:
    """The snapshot of a file, of so many values, from which a run goes on to the stop time.

    Raises ConfigError if it is damaged, of another system or of later.
    """
    where = f"--resume {path}"
    try:
        snapshot = Snapshot.read(path)
    except OSError as error:
        raise ConfigError([Problem(where, f"is not a snapshot: {error}")]) from None
    except Damaged:
        raise ConfigError([Problem(where, "is damaged")]) from None
    if snapshot.system != system:
        remedy = "only stop_time and plots may differ, and the FMUs must be the same"
        raise ConfigError([Problem(where, "is of another system", remedy)])
    if snapshot.states.keys() != set(instances) or snapshot.values.shape != (size,):
        raise ConfigError([Problem(where, "is damaged")])
    if snapshot.time > stop:
        what = f"is of t = {snapshot.time:.9g} s, after the stop time {stop:.9g} s"
        raise ConfigError([Problem(where, what, "give a later stop_time")])
    return snapshot
