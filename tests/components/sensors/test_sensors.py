"""What ideal and biased sensors measure, against scipy's rotations."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components import catalogue

RNG = np.random.default_rng(2)
ATTITUDES = list(Rotation.random(4, rng=RNG).as_quat())
HERE, THERE = np.array([1.0, -2.0, 0.5]), np.array([20.0, 3.0, -7.0])


def measure(block, **values):
    """The first output of a sensor."""
    sensor = catalogue.find(block)()
    outputs = sensor.evaluate("outputs", sensor.start_values() | values)
    return outputs[sensor.channels[0].output]


def sees(block, **values):
    """Whether a sensor says that its outputs are a measurement."""
    sensor = catalogue.find(block)()
    return sensor.evaluate("outputs", sensor.start_values() | values)["valid"] > 0.5


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


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_the_star_tracker_measures_the_attitude(attitude):
    np.testing.assert_allclose(measure("StarTracker", attitude=attitude), attitude, atol=1e-15)


def test_the_bias_of_the_star_tracker_is_a_small_rotation_in_the_body_frame():
    bias = np.array([1e-4, -2e-4, 3e-4])  # rad
    biased = Rotation.from_quat(measure("StarTracker", attitude=ATTITUDES[0], bias=bias))
    error = Rotation.from_quat(ATTITUDES[0]).inv() * biased
    np.testing.assert_allclose(error.as_rotvec(), bias, atol=1e-11)  # |bias|³/12


def test_the_radar_measures_range_and_angles():
    radar = catalogue.find("SphericalRadar")()
    r, ψ, θ = 30.0, 0.4, -0.7
    position = np.array([r * np.cos(ψ) * np.cos(θ), r * np.sin(ψ), -r * np.cos(ψ) * np.sin(θ)])
    said = radar.evaluate("outputs", radar.start_values() | {"position": position})
    np.testing.assert_allclose([said["range"], said["elevation"], said["azimuth"]], [r, ψ, θ])


def test_relative_navigation_measures_position_and_velocity():
    sensor = catalogue.find("LvlhNavigationSensor")()
    said = sensor.evaluate("outputs", sensor.start_values() | {"position": HERE, "velocity": THERE})
    np.testing.assert_array_equal([said["measured_position"], said["measured_velocity"]],
                                  [HERE, THERE])


@pytest.mark.parametrize(("angle", "seen"), [(0.0, True), (0.29, True), (0.31, False),
                                             (3.0, False)])
@pytest.mark.parametrize(("block", "port"), [("LineOfSightSensor", "target_position"),
                                             ("SphericalRadar", "position")])
def test_a_target_beyond_the_field_of_view_is_not_seen(block, port, angle, seen):
    target = 10.0 * np.array([np.cos(angle), 0.0, np.sin(angle)])
    assert sees(block, field_of_view=np.array(0.3), **{port: target}) == seen


@pytest.mark.parametrize(("distance", "seen"), [(1.9, False), (2.1, True), (49.0, True),
                                                (51.0, False)])
@pytest.mark.parametrize("block", ["LineOfSightSensor", "RangeSensor"])
def test_a_target_out_of_range_is_not_seen(block, distance, seen):
    limits = {"minimum_range": np.array(2.0), "maximum_range": np.array(50.0)}
    assert sees(block, target_position=np.array([0.0, distance, 0.0]), **limits) == seen


def test_a_star_tracker_loses_its_stars_in_a_fast_turn():
    limit = {"maximum_rate": np.array(0.05)}
    assert sees("StarTracker", angular_velocity=np.array([0.04, 0.0, 0.0]), **limit)
    assert not sees("StarTracker", angular_velocity=np.array([0.06, 0.0, 0.0]), **limit)
