"""Reports for people and for continuous integration."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from .findings import CheckResult, Report, Verdict, visible
from .registry import checks

MARKS = {Verdict.PASSED: "passed", Verdict.FAILED: "FAILED", Verdict.NOT_APPLICABLE: "n/a   "}


def line(result: CheckResult) -> str:
    """A result in one line, its findings below."""
    known = checks().get(result.check)
    asks = known.asks if known else "the archive is safe to open, its binaries are what they seem"
    tried = ", ".join(f"{n:,} {what}" for what, n in result.tried.items())
    more = visible(result.reason) or (f"{asks} ({tried})" if tried else asks)
    head = f"  {MARKS[result.verdict]}  {result.check:<25} {more}"
    return "\n".join([head, *(f"          {finding}" for finding in result.findings)])


def summary(report: Report) -> str:
    """The verdict of a file in one line."""
    counts = {v: sum(r.verdict is v for r in report.results) for v in Verdict}
    verdict = "holds" if report.passed else "does not hold"
    return (f"{visible(report.file.name)}: {verdict}: {counts[Verdict.PASSED]} passed, "
            f"{counts[Verdict.FAILED]} failed, {counts[Verdict.NOT_APPLICABLE]} not applicable")


def text(report: Report) -> str:
    """A whole report."""
    fmi = f" (FMI {report.version})" if report.version else ""
    title = visible(f"{report.file}: {report.model}{fmi}")
    lines = [title, *map(line, report.results), summary(report)]
    return "\n".join(lines)


def junit(reports: Iterable[Report]) -> bytes:
    """Reports as JUnit XML: a suite per file, a case per check."""
    root = ET.Element("testsuites", name="sightline verify")
    for report in reports:
        suite = ET.SubElement(root, "testsuite", _counts(report))
        for result in report.results:
            case = ET.SubElement(suite, "testcase", classname=visible(report.model),
                                 name=result.check, time=f"{result.seconds:.3f}")
            if result.verdict is Verdict.FAILED:
                message = str(result.findings[0]) if result.findings else ""
                failure = ET.SubElement(case, "failure", message=message)
                failure.text = "\n".join(map(str, result.findings))
            if result.verdict is Verdict.NOT_APPLICABLE:
                ET.SubElement(case, "skipped", message=visible(result.reason))
    ET.indent(root)
    document: bytes = ET.tostring(root, encoding="UTF-8", xml_declaration=True)
    return document + b"\n"


def _counts(report: Report) -> dict[str, str]:
    results = report.results
    return {
        "name": visible(str(report.file)), "tests": str(len(results)),
        "failures": str(sum(r.verdict is Verdict.FAILED for r in results)),
        "skipped": str(sum(r.verdict is Verdict.NOT_APPLICABLE for r in results)),
        "time": f"{sum(r.seconds for r in results):.3f}",
    }  # fmt: skip
