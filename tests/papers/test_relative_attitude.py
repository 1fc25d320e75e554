"""The example of the relative attitude paper, co-simulated from its config with real FMUs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "relative_attitude"
PUBLISHED = np.array([[0.0547, 0.6200, 0.7827], [-0.0475, -0.7814, 0.6223],
                      [0.9974, -0.0712, -0.0133]])
COMPUTED = np.array([[0.05466575, 0.62000058, 0.78269466], [-0.04751807, -0.78136330, 0.62226476],
                     [0.99737340, -0.07120871, -0.01325258]])
ERRORS = {  # computed by DOP853: t -> (Ψα, Ψβ)
    1: (1.8162532, 1.7589429), 2: (0.3335308, 0.2108352), 5: (1.03959e-5, 1.78614e-5),
    10: (1.377e-11, 4.189e-11),
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 10 s at 50 µs."""
    return System.from_toml(EXAMPLE / "system.toml").simulate(tmp_path_factory.mktemp("attitude"))


def at(results: Results, time: float, signal: str) -> np.ndarray:
    return results[signal][np.argmin(np.abs(results.time - time))]


def attitude(results: Results, craft: str) -> np.ndarray:
    return Rotation.from_quat(at(results, 10.0, f"{craft}.attitude")).as_matrix()


@pytest.mark.parametrize("craft", ["craft1", "craft2"])
def test_both_craft_reach_the_published_attitude(results: Results, craft: str) -> None:
    np.testing.assert_allclose(attitude(results, craft), PUBLISHED, atol=5e-5)


@pytest.mark.parametrize("time", ERRORS)
def test_the_errors_are_those_of_the_table(results: Results, time: float) -> None:
    errors = [at(results, time, f"monitor.{name}") for name in ("alignment_error", "normal_error")]
    np.testing.assert_allclose(errors, ERRORS[time], rtol=2e-3)


def test_the_errors_start_at_the_published_values(results: Results) -> None:
    errors = [at(results, 0.0, f"monitor.{name}") for name in ("alignment_error", "normal_error")]
    np.testing.assert_allclose(errors, [1.9995, 2.0], atol=5e-5)


@pytest.mark.parametrize(("control", "peak"), [("control1", 0.979), ("control2", 0.525)])
def test_the_torques_have_the_computed_peaks(results: Results, control: str, peak: float) -> None:
    norms = np.linalg.norm(results[f"{control}.torque"], axis=1)
    assert norms.max() == pytest.approx(peak, abs=1e-3)


def test_the_relative_attitude_is_determined_all_along(results: Results) -> None:
    first, second = (Rotation.from_quat(results[f"{craft}.attitude"])
                     for craft in ("craft1", "craft2"))
    determined = Rotation.from_quat(results["determination.relative_attitude"])
    error = (determined.inv() * second.inv() * first).magnitude()
    assert error.max() < 1e-7  # an angle from a matrix that is exact to 1e-15


def test_halving_the_step_halves_the_error(tmp_path: Path) -> None:
    errors = []
    for step in (0.002, 0.001, 0.0005):
        config = tmp_path / "variant.toml"
        config.write_text(f"extends = '{EXAMPLE / 'system.toml'}'\n[simulation]\nstep = {step}\n")
        run = System.from_toml(config).simulate(tmp_path)
        errors.append(attitude(run, "craft1")[1, 0] - COMPUTED[1, 0])
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 2.0, rtol=0.05)  # torques held: first order
