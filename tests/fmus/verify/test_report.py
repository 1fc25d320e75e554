"""Reports for people and machines, and the command's exit codes."""

from __future__ import annotations

import os
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from sightline.fmus.verify import render
from sightline.fmus.verify.findings import CheckResult, Finding, Report, Verdict
from sightline.fmus.verify.registry import FAMILIES, checks
from sightline.orchestrator.cli import app

REPORT = Report(
    Path("a.fmu"), "A", "2.0",
    (
        CheckResult("archive", Verdict.PASSED),
        CheckResult("calls.legal", Verdict.PASSED, tried={"sequences": 12, "calls": 3456}),
        CheckResult("inputs.running", Verdict.FAILED, (
            Finding("inputs.running", "u = nan", "an error status", "y is \x01 & not <finite>",
                    "refuse it"),)),
        CheckResult("reference", Verdict.NOT_APPLICABLE, reason="there is no a_ref.csv"),
    ),
)  # fmt: skip
Make = Callable[..., Path]


def test_a_report_says_what_was_found_where_and_what_would_be_right() -> None:
    lines = render.text(REPORT).splitlines()
    assert lines[0] == "a.fmu: A (FMI 2.0)"
    assert "passed  calls.legal" in lines[2]
    assert lines[2].endswith("(12 sequences, 3,456 calls)")
    assert "FAILED  inputs.running" in lines[3]
    assert lines[4].strip() == (
        "u = nan: y is \\x01 & not <finite>; expected an error status; refuse it"
    )
    assert lines[5].endswith("there is no a_ref.csv")
    assert lines[6] == "a.fmu: does not hold: 2 passed, 1 failed, 1 not applicable"


def test_junit_has_a_suite_per_file_and_a_case_per_check() -> None:
    suite = ET.fromstring(render.junit([REPORT])).find("testsuite")
    assert suite is not None
    assert (suite.get("tests"), suite.get("failures"), suite.get("skipped")) == ("4", "1", "1")
    cases = {c.get("name"): c for c in suite.iter("testcase")}
    failure = cases["inputs.running"].find("failure")
    assert failure is not None
    assert "y is \\x01 & not <finite>" in str(failure.get("message"))
    assert cases["reference"].find("skipped") is not None
    assert not list(cases["archive"])


def test_results_survive_the_pipe() -> None:
    for result in REPORT.results:
        assert CheckResult.from_json(result.to_json()) == result


def test_every_check_belongs_to_a_family_and_says_what_it_asks() -> None:
    assert {n.partition(".")[0] for n in checks()} == set(FAMILIES)
    assert all(c.asks and c.seconds > 0 for c in checks().values())


def test_a_sound_fmu_exits_with_0_and_writes_junit(make: Make, tmp_path: Path) -> None:
    junit = tmp_path / "report.xml"
    done = CliRunner().invoke(app, ["verify", str(make()), "--only", "description",
                                    "--junit", str(junit)])
    assert (done.exit_code, "bench.fmu: holds: 9 passed" in done.output) == (0, True), done.output
    assert len(list(ET.parse(junit).iter("testcase"))) == 9


@pytest.mark.parametrize(("terminal", "shown"), [("1", True), ("", False)])
def test_progress_is_shown_on_a_terminal_only(
    terminal: str, shown: bool, make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FORCE_COLOR", terminal)
    monkeypatch.setenv("COLUMNS", "120")
    done = CliRunner().invoke(app, ["verify", str(make()), "--only", "description.units"])
    assert done.exit_code == 0
    assert ("bench.fmu  description.units" in done.output) is shown
    assert ("1/2" in done.output) is shown
    assert "passed  description.units" in done.output


def test_a_failed_check_exits_with_1(make: Make) -> None:
    path = make("STEP_ANYWHERE")
    done = CliRunner().invoke(app, ["verify", str(path), "--only", "calls.illegal"])
    assert done.exit_code == 1
    assert "a step in mode instantiated: accepted; expected an error status" in done.output


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no full device")
@pytest.mark.parametrize("junit", [False, True])
def test_a_report_that_cannot_be_written_exits_with_1(junit: bool, make: Make) -> None:
    command = [sys.executable, "-m", "sightline.orchestrator.cli", "verify", str(make()),
               "--only", "archive", *(["--junit", "/dev/full"] if junit else [])]
    with open(os.devnull if junit else "/dev/full", "w") as out:
        done = subprocess.run(command, stdout=out, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 1
    words = "--junit: cannot write /dev/full" if junit else "cannot write the report"
    assert done.stderr == f"{words}: No space left on device\n"


def test_what_an_fmu_says_is_cut_and_made_visible(make: Make, check: Callable[..., Report]) -> None:
    report = check(make("FLOOD"), only=("calls.legal",))
    text = render.text(report)
    assert len(text) < 20_000
    assert text.isascii()
    assert r"\x1b[31m\u202e" in text
    assert ET.fromstring(render.junit([report])) is not None


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["{fmu}", "--junit", "{fmu}"], "is an FMU to be verified"),
        (["none.fmu"], "there is no file none.fmu"),
        (["{fmu}", "--only", "cals"], "there is no such check; did you mean calls"),
        (["{fmu}", "--reference", "none.csv"], "--reference: there is no file none.csv"),
        (["{fmu}", "{fmu}", "--reference", "{fmu}"], "--reference: give one FMU with it"),
        (["{fmu}", "--junit", "none/report.xml"], "--junit: there is no folder none"),
        ([], "Missing argument"),
    ],
)
def test_bad_usage_exits_with_2(arguments: list[str], message: str, make: Make) -> None:
    given = [a.replace("{fmu}", str(make())) for a in arguments]
    done = CliRunner().invoke(app, ["verify", *given])
    assert done.exit_code == 2
    assert message in done.output


def test_a_hostile_archive_is_one_failure_and_nothing_is_run(
    tmp_path: Path, make: Make, check: Callable[..., Report]
) -> None:
    path = make("CRASH")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../evil", b"")
    report = check(path)
    assert [r.check for r in report.results] == ["archive"]
    assert str(report.failures[0]) == (
        "../evil: its name leads out of the folder; nothing in it was executed"
    )
