"""Example 5.2 of the line-of-sight paper under both laws, co-simulated from its configs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_comparison"
TABLE = {  # Ψ1 computed by DOP853 at 1e-11
    "system": {0: 1.972297, 1: 1.631590, 5: 0.2663469, 10: 2.19832e-3, 15: 1.37658e-5,
               30: 2.2e-12},
    "comparison_law": {0: 1.972297, 1: 1.742275, 5: 1.440878, 10: 0.0757208, 15: 4.45930e-4,
                       30: 6.2e-11},
}  # fmt: skip
CASES = [(law, time) for law, errors in TABLE.items() for time in errors]
SETTLED = {"system": 14.1, "comparison_law": 18.0}  # s, |τ1| < 1e-4 N m


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Results]:
    """The runs that the example's configs describe, at 2 ms."""
    return {law: System.from_toml(EXAMPLE / f"{law}.toml").simulate(tmp_path_factory.mktemp(law))
            for law in TABLE}


@pytest.mark.parametrize(("law", "time"), CASES)
def test_the_attitude_error_is_within_1_percent_of_the_table(
    runs: dict[str, Results], law: str, time: float
) -> None:
    error = runs[law]["monitor.alignment_error"][np.argmin(np.abs(runs[law].time - time))]
    assert error == pytest.approx(TABLE[law][time], rel=0.01)


@pytest.mark.parametrize("law", SETTLED)
def test_the_torque_settles_when_computed(runs: dict[str, Results], law: str) -> None:
    norms = np.linalg.norm(runs[law]["control1.torque"], axis=1)
    settled = runs[law].time[np.flatnonzero(norms >= 1e-4)[-1] + 1]
    assert settled == pytest.approx(SETTLED[law], abs=0.1)


def test_the_comparison_law_leaves_positions_alone(runs: dict[str, Results]) -> None:
    np.testing.assert_array_equal(np.ptp(runs["comparison_law"]["craft2.position"], axis=0), 0.0)


@pytest.mark.parametrize("law", TABLE)
def test_halving_the_step_halves_the_error(law: str, tmp_path: Path) -> None:
    errors = []
    for step in (0.008, 0.004, 0.002):
        config = tmp_path / "variant.toml"
        config.write_text(f"extends = '{EXAMPLE / law}.toml'\n[simulation]\nstop_time = 1.0\n"
                          f"step = {step}\n[record]\nevery = 1.0\n", encoding="utf-8")
        run = System.from_toml(config).simulate(tmp_path)
        errors.append(run["monitor.alignment_error"][-1] - TABLE[law][1])
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 2.0, rtol=0.05)  # commands held: first order
