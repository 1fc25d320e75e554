"""What ideal and biased sensors measure, against scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components import catalogue

RNG = np.random.default_rng(2)
ATTITUDES = list(Rotation.random(4, rng=RNG).as_quat())
HERE, THERE = np.array([1.0, -2.0, 0.5]), np.array([20.0, 3.0, -7.0])


def measure(block, **values):
    """The only output of a sensor."""
    sensor = catalogue.find(block)()
    (measured,) = sensor.evaluate("outputs", sensor.start_values() | values).values()
    return measured


def refused(block, **values):
    sensor = catalogue.find(block)()
    conditions = sensor.evaluate("requirements", sensor.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_the_line_of_sight_is_the_unit_vector_to_the_target_in_the_body_frame(attitude):
    measured = measure("LineOfSightSensor", position=HERE, target_position=THERE,
                       attitude=attitude)
    direction = (THERE - HERE) / np.linalg.norm(THERE - HERE)
    expected = Rotation.from_quat(attitude).apply(direction, inverse=True)
    np.testing.assert_allclose(measured, expected, atol=1e-15)


def test_the_bias_of_the_line_of_sight_is_a_small_rotation_in_the_body_frame():
    bias = np.array([1e-4, -2e-4, 3e-4])  # rad
    ideal = measure("LineOfSightSensor", target_position=THERE, attitude=ATTITUDES[0])
    biased = measure("LineOfSightSensor", target_position=THERE, attitude=ATTITUDES[0], bias=bias)
    expected = Rotation.from_rotvec(bias).apply(ideal)
    np.testing.assert_allclose(biased, expected, atol=1e-11)  # |bias|³/12


def test_a_biased_line_of_sight_is_a_unit_vector():
    biased = measure("LineOfSightSensor", target_position=THERE, bias=np.array([0.1, 0.2, -0.3]))
    assert np.linalg.norm(biased) == pytest.approx(1.0, abs=1e-15)


def test_a_target_at_the_sensor_is_refused():
    assert refused("LineOfSightSensor", position=HERE, target_position=HERE) == [
        "target_position must differ from position"
    ]


@pytest.mark.parametrize("block", ["LineOfSightSensor", "RelativeVelocitySensor"])
def test_an_attitude_that_is_not_a_unit_quaternion_is_refused(block):
    assert refused(block, attitude=np.zeros(4)) == ["attitude must be a unit quaternion"]


def test_the_range_is_the_distance():
    measured = measure("RangeSensor", position=HERE, target_position=THERE)
    assert measured == pytest.approx(np.sqrt(19.0**2 + 5.0**2 + 7.5**2), rel=1e-15)


def test_the_bias_of_the_range_adds():
    assert measure("RangeSensor", bias=np.array(0.25)) == 1.25


def test_the_gyro_measures_the_angular_velocity():
    np.testing.assert_array_equal(measure("Gyro", angular_velocity=HERE), HERE)


def test_the_bias_of_the_gyro_adds():
    np.testing.assert_array_equal(measure("Gyro", angular_velocity=HERE, bias=THERE), HERE + THERE)


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_the_relative_velocity_is_the_difference_in_the_body_frame(attitude):
    measured = measure("RelativeVelocitySensor", velocity=HERE, target_velocity=THERE,
                       attitude=attitude)
    expected = Rotation.from_quat(attitude).apply(THERE - HERE, inverse=True)
    np.testing.assert_allclose(measured, expected, atol=1e-14)


def test_the_bias_of_the_relative_velocity_adds_in_the_body_frame():
    bias = np.array([0.1, 0.2, 0.3])
    values = {"target_velocity": THERE, "attitude": ATTITUDES[0]}
    difference = (measure("RelativeVelocitySensor", bias=bias, **values)
                  - measure("RelativeVelocitySensor", **values))
    np.testing.assert_allclose(difference, bias, atol=1e-14)
