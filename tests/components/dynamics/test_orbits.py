"""Orbits against closed forms and conserved quantities."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components import catalogue
from sightline.components.dynamics.kepler_orbit import eccentric_anomaly
from sightline.components.dynamics.planet_environment import EARTH
from sightline.components.dynamics.three_body_environment import L2, MEAN_MOTION

KEPLER, ORBIT, RELATIVE, THREE_BODY, FOLLOWER = (catalogue.find(name)() for name in (
    "KeplerOrbit", "TwoBodyOrbit", "RelativeOrbit", "ThreeBodyOrbit", "RelativeThreeBodyCraft"))
ELEMENTS = {"semi_major_axis": 12e6, "eccentricity": 0.44, "inclination": 0.9,
            "ascending_node": 1.1, "argument_of_perigee": -0.4, "mean_anomaly": 0.3}
PERIOD = 2.0 * np.pi * np.sqrt(12e6**3 / EARTH)  # s
J2 = {"oblateness": 1.08262668e-3}
DRAG = {"density": 1e-11, "drag_area": 2.2}


def arrays(values):
    return {name: np.asarray(value, float) for name, value in values.items()}


def kepler(time, **elements):
    values = KEPLER.start_values() | arrays(ELEMENTS | elements | {"time": time})
    return np.concatenate(list(KEPLER.evaluate("outputs", values).values()))


def fly(block, start, duration, points=21, scale=1e-9, **values):
    """Times and states of an orbit, by scipy."""
    fixed = block.start_values() | arrays(values)
    names = ("position", "velocity")

    def rate(t, x):
        known = fixed | {"time": np.asarray(t), "position": x[:3], "velocity": x[3:]}
        change = block.evaluate("derivatives", known)
        return np.concatenate([change[name] for name in names])

    times = np.linspace(0.0, duration, points)
    return times, solve_ivp(rate, (0.0, duration), start, "DOP853", rtol=3e-14, atol=scale,
                            t_eval=times).y


def test_the_orbit_is_the_closed_form_over_ten_revolutions():
    times, x = fly(ORBIT, kepler(0.0), 10.0 * PERIOD)
    expected = np.stack([kepler(t) for t in times], axis=1)
    # roundings of 12 000 km grow along the track to a few hundred micrometres
    np.testing.assert_allclose(x[:3], expected[:3], rtol=0.0, atol=2e-3)


@pytest.mark.parametrize("eccentricity", [0.0, 0.01, 0.44, 0.9, 0.99])
def test_keplers_equation_is_solved_to_rounding(eccentricity):
    M = np.linspace(-3.14, 3.14, 101)
    E = np.array([eccentric_anomaly(m, np.asarray(eccentricity)) for m in M])
    np.testing.assert_allclose(E - eccentricity * np.sin(E), M, atol=2e-15)


def test_the_velocity_is_the_rate_of_the_position():
    rate = (kepler(1000.5)[:3] - kepler(999.5)[:3]) / 1.0
    np.testing.assert_allclose(kepler(1000.0)[3:], rate, atol=1e-3)  # jerk of 5e-3 m/s3 by h²/24


def test_oblateness_conserves_energy_and_axial_momentum():
    _, x = fly(ORBIT, kepler(0.0, eccentricity=0.2), 2.0 * PERIOD, **J2)
    r = np.linalg.norm(x[:3], axis=0)
    potential = -EARTH / r * (1.0 - J2["oblateness"] * (6378137.0 / r) ** 2
                              * (1.5 * (x[2] / r) ** 2 - 0.5))
    energy = 0.5 * np.sum(x[3:] ** 2, axis=0) + potential
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12)
    axial = x[0] * x[4] - x[1] * x[3]
    np.testing.assert_allclose(axial, axial[0], rtol=1e-12)


def test_oblateness_turns_the_node_at_its_secular_rate():
    _, x = fly(ORBIT, kepler(0.0, eccentricity=0.001), 10.0 * PERIOD, points=11, **J2)
    normal = np.cross(x[:3].T, x[3:].T)
    node = np.unwrap(np.arctan2(normal[:, 0], -normal[:, 1]))
    secular = -1.5 * J2["oblateness"] * (6378137.0 / 12e6) ** 2 * np.cos(0.9) * 2.0 * np.pi
    assert (node[-1] - node[0]) / 10.0 == pytest.approx(secular, rel=5e-3)  # of order J2 and e


def test_drag_takes_energy_at_its_power():
    values = ORBIT.start_values() | arrays(DRAG | {"mass": 4.0, "planet_rate": 0.0})
    rate = ORBIT.evaluate("derivatives", values)
    position, velocity = values["position"], values["velocity"]
    power = velocity @ rate["velocity"] + EARTH / np.linalg.norm(position) ** 3 * (
        position @ velocity)
    expected = -0.5 * 1e-11 * 2.2 / 4.0 * np.linalg.norm(velocity) ** 3
    assert power == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("perturbation", [{}, J2, DRAG], ids=["none", "oblateness", "drag"])
def test_the_relative_orbit_is_the_difference_of_two_orbits(perturbation):
    chief, deputy = kepler(0.0), kepler(0.0, mean_anomaly=0.301)
    offset = deputy - chief
    fixed = RELATIVE.start_values() | arrays(perturbation) | {
        "chief_position": chief[:3], "chief_velocity": chief[3:],
        "relative_position": offset[:3], "relative_velocity": offset[3:]}
    found = RELATIVE.evaluate("derivatives", fixed)["relative_velocity"]

    def absolute(x, settings):
        values = ORBIT.start_values() | arrays(settings)
        return ORBIT.evaluate("derivatives", values | {"position": x[:3], "velocity": x[3:]})

    chief_settings = {n: v for n, v in perturbation.items() if n != "drag_area"}
    expected = absolute(deputy, perturbation)["velocity"] - absolute(chief,
                                                                     chief_settings)["velocity"]
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-14)  # the difference's rounding


def test_the_jacobi_constant_is_conserved():
    start = np.array([L2 - 2e7, 0.0, 1e7, 0.0, 26.0 + MEAN_MOTION * (L2 - 2e7), 4.0])
    times, x = fly(THREE_BODY, start, 30.0 * 86400.0, scale=1e-6)
    μ1, μ2 = (float(THREE_BODY.quantities[f"{n}_gravitational_parameter"].value)
              for n in ("first", "second"))
    a = float(THREE_BODY.quantities["separation"].value)
    axis = a * np.stack([np.cos(MEAN_MOTION * times), np.sin(MEAN_MOTION * times), 0.0 * times])
    far, near = x[:3] + μ2 / (μ1 + μ2) * axis, x[:3] - μ1 / (μ1 + μ2) * axis
    jacobi = (0.5 * np.sum(x[3:] ** 2, axis=0) - MEAN_MOTION * (x[0] * x[4] - x[1] * x[3])
              - μ1 / np.linalg.norm(far, axis=0) - μ2 / np.linalg.norm(near, axis=0))
    np.testing.assert_allclose(jacobi, jacobi[0], rtol=1e-13)


def test_a_craft_at_l2_stays_in_the_rotating_frame():
    values = THREE_BODY.start_values()
    acceleration = THREE_BODY.evaluate("derivatives", values)["velocity"]
    np.testing.assert_allclose(acceleration, [-MEAN_MOTION**2 * L2, 0.0, 0.0], rtol=1e-8,
                               atol=1e-15)


def test_light_pushes_away_from_the_sun():
    dark, lit = (THREE_BODY.evaluate("derivatives", THREE_BODY.start_values() | arrays(
        {"light_area": area, "mass": 2000.0}))["velocity"] for area in (0.0, 26.0))
    distance = L2 / 1.495978707e11  # a; the Sun is 450 km from the barycentre
    push = 1361.0 / 299792458.0 * 26.0 / 2000.0 / distance**2
    np.testing.assert_allclose(lit - dark, [push, 0.0, 0.0], rtol=1e-5, atol=1e-16)


@pytest.mark.parametrize("areas", [(0.0, 0.0), (26.0, 9.1)], ids=["dark", "lit"])
def test_the_follower_falls_as_the_difference_of_two_craft(areas):
    offset = np.array([3e5, 2e6, -1e6])
    values = arrays({"leader_light_area": areas[0], "leader_mass": 2000.0,
                     "light_area": areas[1], "mass": 500.0, "time": 1e6})
    fixed = FOLLOWER.start_values() | values | {"relative_position": offset}
    found = FOLLOWER.evaluate("derivatives", fixed)["relative_velocity"]

    def absolute(position, area, mass):
        return THREE_BODY.evaluate("derivatives", THREE_BODY.start_values() | arrays(
            {"time": 1e6, "light_area": area, "mass": mass, "position": position}))["velocity"]

    leader = FOLLOWER.start_values()["leader_position"]
    expected = absolute(leader + offset, areas[1], 500.0) - absolute(leader, areas[0], 2000.0)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=5e-18)  # the difference's rounding


def test_the_followers_body_force_turns_with_its_attitude():
    turned = FOLLOWER.start_values() | arrays(
        {"force": [2.0, 0.0, 0.0], "mass": 4.0, "attitude": [0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5)]})
    rate = FOLLOWER.evaluate("derivatives", turned)["relative_velocity"]
    np.testing.assert_allclose(rate, [0.0, 0.5, 0.0], atol=1e-15)
