"""What the standards allow is no failure, however unlike our own FMUs it is."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sightline.fmus.safe_archive import extract
from sightline.fmus.verify.checks.inputs import special_values
from sightline.fmus.verify.findings import Report, Verdict
from sightline.fmus.verify.subject import Subject

Check = Callable[..., Report]
Make = Callable[..., Path]


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('<Unknown index="4" dependencies="1 3"/>', '<Unknown index="4" dependencies="1 2 3"/>'),
        ('<Unknown index="6" dependencies="8"/>', '<Unknown index="6" dependencies="2 8"/>'),
    ],
)
def test_a_parameter_may_be_listed_among_the_dependencies(
    old: str, new: str, make: Make, check: Check
) -> None:
    assert check(make("", (old, new)), only=("description.structure",)).passed


def test_co_simulation_may_have_the_error_of_its_own_solver(make: Make, check: Check) -> None:
    result = check(make("EULER"), only=("interfaces",)).result("interfaces")
    assert result.verdict is Verdict.PASSED
    assert result.tried["values that differ as the error of a solver"] == 4  # x, der(x), y, z


def test_an_fmu_may_end_the_simulation(make: Make, check: Check) -> None:
    report = check(make(end=1.0), effort=0.2)
    assert report.failures == ()
    assert report.result("resources.steps").verdict is Verdict.PASSED
    assert report.result("calls.legal").verdict is Verdict.PASSED


@pytest.mark.parametrize(
    ("end", "findings"),
    [(1.0, []), (0.5, ["the FMU itself ends the simulation at 0.5 s; expected values until 1 s"])],
)
def test_a_reference_may_last_as_long_as_the_fmu(
    end: float, findings: list[str], make: Make, check: Check
) -> None:
    path = make(end=end)
    values = "0,1\n0.5,0.8032653298563167\n1,0.6839397205857212\n"  # u = 0.5
    path.with_name("bench_ref.csv").write_text("time,x\n" + values, encoding="utf-8")
    report = check(path, only=("reference",))
    assert [str(f).partition(": ")[2] for f in report.failures] == findings


def test_checks_that_an_fmu_ends_too_early_do_not_apply(make: Make, check: Check) -> None:
    report = check(make(end=0.2), only=("determinism", "interfaces", "calls.legal"))
    assert report.failures == ()
    assert report.result("determinism.reset").reason == (
        "the FMU itself ends the simulation at 0.2 s, too early for this check"
    )


def test_discrete_inputs_are_left_alone_in_continuous_time(make: Make, check: Check) -> None:
    discrete = 'name="m" valueReference="8" causality="input" variability="discrete"'
    assert discrete in (Path(__file__).parent / "model.xml").read_text(encoding="utf-8")
    report = check(make(), only=("calls.legal", "interfaces"), effort=1.0)
    assert report.passed, report.failures


def test_an_fmu_may_have_no_inputs(make: Make, check: Check) -> None:
    edits = [(f'causality="input" variability="{v}"', 'causality="parameter" variability="tunable"')
             for v in ("continuous", "discrete")]  # fmt: skip
    report = check(make("", *edits), only=("calls.legal", "interfaces", "inputs", "derivatives"))
    assert report.failures == ()
    assert report.result("inputs.running").verdict is Verdict.NOT_APPLICABLE


def test_values_beyond_the_range_of_a_type_are_not_tried(make: Make, tmp_path: Path) -> None:
    narrow = make("", ("<Float64 name=\"gate\"", "<Float32 name=\"gate\""), fmi=3)
    extract(narrow, tmp_path / "fmu")
    values = special_values(Subject(narrow, tmp_path / "fmu").by_name["gate"])
    finite = [abs(v) for v in values if math.isfinite(v)]
    assert max(finite) == float(np.finfo(np.float32).max)
    assert {math.inf, -math.inf} < set(values)


def test_strings_binaries_and_clocks_are_left_alone(make: Make, check: Check) -> None:
    report = check(make(fmi=3))
    assert report.failures == ()
    reasons = {r.check: r.reason for r in report.results if r.verdict is Verdict.NOT_APPLICABLE}
    assert reasons["inputs.running"] == "the FMU has no numeric inputs"
    assert reasons["inputs.start"] == "the FMU has no numeric parameters and no start values"
    assert reasons["dependencies"] == "the FMU has no numeric inputs"


def test_scheduled_execution_is_not_driven(make: Make, check: Check) -> None:
    flag = ' canHandleVariableCommunicationStepSize="true"'
    report = check(make("", (flag, ""), ("<CoSimulation", "<ScheduledExecution"), fmi=3))
    assert report.failures == ()
    assert report.result("description.binaries").tried == {"binaries": 1}
    for name in ("description.token", "calls.lifecycle", "steps.drift", "resources.instances"):
        assert report.result(name).reason == "the FMU offers scheduled execution only"


def test_an_fmu_of_fmi_3_may_end_the_simulation(make: Make, check: Check) -> None:
    report = check(make(fmi=3, end=1.0), only=("calls.legal", "resources.steps", "steps"))
    assert report.failures == ()
    assert report.result("resources.steps").verdict is Verdict.PASSED
    assert report.result("steps.drift").verdict is Verdict.NOT_APPLICABLE


def test_a_solver_of_fixed_step_may_miss_the_points_in_fmi_3(make: Make, check: Check) -> None:
    result = check(make(fmi=3, lag=0.03), only=("steps.drift",)).result("steps.drift")
    assert result.verdict is Verdict.PASSED


def test_time_that_is_added_up_is_a_failure_in_fmi_3_too(make: Make, check: Check) -> None:
    report = check(make("DRIFT", fmi=3), only=("steps.drift",))
    assert report.failures[0].where == "internal time at the end"
