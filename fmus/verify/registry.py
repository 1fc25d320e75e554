"""The checks by name. A module of checks registers each of its functions with ``@check``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib import import_module
from typing import TYPE_CHECKING, TypeAlias

from .findings import Finding, shortened

if TYPE_CHECKING:
    from .lab import Lab

FAMILIES = ("description", "dependencies", "calls", "determinism", "state", "steps", "inputs",
            "derivatives", "interfaces", "agreement", "reference", "resources")  # fmt: skip


class NotApplicable(Exception):
    """The check does not concern this FMU; the text says why."""


@dataclass
class Notes:
    """Where a check writes what it finds and counts what it tries."""

    check: str
    findings: list[Finding] = field(default_factory=list)
    tried: Counter[str] = field(default_factory=Counter)
    limit: int = 20  # findings of one check that are kept

    def wrong(self, where: str, found: str, expected: str = "", remedy: str = "") -> None:
        """Note something that does not hold."""
        if len(self.findings) < self.limit:
            parts = map(shortened, (where, expected, found, remedy))
            self.findings.append(Finding(self.check, *parts))


Function: TypeAlias = "Callable[[Lab, Notes], None]"


@dataclass(frozen=True)
class Check:
    """One check: ``asks`` completes "checks that ...", ``seconds`` is its time limit."""

    name: str
    asks: str
    function: Function
    seconds: float


_registered: dict[str, Check] = {}


def check(name: str, asks: str, seconds: float = 60.0) -> Callable[[Function], Function]:
    """Register a function as a check."""

    def register(function: Function) -> Function:
        _registered[name] = Check(name, asks, function, seconds)
        return function

    return register


def checks() -> dict[str, Check]:
    """All checks, in the order in which they run."""
    for family in FAMILIES:
        import_module(f"{__package__}.checks.{family}")
    order = {family: i for i, family in enumerate(FAMILIES)}
    return dict(sorted(_registered.items(), key=lambda c: order[c[0].partition(".")[0]]))


def selected(wanted: Iterable[str]) -> dict[str, Check]:
    """Checks by name or family, all if none is named. Raises KeyError for a name that is none."""
    known = checks()
    names = list(wanted)
    for name in names:
        if name not in known and name not in FAMILIES:
            raise KeyError(name)
    return {n: c for n, c in known.items()
            if not names or n in names or n.partition(".")[0] in names}
