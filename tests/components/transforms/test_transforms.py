"""LVLH and spherical coordinates: axes, rates and inverses."""

import numpy as np
import pytest

from sightline.components import catalogue
from sightline.components.transforms.spherical import from_spherical

TO_LVLH, TO_INERTIAL, TO_SPHERICAL, KEPLER = (catalogue.find(name)() for name in (
    "InertialToLvlh", "LvlhToInertial", "LvlhToSpherical", "KeplerOrbit"))
OFFSET, DRIFT = np.array([100.0, -200.0, 50.0]), np.array([0.3, 0.1, -0.2])


def chief(time):
    elements = {"semi_major_axis": 12e6, "eccentricity": 0.44, "inclination": 0.9,
                "ascending_node": 1.1, "argument_of_perigee": -0.4, "time": time}
    state = KEPLER.evaluate("outputs", KEPLER.start_values() | {
        n: np.array(v) for n, v in elements.items()})
    return {"chief_position": state["position"], "chief_velocity": state["velocity"]}


def lvlh(time):
    """Of a deputy on a straight inertial line."""
    return TO_LVLH.evaluate("outputs", TO_LVLH.start_values() | chief(time) | {
        "relative_position": OFFSET + time * DRIFT, "relative_velocity": DRIFT})


def evaluate(block, **values):
    return block.evaluate("outputs", block.start_values() | values)


def test_the_axes_point_along_the_motion_off_the_orbits_plane_and_down():
    for offset, expected in (([0.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
                             ([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]),
                             ([-1.0, 0.0, 0.0], [0.0, 0.0, 1.0])):
        seen = evaluate(TO_LVLH, relative_position=np.array(offset))["position"]
        np.testing.assert_allclose(seen, expected, atol=1e-15)


def test_the_velocity_is_the_rate_of_the_position_in_the_frame():
    rate = (lvlh(500.01)["position"] - lvlh(499.99)["position"]) / 0.02
    np.testing.assert_allclose(lvlh(500.0)["velocity"], rate, atol=1e-8)


def test_the_orbit_acceleration_is_the_rate_of_the_orbit_rate():
    rate = (lvlh(501.0)["orbit_rate"] - lvlh(499.0)["orbit_rate"]) / 2.0
    assert lvlh(500.0)["orbit_acceleration"] == pytest.approx(rate, rel=1e-5)


def test_a_force_comes_back_from_the_frame():
    force = evaluate(TO_INERTIAL, **chief(500.0), lvlh_force=np.array([1.0, -2.0, 3.0]))["force"]
    back = TO_LVLH.evaluate("outputs", TO_LVLH.start_values() | chief(500.0) | {
        "relative_position": force})["position"]
    np.testing.assert_allclose(back, [1.0, -2.0, 3.0], rtol=1e-14)


@pytest.mark.parametrize("position", [[3.0, 1.0, -2.0], [-3.0, -1.0, 2.0], [0.5, 4.0, 0.1]])
def test_spherical_coordinates_and_rates_give_position_and_velocity_back(position):
    s = evaluate(TO_SPHERICAL, position=np.array(position), velocity=DRIFT)
    q, velocity, _ = from_spherical(
        np.stack([s["range"], s["elevation"], s["azimuth"]]),
        np.stack([s["range_rate"], s["elevation_rate"], s["azimuth_rate"]]), np.zeros(3))
    np.testing.assert_allclose(q, position, atol=1e-14)
    np.testing.assert_allclose(velocity, DRIFT, atol=1e-14)


def test_azimuth_grows_from_the_velocity_towards_the_zenith():
    up = evaluate(TO_SPHERICAL, position=np.array([1.0, 0.0, -1.0]))
    assert up["azimuth"] == pytest.approx(0.25 * np.pi)


def test_a_position_on_the_normal_axis_is_refused():
    conditions = TO_SPHERICAL.evaluate("requirements", {"position": np.array([0.0, 1.0, 0.0])})
    assert not all(conditions.values())
