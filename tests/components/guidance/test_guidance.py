"""Profiles and desired trajectories: ends, rates and frames."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components import catalogue
from sightline.components.guidance.profiles import progress

STEP = 1e-3  # s, of central differences
SETTINGS = {
    "SeparationGuidance": {"direction": [0.0, 0.8, 0.6], "start_distance": 10.0,
                           "end_distance": 200.0, "duration": 100.0, "start_time": 5.0},
    "SphericalApproachGuidance": {"start_range": 1700.0, "start_elevation": 0.6,
                                  "start_azimuth": -0.8, "end_range": 10.0,
                                  "turn_duration": 100.0, "approach_duration": 80.0},
    "WaypointGuidance": {"start_position": [1.0, 2.0, 3.0],
                         "waypoints": [[10.0, 2.0, 3.0], [10.0, -5.0, 0.0]],
                         "departures": [10.0, 100.0], "durations": [60.0, 50.0]},
    "HoldGuidance": {"position": [1.0, 2.0, 3.0]},
}
MOVING = [pytest.param(name, time, id=f"{name}-{time:g}")
          for name in SETTINGS for time in (2.0, 30.0, 120.0, 170.0, 300.0)]


def desired(name, time, **settings):
    block = catalogue.find(name)()
    values = SETTINGS.get(name, {}) | settings | {"time": time}
    return block.evaluate("outputs", block.start_values() | {
        n: np.asarray(v, float) for n, v in values.items()})


@pytest.mark.parametrize("linear", [0.0, 1.0])
@pytest.mark.parametrize(("time", "expected"), [(-1.0, 0.0), (5.0, 0.0), (15.0, 0.5), (25.0, 1.0),
                                                (99.0, 1.0)])
def test_a_profile_passes_from_0_to_1(linear, time, expected):
    s, _, _ = progress(np.array(time), np.array(5.0), np.array(20.0), np.array(linear),
                       np.array(0.0))
    assert s == pytest.approx(expected, abs=1e-15)


@pytest.mark.parametrize("time", [5.0, 25.0])
def test_the_quintic_profile_rests_at_both_ends(time):
    _, rate, acceleration = progress(*map(np.array, (time, 5.0, 20.0, 0.0, 0.0)))
    assert (rate, acceleration) == (0.0, 0.0)


def test_the_linear_profile_moves_until_its_end():
    rates = [progress(*map(np.array, (t, 5.0, 20.0, 1.0, 0.0)))[1] for t in (5.0, 24.99, 25.0)]
    np.testing.assert_allclose(rates, [0.05, 0.05, 0.0])


@pytest.mark.parametrize("time", [4.0, 4.5, 10.0, 24.5])
def test_a_held_acceleration_takes_the_rate_to_that_at_the_end_of_the_hold(time):
    _, before, held = progress(*map(np.array, (time, 5.0, 20.0, 0.0, 2.0)))
    _, after, _ = progress(*map(np.array, (time + 2.0, 5.0, 20.0, 0.0, 2.0)))
    assert before + 2.0 * held == pytest.approx(after, abs=1e-15)


@pytest.mark.parametrize(("name", "time"), MOVING)
def test_the_desired_velocity_is_the_rate_of_the_position(name, time):
    ahead, behind = (desired(name, time + h)["desired_position"] for h in (STEP, -STEP))
    np.testing.assert_allclose(desired(name, time)["desired_velocity"],
                               (ahead - behind) / (2.0 * STEP), atol=1e-7)


@pytest.mark.parametrize(("name", "time"), MOVING)
def test_the_desired_acceleration_is_the_rate_of_the_velocity(name, time):
    ahead, behind = (desired(name, time + h)["desired_velocity"] for h in (STEP, -STEP))
    np.testing.assert_allclose(desired(name, time)["desired_acceleration"],
                               (ahead - behind) / (2.0 * STEP), atol=1e-7)


def test_the_approach_first_turns_at_constant_range_then_closes_in():
    turned = desired("SphericalApproachGuidance", 100.0)["desired_position"]
    arrived = desired("SphericalApproachGuidance", 500.0)["desired_position"]
    np.testing.assert_allclose(turned, [1700.0, 0.0, 0.0], atol=1e-10)
    np.testing.assert_allclose(arrived, [10.0, 0.0, 0.0], atol=1e-12)


def test_waypoints_are_reached_in_order():
    for time, expected in ((0.0, [1.0, 2.0, 3.0]), (80.0, [10.0, 2.0, 3.0]),
                           (200.0, [10.0, -5.0, 0.0])):
        np.testing.assert_allclose(desired("WaypointGuidance", time)["desired_position"], expected)


SLEW = {"axis": [1 / 3, 2 / 3, 2 / 3], "angle": 1.5, "duration": 100.0,
        "start_attitude": Rotation.from_rotvec([0.3, -0.2, 0.9]).as_quat()}


def test_the_slew_ends_turned_by_its_angle_about_its_axis():
    first, last = (Rotation.from_quat(desired("SlewGuidance", t, **SLEW)["desired_attitude"])
                   for t in (0.0, 100.0))
    np.testing.assert_allclose((first.inv() * last).as_rotvec(), 1.5 * np.array(SLEW["axis"]))


def test_the_desired_angular_velocity_turns_the_desired_attitude():
    behind, ahead = (Rotation.from_quat(desired("SlewGuidance", t, **SLEW)["desired_attitude"])
                     for t in (40.0 - STEP, 40.0 + STEP))
    rate = (behind.inv() * ahead).as_rotvec() / (2.0 * STEP)
    now = desired("SlewGuidance", 40.0, **SLEW)
    np.testing.assert_allclose(now["desired_angular_velocity"], rate, atol=1e-9)
