"""Cases 1 and 2 of the relative motion in the LVLH frame paper, co-simulated from their configs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System


class Case(NamedTuple):
    """An example, and what DOP853 makes of its equations."""

    example: str
    errors: Mapping[int, float]  # position error: s -> m
    peak: float  # force, N
    coarse: float  # velocity change of samples every 10 s as in the table, m/s
    fine: float  # its integral, m/s
    precise: tuple[float, float]  # time in s and the position error then in m


CASES = (
    Case("rendezvous_circular", {600: 960.2, 3600: 48.25, 7200: 1.362, 10800: 0.0393},
         0.1732, 8.530, 8.3894, (600.0, 960.2049954)),
    Case("station_keeping_elliptic", {3600: 41.50, 7200: 1.093, 14400: 7.243e-4},
         0.1581, 8.404, 8.2762, (3600.0, 41.504883622)),
)  # fmt: skip


@pytest.fixture(scope="module", params=CASES, ids=[case.example for case in CASES])
def case(request: pytest.FixtureRequest) -> Case:
    return request.param  # type: ignore[no-any-return]


@pytest.fixture(scope="module")
def config(case: Case) -> Path:
    return Path(__file__).parents[2] / "examples" / case.example / "system.toml"


@pytest.fixture(scope="module")
def results(config: Path, tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: hours at 1 s."""
    return System.from_toml(config).simulate(tmp_path_factory.mktemp("case"))


@pytest.fixture
def variant(config: Path, tmp_path: Path) -> Callable[..., Results]:
    """Runs of the example's config with other settings."""

    def run(*lines: str) -> Results:
        path = tmp_path / "variant.toml"
        path.write_text("\n".join([f"extends = '{config}'", *lines]), encoding="utf-8")
        return System.from_toml(path).simulate(tmp_path)

    return run


def test_the_position_error_is_within_a_thousandth_of_the_table(
    case: Case, results: Results
) -> None:
    at = [int(np.argmin(np.abs(results.time - time))) for time in case.errors]
    np.testing.assert_allclose(
        results["monitor.position_error"][at], list(case.errors.values()), rtol=1e-3
    )


def test_the_peak_force_is_the_computed_one(case: Case, results: Results) -> None:
    peak = np.linalg.norm(results["control.lvlh_force"], axis=1).max()
    assert peak == pytest.approx(case.peak, rel=1e-3)


def test_the_velocity_change_is_the_computed_one(case: Case, results: Results) -> None:
    effort = np.linalg.norm(results["control.lvlh_force"], axis=1)
    assert np.trapezoid(effort, results.time) == pytest.approx(case.coarse, rel=1e-3)


def test_the_velocity_change_is_the_integral_of_the_acceleration(
    case: Case, variant: Callable[..., Results]
) -> None:
    run = variant("[record]", "every = 1.0")
    effort = np.linalg.norm(run["control.lvlh_force"], axis=1)
    assert np.trapezoid(effort, run.time) == pytest.approx(case.fine, rel=1e-3)


def test_halving_the_step_divides_the_error_by_eight(
    case: Case, variant: Callable[..., Results]
) -> None:
    time, truth = case.precise
    ends = [variant("[simulation]", f"stop_time = {time}", f"step = {step}")
            for step in (5.0, 2.5, 1.25)]
    errors = np.array([run["monitor.position_error"][-1] for run in ends]) - truth
    np.testing.assert_allclose(errors[:-1] / errors[1:], 8.0, rtol=0.1)  # third order


def test_the_lyapunov_function_falls_at_the_rate_of_its_formula(results: Results) -> None:
    later = results.time > 100.0  # the samples of every 10 s resolve it from there
    V, rate = results["monitor.lyapunov"][later], results["monitor.lyapunov_rate"][later]
    slope = np.gradient(V, results.time[later], edge_order=2)
    np.testing.assert_allclose(slope, rate, rtol=0.0, atol=0.01 * np.max(np.abs(rate)))
    assert np.all(np.diff(V) < 0.0)
