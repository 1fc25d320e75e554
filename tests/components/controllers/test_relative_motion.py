"""The equations of relative motion against Newton's law, and their properties."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components.controllers import relative_motion as rm
from sightline.components.dynamics.gravity import gravity, gravity_difference
from sightline.components.dynamics.kepler_orbit import KeplerOrbit
from sightline.components.dynamics.planet_environment import EARTH
from sightline.components.transforms.inertial_to_lvlh import InertialToLvlh
from sightline.components.transforms.lvlh_to_spherical import LvlhToSpherical

CHIEF, TO_LVLH, TO_SPHERICAL = KeplerOrbit(), InertialToLvlh(), LvlhToSpherical()
RNG = np.random.default_rng(4)
POINTS = [pytest.param(np.array([r, ψ, θ]), rate, id=f"{n}") for n, (r, ψ, θ, rate) in enumerate(
    (RNG.uniform(1.0, 50.0), RNG.uniform(-1.0, 1.0), RNG.uniform(-3.0, 3.0),
     RNG.standard_normal(3) * [0.05, 1e-3, 1e-3]) for _ in range(6))]
ω, ω_rate, k = np.array(1.2e-3), np.array(-3e-7), np.array(1.1e-6)


def chief(time):
    return CHIEF.evaluate("outputs", CHIEF.start_values() | {
        "time": np.array(time), "semi_major_axis": np.array(12e6), "eccentricity": np.array(0.44)})


def motion(x0, times):
    """Position, velocity and orbit of a free deputy in the LVLH frame, by Newton's law."""

    def rate(t, x):
        return np.concatenate([x[3:], gravity_difference(EARTH, chief(t)["position"], x[:3])])

    flown = solve_ivp(rate, (0.0, times[-1]), x0, "DOP853", rtol=1e-13, atol=1e-13, t_eval=times).y
    return [TO_LVLH.evaluate("outputs", TO_LVLH.start_values() | {
        "chief_position": chief(t)["position"], "chief_velocity": chief(t)["velocity"],
        "relative_position": x[:3], "relative_velocity": x[3:]})
        for t, x in zip(times, flown.T, strict=True)]


def spherical(state):
    s = TO_SPHERICAL.evaluate("outputs", {n: state[n] for n in ("position", "velocity")})
    return (np.stack([s["range"], s["elevation"], s["azimuth"]]),
            np.stack([s["range_rate"], s["elevation_rate"], s["azimuth_rate"]]))


START = np.array([30.0, 40.0, -20.0, 0.02, -0.03, 0.01])  # m, m/s
AROUND = 1000.0 + np.array([-1.0, -0.5, 0.0, 0.5, 1.0])  # s
FIVE_POINTS = np.array([1.0, -8.0, 0.0, 8.0, -1.0]) / 6.0  # first derivative at step 0.5 s


def test_the_rectangular_equations_are_newtons_law_near_the_chief():
    states = motion(START, AROUND)
    q_second = FIVE_POINTS @ np.array([s["velocity"] for s in states])
    now = states[2]
    residual = q_second + rm.coriolis(now["velocity"], now["orbit_rate"]) + rm.gravity_terms(
        now["position"], now["orbit_rate"], now["orbit_acceleration"], now["gravity_gradient"])
    scale = now["gravity_gradient"] * np.linalg.norm(now["position"])
    assert np.linalg.norm(residual) < 5e-5 * scale  # 3 |q|/r_c of the linearisation


def test_the_spherical_equations_are_newtons_law_near_the_chief():
    states = motion(START, AROUND)
    second = FIVE_POINTS @ np.array([spherical(s)[1] for s in states])
    now = states[2]
    q, q_rate = spherical(now)
    orbit = now["orbit_rate"], now["orbit_acceleration"], now["gravity_gradient"]
    residual = (rm.spherical_inertia(q) * second
                + rm.spherical_coriolis(q, q_rate, orbit[0]) @ q_rate
                + rm.spherical_gravity(q, *orbit))
    scale = now["gravity_gradient"] * np.array([q[0], q[0] ** 2, q[0] ** 2])
    assert np.max(np.abs(residual) / scale) < 1e-4  # 3 |q|/r_c of the linearisation


@pytest.mark.parametrize(("q", "rate"), POINTS)
def test_the_rate_of_the_inertia_less_twice_the_coriolis_matrix_is_skew(q, rate):
    h = 1e-6
    inertia_rate = np.diag(rm.spherical_inertia(q + h * rate)
                           - rm.spherical_inertia(q - h * rate)) / (2.0 * h)
    N = inertia_rate - 2.0 * rm.spherical_coriolis(q, rate, ω)
    np.testing.assert_allclose(N + N.T, 0.0, atol=1e-6)  # central difference of r² to 1e-16/h


@pytest.mark.parametrize(("q", "rate"), POINTS)
def test_the_potential_is_the_same_in_both_coordinates(q, rate):
    r, ψ, θ = q
    position = r * np.array([np.cos(ψ) * np.cos(θ), np.sin(ψ), -np.cos(ψ) * np.sin(θ)])
    np.testing.assert_allclose(rm.spherical_potential(q, ω, k), rm.potential(position, ω, k),
                               rtol=1e-12)


@pytest.mark.parametrize(("q", "rate"), POINTS)
def test_the_conservative_gravity_terms_are_the_gradient_of_the_potential(q, rate):
    h = 1e-4 * np.eye(3)
    gradient = [(rm.spherical_potential(q + step, ω, k) - rm.spherical_potential(q - step, ω, k))
                / 2e-4 for step in h]
    np.testing.assert_allclose(rm.spherical_gravity(q, ω, np.array(0.0), k), gradient,
                               rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3, 2e5])
def test_gravity_differences_keep_their_digits(size):
    """Against the same difference with 50 more bits."""
    position = np.array([1.51e11, 3e9, 1e7])
    offset = size * np.array([0.6, -0.64, 0.48])
    exact, far = offset.astype(np.longdouble), position.astype(np.longdouble)
    r, s = np.sqrt(far @ far), np.sqrt((far + exact) @ (far + exact))
    q = exact @ (2 * far + exact) / (far @ far)
    series = q * (3 + 3 * q + q * q) / (1 + (1 + q) ** np.longdouble(1.5))
    expected = -(exact - series * far) / (s * s * s) * np.longdouble(1.3e20)
    found = gravity_difference(np.array(1.3e20), position, offset)
    np.testing.assert_allclose(found, expected.astype(float), rtol=2e-15)
    assert r > 0.0


def test_gravity_differences_are_differences_of_gravity():
    position, offset = np.array([7e6, -1e5, 2e6]), np.array([3e5, 2e5, -1e5])
    difference = gravity(EARTH, position + offset) - gravity(EARTH, position)
    np.testing.assert_allclose(gravity_difference(EARTH, position, offset), difference, rtol=1e-13)
