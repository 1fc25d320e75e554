"""What the checks found, as data: findings, results of checks, reports of files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any

LONGEST = 400  # characters of each part of a finding


def visible(text: str) -> str:
    """Text with what does not print (control, bidi and the like) escaped, so that it shows."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


def shortened(text: str) -> str:
    """The beginning of a text that is too long for a report."""
    return text if len(text) <= LONGEST else text[:LONGEST] + " …"


class Verdict(StrEnum):
    """How a check ended."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class Finding:
    """One thing that does not hold: what, where, and what would be right."""

    check: str
    where: str
    expected: str
    found: str
    remedy: str = ""

    def __str__(self) -> str:
        text = f"{self.where}: {self.found}"
        if self.expected:
            text += f"; expected {self.expected}"
        return visible(f"{text}; {self.remedy}" if self.remedy else text)


@dataclass(frozen=True)
class CheckResult:
    """The verdict of one check; ``reason`` says why it does not apply, ``tried`` what was tried."""

    check: str
    verdict: Verdict
    findings: tuple[Finding, ...] = ()
    reason: str = ""
    tried: Mapping[str, int] = field(default_factory=dict)
    seconds: float = 0.0

    def to_json(self) -> dict[str, Any]:
        """Plain data, for the pipe."""
        return asdict(self)

    @staticmethod
    def from_json(data: Mapping[str, Any]) -> CheckResult:
        """The inverse of ``to_json``."""
        fields = dict(data)
        fields["verdict"] = Verdict(fields["verdict"])
        fields["findings"] = tuple(Finding(**f) for f in fields["findings"])
        return CheckResult(**fields)


@dataclass(frozen=True)
class Report:
    """All results of one FMU."""

    file: Path
    model: str
    version: str
    results: tuple[CheckResult, ...]

    @property
    def passed(self) -> bool:
        """Whether no check failed."""
        return all(r.verdict is not Verdict.FAILED for r in self.results)

    @property
    def failures(self) -> tuple[Finding, ...]:
        """Findings of all checks that failed."""
        return tuple(f for r in self.results for f in r.findings)

    def result(self, check: str) -> CheckResult:
        """The result of a check by its name."""
        return next(r for r in self.results if r.check == check)
