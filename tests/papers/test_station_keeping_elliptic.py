"""Case 2 of the relative motion in the LVLH frame paper, co-simulated from its config."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "station_keeping_elliptic" / "system.toml"
ERRORS = {3600: 41.50, 7200: 1.093, 14400: 7.243e-4}  # computed by DOP853: s -> m


def variant(folder: Path, *lines: str) -> Results:
    """The run of the example's config with other settings."""
    config = folder / "variant.toml"
    config.write_text("\n".join([f"extends = '{EXAMPLE}'", *lines]), encoding="utf-8")
    return System.from_toml(config).simulate(folder)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 4 h at 1 s."""
    return System.from_toml(EXAMPLE).simulate(tmp_path_factory.mktemp("station"))


@pytest.mark.parametrize("time", ERRORS)
def test_the_error_is_within_a_thousandth_of_the_table(results: Results, time: float) -> None:
    error = results["monitor.position_error"][np.argmin(np.abs(results.time - time))]
    assert error == pytest.approx(ERRORS[time], rel=1e-3)


def test_the_peak_force_is_the_computed_one(results: Results) -> None:
    peak = np.linalg.norm(results["control.lvlh_force"], axis=1).max()
    assert peak == pytest.approx(0.1581, rel=1e-3)


def test_the_velocity_change_is_the_computed_one(results: Results) -> None:
    effort = np.linalg.norm(results["control.lvlh_force"], axis=1)
    coarse = np.trapezoid(effort, results.time)  # as the table's, of samples every 10 s
    assert coarse == pytest.approx(8.404, rel=1e-3)


def test_the_velocity_change_is_the_integral_of_the_acceleration(tmp_path: Path) -> None:
    run = variant(tmp_path, "[record]", "every = 1.0")
    effort = np.linalg.norm(run["control.lvlh_force"], axis=1)
    assert np.trapezoid(effort, run.time) == pytest.approx(8.2762, rel=1e-3)


def test_halving_the_step_divides_the_error_by_eight(tmp_path: Path) -> None:
    truth = 41.504883622  # m at 3600 s, by DOP853
    errors = np.array([variant(tmp_path, "[simulation]", "stop_time = 3600.0",
                               f"step = {step}")["monitor.position_error"][-1]
                       for step in (5.0, 2.5, 1.25)]) - truth
    np.testing.assert_allclose(errors[:-1] / errors[1:], 8.0, rtol=0.1)  # third order
