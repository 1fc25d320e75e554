"""Case 1 of the relative motion in the LVLH frame paper, co-simulated from its config."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "rendezvous_circular" / "system.toml"
ERRORS = {600: 960.2, 3600: 48.25, 7200: 1.362, 10800: 0.0393}  # computed by DOP853: s -> m


def variant(folder: Path, *lines: str) -> Results:
    """The run of the example's config with other settings."""
    config = folder / "variant.toml"
    config.write_text("\n".join([f"extends = '{EXAMPLE}'", *lines]), encoding="utf-8")
    return System.from_toml(config).simulate(folder)


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 3 h at 1 s."""
    return System.from_toml(EXAMPLE).simulate(tmp_path_factory.mktemp("rendezvous"))


@pytest.mark.parametrize("time", ERRORS)
def test_the_distance_is_within_a_thousandth_of_the_table(results: Results, time: float) -> None:
    error = results["monitor.position_error"][np.argmin(np.abs(results.time - time))]
    assert error == pytest.approx(ERRORS[time], rel=1e-3)


def test_the_peak_force_is_the_computed_one(results: Results) -> None:
    peak = np.linalg.norm(results["control.lvlh_force"], axis=1).max()
    assert peak == pytest.approx(0.1732, rel=1e-3)


def test_the_velocity_change_is_the_computed_one(results: Results) -> None:
    effort = np.linalg.norm(results["control.lvlh_force"], axis=1)
    coarse = np.trapezoid(effort, results.time)  # as the table's, of samples every 10 s
    assert coarse == pytest.approx(8.530, rel=1e-3)


def test_the_velocity_change_is_the_integral_of_the_acceleration(tmp_path: Path) -> None:
    run = variant(tmp_path, "[record]", "every = 1.0")
    effort = np.linalg.norm(run["control.lvlh_force"], axis=1)
    assert np.trapezoid(effort, run.time) == pytest.approx(8.3894, rel=1e-3)


def test_halving_the_step_divides_the_error_by_eight(tmp_path: Path) -> None:
    truth = 960.2049954  # m at 600 s, by DOP853
    errors = np.array([variant(tmp_path, "[simulation]", "stop_time = 600.0",
                               f"step = {step}")["monitor.position_error"][-1]
                       for step in (5.0, 2.5, 1.25)]) - truth
    np.testing.assert_allclose(errors[:-1] / errors[1:], 8.0, rtol=0.1)  # third order


def test_the_lyapunov_function_falls_at_the_rate_of_its_formula(results: Results) -> None:
    later = results.time > 100.0  # the samples of every 10 s resolve it from there
    V, rate = results["monitor.lyapunov"][later], results["monitor.lyapunov_rate"][later]
    slope = np.gradient(V, results.time[later], edge_order=2)
    np.testing.assert_allclose(slope, rate, rtol=0.0, atol=0.01 * np.max(np.abs(rate)))
    assert np.all(np.diff(V) < 0.0)
