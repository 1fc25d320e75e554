"""Relative velocity estimators on simulated flights: exact, unbiased, consistent."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from sightline.components.estimators.relative_velocity_differentiator import (
    RelativeVelocityDifferentiator,
)
from sightline.components.estimators.relative_velocity_kalman_filter import (
    RelativeVelocityKalmanFilter,
)

DIFFERENTIATOR, FILTER = RelativeVelocityDifferentiator(), RelativeVelocityKalmanFilter()
T = 0.1  # s
TURN = np.array([0.05, -0.1, 0.2])  # rad/s, of the observer
POSITION, VELOCITY = np.array([20.0, 3.0, -5.0]), np.array([0.02, -0.3, 0.1])
SEEDS = range(100)


def fly(block, count, seed=None, density=0.0, deviations=(0.1, 1e-3), lost=(), **settings):
    """Outputs and true relative velocity in the body frame at each tick.

    The target moves with white-noise acceleration of this density; deviations are those of range
    and angles, without a seed there is no noise at all.
    """
    rng = np.random.default_rng(seed)
    p, v, outputs, truth = POSITION, VELOCITY, [], []
    values = block.start_values() | {n: np.asarray(x, float) for n, x in settings.items()}
    for k in range(count):
        body = Rotation.from_rotvec(k * T * TURN).inv()
        d, b = np.linalg.norm(p), body.apply(p / np.linalg.norm(p))
        if seed is not None:
            d = d + deviations[0] * rng.standard_normal()
            b = Rotation.from_rotvec(deviations[1] * rng.standard_normal(3)).apply(b)
        values |= {"line_of_sight": b, "range": np.array(d), "angular_velocity": TURN,
                   "valid": np.array(float(k not in lost)), "sample_period": np.array(T)}
        outputs.append(block.evaluate("outputs", values))
        truth.append(body.apply(v))
        values |= block.evaluate("update", values)
        sudden = density * np.sqrt(T) * rng.standard_normal((2, 3))  # exact discrete white noise
        p = p + T * v + T * (0.5 * sudden[0] + sudden[1] / np.sqrt(12.0))
        v = v + sudden[0]
    return {n: np.array([o[n] for o in outputs]) for n in outputs[0]}, np.array(truth)


def refused(block, **values):
    conditions = block.evaluate("requirements", block.start_values() | values)
    return [m for m, holds in conditions.items() if not holds]


@pytest.mark.parametrize("block", [DIFFERENTIATOR, FILTER], ids=lambda b: b.name)
def test_a_steady_velocity_is_found_exactly_from_a_turning_craft(block):
    said, truth = fly(block, 400)
    np.testing.assert_allclose(said["relative_velocity"][-1], truth[-1], atol=1e-6)


def test_the_differentiator_settles_with_its_time_constant():
    said, truth = fly(DIFFERENTIATOR, 60, time_constant=0.8)
    error = np.linalg.norm(said["relative_velocity"] - truth, axis=1)
    np.testing.assert_allclose(error[20] / error[12], np.exp(-1.0), rtol=1e-9)


def test_the_differentiator_smooths_noise_in_proportion_to_its_time_constant():
    spread = []
    for τ in (1.0, 4.0):
        said, truth = fly(DIFFERENTIATOR, 1500, seed=1, time_constant=τ)
        spread.append(np.std((said["relative_velocity"] - truth)[300:]))
    assert spread[0] / spread[1] == pytest.approx(4.0, rel=0.1)


@pytest.mark.parametrize("block", [DIFFERENTIATOR, FILTER], ids=lambda b: b.name)
def test_a_lost_measurement_leaves_the_estimate_on_its_way(block):
    said, truth = fly(block, 400, lost=range(300, 340))
    np.testing.assert_allclose(said["relative_velocity"][340:], truth[340:], atol=1e-4)


@cache
def hundred_flights():
    """NIS from the 20th tick on, and the last velocity error in deviations, of every seed."""
    innovations, errors = [], []
    for k in SEEDS:
        said, truth = fly(FILTER, 60, seed=k, density=0.01, acceleration_density=0.01,
                          velocity_deviation=0.2)
        innovations.append(said["normalised_innovation"][20:])
        errors.append((said["relative_velocity"] - truth)[-1] / said["deviation"][-1, 3:])
    return np.array(innovations), np.array(errors)


def test_the_normalised_innovation_is_within_its_95_percent_bounds_over_a_hundred_seeds():
    innovations, _ = hundred_flights()
    bounds = chi2.ppf([0.025, 0.975], 3 * innovations.size) / innovations.size
    assert bounds[0] < innovations.mean() < bounds[1]


def test_single_innovations_are_within_their_95_percent_bounds_as_often_as_they_should():
    innovations, _ = hundred_flights()
    inside = (innovations > chi2.ppf(0.025, 3)) & (innovations < chi2.ppf(0.975, 3))
    assert inside.mean() == pytest.approx(0.95, abs=0.01)  # three deviations


def test_the_velocity_error_has_the_deviation_that_the_filter_says():
    _, errors = hundred_flights()
    assert np.mean(errors**2) == pytest.approx(1.0, abs=0.25)  # 300 values: three deviations


def test_a_known_acceleration_is_no_surprise():
    values = FILTER.start_values() | {"started": np.array(1.0), "sample_period": np.array(T)}
    still = FILTER.evaluate("update", values)["predicted"]
    pushed = FILTER.evaluate("update", values | {"acceleration": np.array([0.0, 2.0, 0.0])})
    np.testing.assert_allclose(pushed["predicted"] - still, [0.0, 0.01, 0.0, 0.0, 0.2, 0.0])


@pytest.mark.parametrize("block", [DIFFERENTIATOR, FILTER], ids=lambda b: b.name)
def test_an_estimator_without_period_is_refused(block):
    assert refused(block, sample_period=np.array(0.0)) == ["sample_period must be positive"]


@pytest.mark.parametrize("wrong", [
    np.diag([1.0, 1.0, -1.0, 1.0, 1.0, 1.0]), np.zeros((6, 6)), np.full((6, 6), np.nan),
    np.eye(6) + np.eye(6, k=1) * 1e-3,
], ids=["negative", "zero", "nan", "asymmetric"])  # fmt: skip
def test_a_start_that_is_no_covariance_is_refused(wrong):
    message = "covariance must be symmetric and positive definite"
    assert refused(FILTER, covariance=wrong) == [message]


def test_a_covariance_of_very_unequal_units_is_accepted():
    scales = np.diag([1e3, 1e3, 1e3, 1e-6, 1e-6, 1e-6])
    assert refused(FILTER, covariance=scales @ (np.eye(6) + 0.5) @ scales) == []
