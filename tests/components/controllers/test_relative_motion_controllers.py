"""Laws for relative motion in the LVLH frame at single points, and their limits."""

import numpy as np
import pytest

from sightline.components import catalogue
from sightline.components.transforms.spherical import from_spherical

ORBIT = {"orbit_rate": 1.2e-3, "orbit_acceleration": -3e-7, "gravity_gradient": 1.1e-6}
RENDEZVOUS, STATION, TRACKING, SPHERICAL, TO_SPHERICAL = (catalogue.find(name)() for name in (
    "RendezvousController", "StationKeepingController", "RelativeTrackingController",
    "SphericalTrackingController", "LvlhToSpherical"))
Q, V = [100.0, -50.0, 30.0], [0.1, 0.2, -0.3]


def force(block, **values):
    known = block.start_values() | {n: np.asarray(v, float) for n, v in values.items()}
    return block.evaluate("outputs", known)["lvlh_force"]


def closed_loop_poles(gain_along_z, ω=1.1465568779e-3):
    """Of the circular rendezvous in x and z, with Kp = 1e-4 along x and Kd = 0.1."""
    kd = 0.1
    A = np.array([[0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0],
                  [-1e-4, 0.0, -kd, 2.0 * ω], [0.0, 3.0 * ω**2 - gain_along_z, -2.0 * ω, -kd]])
    return np.linalg.eigvals(A)


def test_the_rendezvous_law_is_a_spring_and_a_damper():
    found = force(RENDEZVOUS, position=Q, velocity=V, mass=2.0)
    np.testing.assert_allclose(found, -2.0 * (1e-4 * np.array(Q) + 0.1 * np.array(V)))


def test_station_keeping_is_tracking_of_a_point_less_the_coriolis_terms():
    station = force(STATION, position=Q, velocity=V, **ORBIT)
    tracking = force(TRACKING, position=Q, velocity=V, **ORBIT)
    np.testing.assert_allclose(tracking - station, 2.4e-3 * np.array([0.3, 0.0, 0.1]), atol=1e-15)


def test_without_error_and_gains_both_computed_torques_give_the_same_force():
    s = TO_SPHERICAL.evaluate("outputs", {"position": np.array(Q), "velocity": np.array(V)})
    desired = {f"desired_{n}": v for n, v in s.items()}
    spherical = force(SPHERICAL, **s, **desired, **ORBIT)
    # no spherical acceleration is a rectangular one
    _, _, q_second = from_spherical(
        np.stack([s["range"], s["elevation"], s["azimuth"]]),
        np.stack([s["range_rate"], s["elevation_rate"], s["azimuth_rate"]]), np.zeros(3))
    rectangular = force(TRACKING, position=Q, velocity=V, desired_position=Q, desired_velocity=V,
                        desired_acceleration=q_second, **ORBIT)
    np.testing.assert_allclose(spherical, rectangular, rtol=1e-12)


def test_an_azimuth_error_across_half_a_turn_takes_the_shorter_way():
    near = force(SPHERICAL, azimuth=np.pi - 0.1, desired_azimuth=-np.pi + 0.1)
    same = force(SPHERICAL, azimuth=np.pi - 0.1, desired_azimuth=np.pi + 0.1)
    np.testing.assert_allclose(near, same, atol=1e-18)


@pytest.mark.parametrize(("share", "stable"), [(1.1, True), (0.9, False)])
def test_the_rendezvous_needs_three_times_the_square_of_the_orbit_rate_along_z(share, stable):
    poles = closed_loop_poles(share * 3.0 * 1.1465568779e-3**2)
    assert (np.max(poles.real) < 0.0) == stable


@pytest.mark.parametrize(("block", "gains"), [
    (RENDEZVOUS, ("velocity_gain",)), (STATION, ("position_gain", "velocity_gain")),
    (TRACKING, ("position_gain", "velocity_gain")),
])
def test_gains_that_leave_an_axis_uncontrolled_are_refused(block, gains):
    values = block.start_values() | {name: np.array([1.0, 1.0, 0.0]) for name in gains}
    assert [m for m, ok in block.evaluate("requirements", values).items() if not ok] == [
        f"{name} must be positive on all axes" for name in gains]
