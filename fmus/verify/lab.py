"""What a check works with: instances of the FMU, inputs that it accepts, trajectories."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from .driver import Driver
from .excitation import AMPLITUDES, Excitation
from .fmi2_driver import Driver2
from .fmi3_driver import Driver3
from .registry import NotApplicable
from .session import Ended, NotFinite, Refused, Session
from .subject import Array, Subject, Variable
from .trace import Trace

STEPS = 12  # of the usual trajectory
THOROUGH = 20.0  # effort at which everything is tried


@dataclass
class Lab:
    """The bench of one check in one process."""

    subject: Subject
    trace: Trace
    others: Sequence[Subject] = ()
    reference: Path | None = None
    seed: int = 0
    effort: float = 1.0  # scales what is tried; THOROUGH: everything
    lost: Collection[str] = ()  # trials in which processes were lost
    _made: list[Driver] = field(default_factory=list)

    @property
    def thorough(self) -> bool:
        """Whether to try everything, however long it takes."""
        return self.effort >= THOROUGH

    def require_interface(self) -> None:
        """Raise NotApplicable unless there is an interface that the bench drives."""
        if not self.subject.interfaces:
            raise NotApplicable("the FMU offers scheduled execution only")

    @property
    def interface(self) -> str:
        """The interface that the checks use: co-simulation where offered."""
        return "cs" if "cs" in self.subject.interfaces else "me"

    def driver(
        self, name: str = "one", interface: str = "", subject: Subject | None = None
    ) -> Driver:
        """An instance that is not created yet."""
        of = subject or self.subject
        kind = Driver2 if of.version == 2 else Driver3
        chosen = interface or ("cs" if "cs" in of.interfaces else "me")
        made = kind(of, chosen, name, self.trace)
        self._made.append(made)
        return made

    def instance(
        self, name: str = "one", interface: str = "", subject: Subject | None = None
    ) -> Driver:
        """A new instance."""
        return self.driver(name, interface, subject).instantiate()

    def session(
        self, name: str = "one", interface: str = "", subject: Subject | None = None
    ) -> Session:
        """A new instance with a time, not initialised."""
        return Session(self.instance(name, interface, subject))

    def close(self) -> None:
        """Free all instances."""
        while self._made:
            self._made.pop().free()

    def trial(self, name: str) -> bool:
        """Begin one of several trials; False for one in which a process was lost."""
        self.trace.trial(name)
        return name not in self.lost

    def must_run(self) -> None:
        """Raise Refused if the FMU does not run with any inputs."""
        _ = self.excitation

    @cached_property
    def watched(self) -> list[Variable]:
        """What trajectories record: outputs and everything internal that can be read."""
        return [v for v in self.subject.readable if v.causality in ("output", "local")]

    @cached_property
    def excitation(self) -> Excitation:
        """Inputs that move as far as the FMU accepts. Raises Refused or Ended if with none."""
        return self.excite(self.seed)

    def excite(self, seed: int) -> Excitation:
        """Another course of the inputs."""
        for amplitude in AMPLITUDES:
            course = Excitation(self.subject, amplitude, seed)
            try:
                self.trajectory(self.session("probe"), course)
            except NotFinite:
                raise
            except (Refused, Ended):
                if amplitude == AMPLITUDES[-1]:
                    raise
            else:
                return course
        raise AssertionError

    def begun(self, name: str = "one", interface: str = "", crude: bool = False) -> Session:
        """A new instance, initialised with the inputs of step 0."""
        session = Session(self.instance(name, interface), crude)
        return session.begin(inputs=self.excitation.at(0))

    def trajectory(
        self, session: Session, course: Excitation | None = None, steps: int = STEPS,
        h: float | None = None, watched: Sequence[Variable] | None = None,
    ) -> Array:  # fmt: skip
        """Begin and step a new instance; the values watched, a row before and after each step."""
        inputs = course or self.excitation
        session.begin(inputs=inputs.at(0))
        variables = self.watched if watched is None else watched
        rows = [session.read(variables)]
        rows += self.continue_(session, inputs, 0, steps, h, variables)
        return np.array(rows)

    def continue_(
        self, session: Session, course: Excitation, first: int, last: int,
        h: float | None = None, watched: Sequence[Variable] | None = None,
        before: Callable[[int], None] | None = None,
    ) -> list[Array]:  # fmt: skip
        """Steps ``first`` to ``last``; the values after each and after new inputs."""
        variables = self.watched if watched is None else watched
        step = self.subject.step if h is None else h
        rows = []
        for k in range(first, last):
            if before is not None:
                before(k)
            session.put(course.at(k))
            session.step(step, self.subject.start_time + k * step)
            rows.append(session.read(variables))
        return rows


def same(a: Array, b: Array) -> bool:
    """Whether two arrays agree bit for bit; NaN agrees with NaN."""
    return a.shape == b.shape and a.tobytes() == b.tobytes()


def first_difference(names: Sequence[str], a: Array, b: Array) -> str:
    """Where two trajectories part first, in words."""
    rows = min(len(a), len(b))
    for row in range(rows):
        for name, x, y in zip(names, a[row], b[row], strict=True):
            if x != y and not (np.isnan(x) and np.isnan(y)):
                return f"{name} after step {row}: {x:.17g} and {y:.17g}"
    return "in the sign of a zero or in the number of steps"


def deviation(a: Array, b: Array, nominal: Array) -> tuple[float, int]:
    """Largest difference relative to the size of each column, and the column.

    A difference that is no number counts as infinite.
    """
    size = np.maximum(np.maximum(np.max(np.abs(a), axis=0), np.max(np.abs(b), axis=0)), nominal)
    error = np.max(np.abs(a - b), axis=0) / np.where(size > 0.0, size, 1.0)
    error = np.where(np.isfinite(error), error, np.inf)
    column = int(np.argmax(error)) if error.size else 0
    return (float(error[column]) if error.size else 0.0), column
