"""The scenario of the 6-DOF precision formation flying paper, co-simulated from its config."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "precision_formation"
ERRORS = {  # computed by DOP853: t, s -> |e|, m
    600: 1.255e-3, 1020: 1.566e-3, 3600: 1.120e-4, 43200: 8.687e-5, 86400: 1.798e-6,
    129600: 1.780e-6,
}  # fmt: skip
AT_600 = 1.25477206e-3  # m, the first of these with more digits


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 36 h at 2 s."""
    return System.from_toml(EXAMPLE / "system.toml").run(tmp_path_factory.mktemp("precision"))


def error_at_600(folder: Path, step: float) -> float:
    """|e| after 600 s at another step."""
    config = folder / "variant.toml"
    config.write_text(f"extends = '{EXAMPLE / 'system.toml'}'\n[simulation]\nstop_time = 600.0\n"
                      f"step = {step}\n[record]\nevery = 600.0\n", encoding="utf-8")
    return float(System.from_toml(config).run(folder)["monitor.position_error"][-1])


@pytest.mark.parametrize("time", ERRORS)
def test_the_position_error_is_within_half_a_percent_of_the_table(
    results: Results, time: float
) -> None:
    error = results["monitor.position_error"][np.argmin(np.abs(results.time - time))]
    assert error == pytest.approx(ERRORS[time], rel=5e-3)


def test_the_attitude_error_peaks_as_computed(results: Results) -> None:
    arcseconds = np.degrees(results["monitor.attitude_error"]) * 3600.0
    assert arcseconds.max() == pytest.approx(359.0, rel=0.01)
    assert results.time[np.argmax(arcseconds)] == 420.0
    assert results.time[np.flatnonzero(arcseconds >= 1.0)[-1] + 1] == 2220.0


def test_the_effort_is_the_computed_one(results: Results) -> None:
    acceleration = np.linalg.norm(results["translation.acceleration"], axis=1)
    assert acceleration.max() == pytest.approx(1.5468e-4, rel=0.01)
    torque = np.linalg.norm(results["rotation.torque"], axis=1)
    assert torque.max() == pytest.approx(7.326e-4, rel=0.01)
    assert np.abs(results["allocation.command"]).max() == pytest.approx(0.01655, rel=0.01)


def test_the_inertia_estimate_stays_near_its_computed_value(results: Results) -> None:
    np.testing.assert_allclose(results["rotation.inertia_estimate"][-1],
                               [229.0, 209.0, 190.0, 29.0, 17.0, 16.0], atol=0.6)


def test_halving_the_step_divides_the_error_of_the_error_by_eight(tmp_path: Path) -> None:
    off = np.array([error_at_600(tmp_path, step) for step in (10.0, 5.0, 2.5)]) - AT_600
    np.testing.assert_allclose(off[:-1] / off[1:], 8.0, rtol=0.1)  # third order


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run with commands held over steps of 1 s, aimed at the middle of each."""
    folder = tmp_path_factory.mktemp("held")
    holds = [f"[instances.{name}.parameters]\nhold_time = 1.0"
             for name in ("separation", "slew", "translation")]
    config = folder / "held.toml"
    config.write_text("\n".join([f"extends = '{EXAMPLE / 'system.toml'}'", "[simulation]",
                                 "step = 1.0", "coupling = 'hold'", *holds]), encoding="utf-8")
    return System.from_toml(config).run(folder)


@pytest.mark.parametrize("time", ERRORS)
def test_commands_held_for_a_second_keep_the_error_within_5_percent_of_the_table(
    held: Results, time: float
) -> None:
    error = held["monitor.position_error"][np.argmin(np.abs(held.time - time))]
    assert error == pytest.approx(ERRORS[time], rel=0.05)
