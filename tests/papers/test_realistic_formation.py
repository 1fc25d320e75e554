"""The formation with hardware: errors against a budget from the datasheets' values.

The budget is that of the closed loop linearised about two craft that face each other. With e the
turn from one attitude to the other, across the line of sight, and k1, kΩ, k2, kv the gains

    J e'' + kΩ e' + 2 k1 e = noise of the torques
    d'' + 2 kv d' + 2 k2 (d - d0) = noise of the accelerations

White noise of density N through a gain g into a s² + b s + c gives the variance g² N² / (2 b c);
an error of any spectrum is amplified at most by the largest gain over all frequencies.
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "realistic_formation"
BEFORE, AFTER = (300.0, 400.0), (420.0, 800.0)  # s; the thruster fails at 400 s
FAILED = 8  # the ninth thruster of craft 1

ARCSEC, PER_HOUR = np.radians(1.0) / 3600.0, np.radians(1.0) / 3600.0  # rad; rad/s of 1 deg/h
k1, kΩ, k2, kv, d0, mass = 0.05, 0.25, 0.001, 0.025, 20.0, 10.0
ARW = np.radians(0.15) / 60.0          # rad/s/√Hz of 0.15 deg/√h
GYRO_BIAS = np.hypot(5.0, 0.5) * PER_HOUR
CAMERA_NOISE = 10.0 * ARCSEC           # rad/√Hz
CAMERA_BIAS = np.hypot(60.0, 10.0) * ARCSEC
RANGE_BIAS = np.hypot(0.030, 100e-6 * d0)
RANGE_NOISE = 0.0063                   # m/√Hz
IMPULSE = 1e-3                         # N s, minimum impulse bit
SPEED = 1.4e-3                         # m/s, deviation of the estimated velocity, by the filter


def system(name: str = "system.toml", **overrides: object) -> System:
    return System.from_toml(EXAMPLE / name, {k.replace("__", "."): v for k, v in overrides.items()})


@pytest.fixture(scope="module")
def real(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """800 s as the config describes them."""
    return system().simulate(tmp_path_factory.mktemp("real"))


@pytest.fixture(scope="module")
def ideal(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The same without imperfections."""
    return system("ideal.toml", simulation__step=0.1).simulate(tmp_path_factory.mktemp("ideal"))


@pytest.fixture(scope="module")
def sensitivity() -> np.ndarray:
    """B of the layout, from the config: wrench of each unit thrust about the centre of mass."""
    config = tomllib.loads((EXAMPLE / "system.toml").read_text(encoding="utf-8"))
    table = config["repeat"]["i"]["instances"]["allocation{i}"]["parameters"]
    positions, directions = np.array(table["positions"]), np.array(table["directions"])
    return np.vstack([directions.T, np.cross(positions, directions).T])


def part(results: Results, span: tuple[float, float]) -> np.ndarray:
    return (results.time >= span[0]) & (results.time < span[1])


def misalignment(results: Results) -> np.ndarray:
    """The angle between the line of sight and the other's, turned round, rad."""
    return 2.0 * np.arcsin(np.sqrt(results["monitor.alignment_error"] / 2.0))


def pulse_error(sensitivity: np.ndarray) -> np.ndarray:
    """Deviation of the impulse that a craft's pulses are behind, per axis, N s and N m s.

    Each thruster carries between nothing and one impulse bit, all values alike likely.
    """
    return np.sqrt(np.sum(sensitivity**2, axis=1) / 12.0) * IMPULSE


def pointing_budget(sensitivity: np.ndarray) -> float:
    """Deviation of e about each axis, rad."""
    pulses = pulse_error(sensitivity)[3:].max()
    return float(np.linalg.norm([
        np.sqrt(2.0) * CAMERA_BIAS,               # of two cameras
        kΩ / (2.0 * k1) * np.sqrt(2.0) * GYRO_BIAS,
        CAMERA_NOISE * np.sqrt(2.0 * k1 / kΩ),
        ARW * np.sqrt(kΩ / (2.0 * k1)),
        np.sqrt(2.0) * pulses / kΩ,               # largest gain of s/(J s² + kΩ s + 2 k1)
    ]))


def distance_budget(sensitivity: np.ndarray) -> float:
    """Deviation of the distance, m."""
    pulses = pulse_error(sensitivity)[:3].max() / mass
    return float(np.linalg.norm([
        RANGE_BIAS / np.sqrt(2.0),                # mean of two sensors
        RANGE_NOISE / np.sqrt(2.0) * np.sqrt(k2 / (2.0 * kv)),
        SPEED / np.sqrt(2.0) / np.sqrt(2.0 * k2),  # largest gain of 2 kv/(s² + 2 kv s + 2 k2)
        np.sqrt(2.0) * pulses / (2.0 * kv),
    ]))


@pytest.mark.parametrize("span", [BEFORE, AFTER])
def test_pointing_is_within_its_budget_and_no_better_than_its_noise(
    real: Results, sensitivity: np.ndarray, span: tuple[float, float]
) -> None:
    angle = misalignment(real)[part(real, span)]
    # 95 % of a two-dimensional normal error are within √5.99 deviations
    assert np.quantile(angle, 0.95) < np.sqrt(5.99) * pointing_budget(sensitivity)
    assert np.sqrt(np.mean(angle**2)) > np.sqrt(2.0) * ARW * np.sqrt(kΩ / (2.0 * k1))


@pytest.mark.parametrize("span", [BEFORE, AFTER])
def test_distance_is_within_its_budget(
    real: Results, sensitivity: np.ndarray, span: tuple[float, float]
) -> None:
    error = np.sqrt(real["monitor.range_error_squared"])[part(real, span)]
    assert np.quantile(error, 0.95) < 1.96 * distance_budget(sensitivity)


def test_distance_settles_where_the_sensors_read_the_wanted_one(real: Results) -> None:
    read = 0.5 * (real["range1.range"] + real["range2.range"])[part(real, AFTER)]
    # 20 mm a sample, 2 x 3800 samples: 0.2 mm; the pulses' push wanders by 1.6 mm
    assert np.mean(read) == pytest.approx(d0, abs=3e-3)


def test_failure_leaves_the_errors_as_they_were(real: Results) -> None:
    before, after = (np.sqrt(np.mean(misalignment(real)[part(real, s)] ** 2))
                     for s in (BEFORE, AFTER))
    assert after == pytest.approx(before, rel=0.2)  # of some 100 independent values: 7 %


def test_ideal_formation_has_no_such_errors(ideal: Results) -> None:
    rest = part(ideal, AFTER)
    assert np.max(misalignment(ideal)[rest]) < 0.1 * ARCSEC
    assert np.max(np.sqrt(ideal["monitor.range_error_squared"][rest])) < 2e-3  # e^(-0.025 t) left


def test_allocation_gives_the_wrench_before_and_after_the_failure(
    real: Results, sensitivity: np.ndarray
) -> None:
    for i in ("1", "2"):
        wanted = np.hstack([real[f"control{i}.force"], real[f"control{i}.torque"]])
        given = real[f"allocation{i}.command"] @ sensitivity.T
        np.testing.assert_allclose(given, wanted, rtol=0, atol=1e-9)  # N and N m
    failed = real.time >= 400.0
    assert np.array_equal(real["thrusters1.healthy"][:, FAILED], ~failed)
    assert np.any(real["allocation1.command"][~failed, FAILED] > 0.0)
    assert not np.any(real["allocation1.command"][failed, FAILED])


def test_failure_while_braking_takes_authority_that_the_allocation_reports(
    sensitivity: np.ndarray, tmp_path: Path
) -> None:
    run = system("braking_failure.toml", simulation__stop_time=20.0).simulate(tmp_path)
    lost = run["allocation1.lost_authority"]
    short = lost > 1e-6
    assert 0.2 < np.max(lost) < 0.3
    assert np.array_equal(np.unique(np.round(run.time[short])), np.arange(5.0, 13.0))
    wanted = np.hstack([run["control1.force"], run["control1.torque"]])
    missing = np.hstack([run["allocation1.residual_force"], run["allocation1.residual_torque"]])
    given = run["allocation1.command"] @ sensitivity.T
    np.testing.assert_allclose(given + missing, wanted, rtol=0, atol=1e-9)


@pytest.mark.parametrize("craft", ["1", "2"])
def test_imperfections_cost_propellant(real: Results, ideal: Results, craft: str) -> None:
    used = f"thrusters{craft}.propellant_used"
    assert real[used][-1] > ideal[used][-1]
    keeping = [r[used][-1] - r[used][np.searchsorted(r.time, 400.0)] for r in (real, ideal)]
    assert keeping[0] > 100.0 * keeping[1]


@pytest.mark.parametrize("craft", ["1", "2"])
def test_estimated_velocity_is_as_good_as_the_filter_says(real: Results, craft: str) -> None:
    rest = part(real, (150.0, 800.0))  # thrust is within what the filter takes for unknown
    error = real[f"filter{craft}.relative_velocity"] - real[f"velocity{craft}.relative_velocity"]
    deviation = real[f"filter{craft}.deviation"][:, 3:]
    ratio = np.sqrt(np.mean((error / deviation)[rest] ** 2))
    # 0.5: noise of the sensors alone, a quarter of the variance; 1.2: gyro biases turn what stays
    assert 0.5 < ratio < 1.2
    measured = rest & (real[f"los{craft}.valid"] > 0)
    nis = real[f"filter{craft}.normalised_innovation"][measured]
    assert np.mean(nis) == pytest.approx(3.0, abs=1.96 * np.sqrt(6.0 / len(nis)))


def test_gyro_has_the_noise_of_its_datasheet(real: Results) -> None:
    error = real["gyro1.measured_angular_velocity"] - real["craft1.angular_velocity"]
    at_rest = error[part(real, AFTER)]
    # density over √0.1 s; 3 x 3800 samples: 0.7 %
    assert np.mean(np.std(at_rest, axis=0)) == pytest.approx(ARW / np.sqrt(0.1), rel=0.02)
    assert "gyro1.noise_density: 0.15 deg/sqrt(h) to 4.363323e-05 rad/s/sqrt(Hz)" in (
        real.conversions)


def test_seeds_decide_and_decide_alone(tmp_path: Path) -> None:
    first = system(simulation__stop_time=2.0)
    one = first.simulate(tmp_path / "one")
    first.simulate(tmp_path / "again")
    other = system(simulation__stop_time=2.0, los1__seed=2).simulate(tmp_path / "other")
    files = [(tmp_path / name / "results.h5").read_bytes() for name in ("one", "again")]
    assert files[0] == files[1]
    differs = {n for n in one.series if not np.array_equal(one[n], other[n])}
    assert {"los1.line_of_sight", "craft1.attitude", "craft2.position"} <= differs
    assert not {"gyro1.valid", "thrusters2.healthy"} & differs
