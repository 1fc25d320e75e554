"""What can be wrong with a system or a run, as classes with fields and one rendering each."""

from __future__ import annotations

import difflib
import errno
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from .alike import few

NO_ROOM = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)  # what a full disk answers


@dataclass(frozen=True)
class Problem:
    """One thing wrong with a system: where, what, and what would be right.

    ``where`` is the place in the config (``instances.craft1.parameters.mas``) and ``file`` and
    ``line`` the text that says it, as far as known.
    """

    where: str
    what: str
    remedy: str = ""
    file: str = ""
    line: int | None = None

    def at(self, file: str, line: int | None) -> Problem:
        """The same problem with its place in a file."""
        return replace(self, file=file, line=line)

    def __str__(self) -> str:
        place = ":".join(str(p) for p in (self.file, self.line) if p not in ("", None))
        head = f"{place}: {self.where}" if place else self.where
        return _one_line(f"{head}: {self.what}" + (f"; {self.remedy}" if self.remedy else ""))


class ConfigError(Exception):
    """A system cannot be run as it is written; ``problems`` says everything that is wrong."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda p: (p.line is None, p.file, p.line or 0)))
        super().__init__(*self.problems)

    def __str__(self) -> str:
        count = len(self.problems)
        head = "1 problem" if count == 1 else f"{count} problems"
        return "\n".join([head, *(f"  {p}" for p in self.problems)])


@dataclass
class FmuError(Exception):
    """A file is not an FMU that can be used here: ``problem`` says why, ``remedy`` what to do."""

    file: str
    problem: str
    remedy: str = ""

    def __str__(self) -> str:
        return f"{self.file} {self.problem}" + (f"; {self.remedy}" if self.remedy else "")


@dataclass
class RunError(Exception):
    """An FMU did not do what was asked: ``message`` is what it said itself."""

    instance: str
    time: float
    action: str
    status: str
    message: str = ""

    def __str__(self) -> str:
        head = f"{self.instance} at t = {self.time:.10g} s: {self.action} ended with {self.status}"
        return f"{head}: {self.message}" if self.message else head


def each(actions: Iterable[Callable[[], None]]) -> None:
    """Do all. Raises the first RunError only then, with the others as notes."""
    errors = []
    for action in actions:
        try:
            action()
        except RunError as error:
            errors.append(error)
    if errors:
        for other in few(str(e) for e in errors[1:]):
            errors[0].add_note(other)
        raise errors[0]


class LoopError(RunError):
    """An algebraic loop was not solved: ``residuals`` by the names of the inputs in the loop."""

    def __init__(
        self, instances: Sequence[str], time: float, what: str, residuals: Mapping[str, float]
    ) -> None:
        super().__init__(", ".join(instances), time, "the algebraic loop", what)
        self.residuals = dict(residuals)

    def __str__(self) -> str:
        head = f"{self.instance} at t = {self.time:.10g} s: {self.action} {self.status}"
        parts = (f"{name}: {residual:.3g}" for name, residual in self.residuals.items())
        found = f"; residuals {', '.join(parts)}" if self.residuals else ""
        return (
            f"{head}{found}; put an FMU with a state into the loop, or let one connection be a "
            "step late: simulation.delay"
        )


class NotFinite(RunError):
    """An output was NaN or infinite: ``action`` is its name, ``status`` its value."""

    def __str__(self) -> str:
        head = f"{self.instance} at t = {self.time:.10g} s"
        return f"{head}: the output {self.action} is {self.status}, and the FMU said nothing of it"


def _one_line(text: str) -> str:
    """A text in which nothing ends a line or steers a terminal."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def nearest(name: str, valid: Iterable[str], kind: str = "") -> str:
    """A remedy that lists the valid names nearest to ``name``, or all if they are few."""
    names = [str(v) for v in valid]
    prefix = f"{kind}: " if kind else ""
    if not names:
        return f"{prefix}there are none"
    close = difflib.get_close_matches(name, names, n=3, cutoff=0.5)
    if close:
        return f"did you mean {' or '.join(close)}?"
    if len(names) <= 8:
        return f"{prefix or 'valid: '}{', '.join(sorted(names))}"
    return f"{prefix or 'valid: '}{', '.join(sorted(names)[:8])}, …"
