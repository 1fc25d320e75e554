"""Case 3 of the relative motion in the LVLH frame paper, co-simulated from its configs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "vbar_docking"
ERRORS = {50: 4.12, 3650: 6.44, 7200: 0.180}  # linear profile, computed by DOP853: s -> m
DOCKED = 720  # row of 7200 s


def variant(folder: Path, base: str, *lines: str) -> Results:
    """The run of one of the example's configs with other settings."""
    config = folder / "variant.toml"
    config.write_text("\n".join([f"extends = '{EXAMPLE / base}'", *lines]), encoding="utf-8")
    return System.from_toml(config).simulate(folder)


def velocity_change(run: Results) -> float:
    """Integral of the acceleration as recorded, by trapezoids."""
    return float(np.trapezoid(np.linalg.norm(run["control.lvlh_force"], axis=1), run.time))


@pytest.fixture(scope="module")
def linear(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 7300 s at 0.05 s."""
    return System.from_toml(EXAMPLE / "system.toml").simulate(tmp_path_factory.mktemp("linear"))


@pytest.fixture(scope="module")
def quintic(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run with the quintic profile: 7300 s at 1 s."""
    return System.from_toml(EXAMPLE / "quintic.toml").simulate(tmp_path_factory.mktemp("quintic"))


@pytest.mark.parametrize("time", ERRORS)
def test_the_error_of_the_linear_profile_is_within_1_percent_of_the_table(
    linear: Results, time: float
) -> None:
    error = linear["monitor.position_error"][np.argmin(np.abs(linear.time - time))]
    assert error == pytest.approx(ERRORS[time], rel=0.01)


def test_the_linear_profile_docks_at_the_computed_speed(linear: Results) -> None:
    assert np.linalg.norm(linear["lvlh.velocity"][DOCKED]) == pytest.approx(0.481, rel=0.01)


def test_the_linear_profile_asks_for_the_computed_peak_force(linear: Results) -> None:
    peak = np.linalg.norm(linear["control.lvlh_force"], axis=1).max()
    assert peak == pytest.approx(0.0677, rel=0.01)


def test_the_quintic_profile_stays_within_the_computed_error(quintic: Results) -> None:
    error = quintic["monitor.position_error"]
    assert error.max() == pytest.approx(3.668e-3, rel=1e-3)
    assert error[DOCKED] == pytest.approx(4.40e-5, rel=2e-3)


def test_the_quintic_profile_asks_for_the_computed_peak_force(quintic: Results) -> None:
    peak = np.linalg.norm(quintic["control.lvlh_force"], axis=1).max()
    assert peak == pytest.approx(4.82e-3, rel=1e-3)


def test_the_velocity_change_of_the_linear_profile_is_the_computed_one(linear: Results) -> None:
    assert velocity_change(linear) == pytest.approx(8.675, rel=2e-3)  # samples every 10 s, both


def test_the_velocity_change_of_the_linear_profile_is_the_integral(tmp_path: Path) -> None:
    run = variant(tmp_path, "system.toml", "[record]", "every = 0.05")
    assert velocity_change(run) == pytest.approx(7.9651, rel=1e-3)


def test_the_velocity_change_of_the_quintic_profile_is_the_computed_one(quintic: Results) -> None:
    assert velocity_change(quintic) == pytest.approx(8.4933, rel=1e-4)


@pytest.mark.parametrize(("base", "steps", "order"), [
    ("system.toml", (0.2, 0.1, 0.05), 1), ("quintic.toml", (1.0, 0.5, 0.25), 3),
])
def test_positions_converge_at_the_order_of_the_coupling(
    base: str, steps: tuple[float, ...], order: int, tmp_path: Path
) -> None:
    ends = [variant(tmp_path, base, "[simulation]", "stop_time = 1000.0", f"step = {step}",
                    )["deputy.relative_position"][-1] for step in steps]
    coarse, fine = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    assert coarse / fine == pytest.approx(2.0**order, rel=0.03)
