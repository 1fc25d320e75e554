"""Rigid bodies with wheels and with propellant against invariants and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components.dynamics.depleting_rigid_body import DepletingRigidBody
from sightline.components.dynamics.rigid_body_with_wheels import RigidBodyWithWheels
from sightline.components.maths import rotate, unit

WHEELED, DEPLETING = RigidBodyWithWheels(wheels=4), DepletingRigidBody()
INERTIA = np.array([[2.1, -0.2, 0.1], [-0.2, 1.9, 0.05], [0.1, 0.05, 1.4]])
GRAVITY = 9.80665  # m/s2


def fly(block, duration, **values):
    """States at the end, and all other values."""
    values = block.start_values() | {n: np.asarray(v, float) for n, v in values.items()}
    states = block.expected("derivatives")
    sizes = np.cumsum([q.size for q in states.values()])[:-1]

    def named(x):
        parts = np.split(x, sizes)
        return {n: part.reshape(q.dimensions)
                for (n, q), part in zip(states.items(), parts, strict=True)}

    def rate(_, x):
        rates = block.evaluate("derivatives", values | named(x))
        return np.concatenate([np.ravel(rates[n]) for n in states])

    start = np.concatenate([np.ravel(values[n]) for n in states])
    end = solve_ivp(rate, (0.0, duration), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return values | named(end)


def momentum(values):
    wheels = WHEELED.evaluate("outputs", values)["wheel_momentum"]
    stored = values["inertia"] @ values["angular_velocity"] + wheels
    return rotate(unit(values["attitude"]), stored)


def refused(block, **values):
    numbers = {n: np.asarray(v, float) for n, v in values.items()}
    conditions = block.evaluate("requirements", block.start_values() | numbers)
    return [m for m, holds in conditions.items() if not holds]


SPINNING = {"inertia": INERTIA, "angular_velocity": [0.3, -0.2, 0.5],
            "wheel_speed": [100.0, -200.0, 50.0, 300.0], "wheel_inertia": [2e-3, 2e-3, 3e-3, 1e-3]}
TORQUE = np.array([0.02, -0.01, 0.03, 0.005])  # N m


@pytest.mark.parametrize("torque", [np.zeros(4), TORQUE])
def test_total_momentum_stays_whatever_the_wheels_do(torque):
    start = fly(WHEELED, 0.0, **SPINNING)
    end = fly(WHEELED, 20.0, wheel_torque=torque, **SPINNING)
    np.testing.assert_allclose(momentum(end), momentum(start), atol=1e-10)


def test_kinetic_energy_stays_without_motor_torque():
    def energy(values):
        Ω, spin = values["angular_velocity"], values["wheel_inertia"]
        against_space = values["wheel_speed"] + values["wheel_axes"] @ Ω
        return 0.5 * Ω @ values["inertia"] @ Ω + 0.5 * np.sum(spin * against_space**2)

    start, end = (fly(WHEELED, duration, **SPINNING) for duration in (0.0, 20.0))
    assert energy(end) == pytest.approx(energy(start), rel=1e-11)


def test_a_wheel_turns_the_body_the_other_way():
    end = fly(RigidBodyWithWheels(), 10.0, wheel_torque=[0.0, 0.0, 1e-3], inertia=np.eye(3))
    assert end["angular_velocity"][2] == pytest.approx(-1e-2, rel=1e-10)
    assert end["wheel_speed"][2] == pytest.approx(10.0 + 1e-2, rel=1e-10)


def test_a_motor_gives_no_more_than_its_limit():
    end = fly(RigidBodyWithWheels(), 10.0, wheel_torque=[0.0, 0.0, 5.0], inertia=np.eye(3),
              torque_limit=np.full(3, 1e-3))
    assert end["angular_velocity"][2] == pytest.approx(-1e-2, rel=1e-10)


@pytest.mark.parametrize(("torque", "accelerates"), [(1e-3, False), (-1e-3, True)])
def test_a_wheel_at_its_speed_limit_can_only_be_slowed(torque, accelerates):
    block = RigidBodyWithWheels()
    rates = block.evaluate("derivatives", block.start_values() | {
        "wheel_torque": np.full(3, torque), "wheel_speed": np.full(3, 50.0),
        "speed_limit": np.full(3, 50.0)})
    assert (rates["wheel_speed"][0] != 0.0) == accelerates


def test_external_torque_changes_the_total_momentum():
    start = fly(WHEELED, 0.0, **SPINNING)
    rates = WHEELED.evaluate("derivatives", start | {"torque": np.array([0.1, 0.2, 0.3])})
    free = WHEELED.evaluate("derivatives", start)
    change = rates["angular_velocity"] - free["angular_velocity"]
    wheels = rates["wheel_speed"] - free["wheel_speed"]
    given = INERTIA @ change + start["wheel_axes"].T @ (
        start["wheel_inertia"] * (wheels + start["wheel_axes"] @ change))
    np.testing.assert_allclose(given, [0.1, 0.2, 0.3], atol=1e-14)


def test_wheel_axes_must_be_unit_vectors():
    assert refused(WHEELED, wheel_axes=np.ones((4, 3))) == [
        "each row of wheel_axes must be a unit vector"]


def test_a_burn_gives_the_velocity_of_the_rocket_equation():
    force, impulse = 4.0, 220.0  # N, s
    flow = force / (GRAVITY * impulse)
    end = fly(DEPLETING, 300.0, force=[force, 0.0, 0.0], mass_flow=flow, dry_mass=3.0,
              propellant=2.0)
    expected = GRAVITY * impulse * np.log(5.0 / (5.0 - 300.0 * flow))
    assert end["velocity"][0] == pytest.approx(expected, rel=1e-10)


def test_propellant_falls_by_its_flow():
    assert fly(DEPLETING, 10.0, mass_flow=0.02)["propellant"] == pytest.approx(0.8)


def test_without_propellant_the_mass_stays():
    rates = DEPLETING.evaluate("derivatives", DEPLETING.start_values() | {
        "propellant": np.array(0.0), "mass_flow": np.array(0.02)})
    assert rates["propellant"] == 0.0


@pytest.mark.parametrize(("propellant", "mass", "empty"), [(0.5, 1.5, 0.0), (0.0, 1.0, 1.0)])
def test_mass_and_emptiness_follow_the_propellant(propellant, mass, empty):
    said = DEPLETING.evaluate("outputs", DEPLETING.start_values() | {
        "propellant": np.array(propellant)})
    assert (said["mass"], said["empty"]) == (mass, empty)


def test_the_inertia_goes_from_full_to_dry():
    rates = [DEPLETING.evaluate("derivatives", DEPLETING.start_values() | {
        "dry_inertia": np.eye(3), "full_inertia": 3.0 * np.eye(3),
        "torque": np.array([6.0, 0.0, 0.0]), "propellant": np.array(left),
        "full_propellant": np.array(2.0)})["angular_velocity"][0] for left in (2.0, 1.0, 0.0)]
    np.testing.assert_allclose(rates, [2.0, 3.0, 6.0])


def test_an_impossible_inertia_is_refused_by_its_name():
    assert refused(DEPLETING, full_inertia=np.diag([1.0, 1.0, 0.0])) == [
        "full_inertia must be positive definite",
    ]
