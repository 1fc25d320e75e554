"""Pulses that valves can make, and a cluster with lag, faults, misalignment and consumption."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components.actuation.one_sided_thruster_cluster import (
    STANDARD_GRAVITY,
    OneSidedThrusterCluster,
)
from sightline.components.actuation.pulse_modulator import PulseModulator
from sightline.components.actuation.thruster_cluster import ThrusterCluster

MODULATOR = PulseModulator(thrusters=1)
CLUSTER = OneSidedThrusterCluster()
IDEAL = ThrusterCluster()
COMMAND = np.linspace(0.05, 0.6, 12)  # N


def pulses(commands, **values):
    """Mean thrusts of successive periods."""
    values = MODULATOR.start_values() | {n: np.asarray(v, float) for n, v in values.items()}
    given = []
    for command in commands:
        values["command"] = np.array([command])
        given.append(MODULATOR.evaluate("outputs", values)["thrust"][0])
        values |= MODULATOR.evaluate("update", values)
    return np.array(given)


def push(**values):
    return CLUSTER.evaluate("outputs", CLUSTER.start_values() | values)


def rate(**values):
    return CLUSTER.evaluate("derivatives", CLUSTER.start_values() | values)


def test_without_quantum_and_minimum_the_mean_thrust_is_the_command():
    np.testing.assert_allclose(pulses([0.1, 0.5, 0.9]), [0.1, 0.5, 0.9], rtol=1e-15)


def test_a_command_is_limited_to_what_a_thruster_gives():
    np.testing.assert_array_equal(pulses([-1.0, 3.0], carry=0.0), [0.0, 1.0])


def test_an_on_time_is_a_multiple_of_the_quantum():
    given = pulses([0.33, 0.68], on_time_quantum=0.02, carry=0.0)  # of periods of 0.1 s
    np.testing.assert_allclose(given, [0.4, 0.6], rtol=1e-14)


def test_a_pulse_below_the_minimum_impulse_is_not_made():
    np.testing.assert_allclose(pulses([0.29, 0.31], minimum_impulse=0.03, carry=0.0), [0.0, 0.31])


def test_what_a_pulse_could_not_give_is_carried_to_the_next():
    given = pulses([0.1] * 9, minimum_impulse=0.03 - 1e-12)
    np.testing.assert_allclose(given, [0.0, 0.0, 0.3] * 3, atol=1e-12)


def test_on_average_small_commands_are_met():
    given = pulses([0.137] * 1000, minimum_impulse=0.03, on_time_quantum=0.01)
    assert given.mean() == pytest.approx(0.137, abs=1e-3)


def test_what_is_carried_does_not_wind_up():
    given = pulses([5.0] * 20 + [0.0] * 3)
    np.testing.assert_array_equal(given[20:], 0.0)


def test_a_modulator_without_period_is_refused():
    values = MODULATOR.start_values() | {"sample_period": np.array(0.0)}
    conditions = MODULATOR.evaluate("requirements", values)
    assert [m for m, holds in conditions.items() if not holds] == [
        "sample_period must be positive"]


def test_by_default_the_cluster_is_ideal():
    ideal = IDEAL.evaluate("outputs", IDEAL.start_values() | {"command": COMMAND})
    given = push(command=COMMAND)
    np.testing.assert_allclose(given["force"], ideal["force"], atol=1e-15)
    np.testing.assert_allclose(given["torque"], ideal["torque"], atol=1e-15)


def test_a_thruster_neither_pulls_nor_gives_more_than_its_limit():
    thrust = push(command=np.where(np.arange(12) < 6, -1.0, 7.0))["thrust"]
    np.testing.assert_array_equal(thrust, np.where(np.arange(12) < 6, 0.0, 1.0))


def test_misalignment_turns_the_force_but_not_its_size():
    turn = np.zeros((12, 3))
    turn[0] = [0.0, 0.0, 0.01]  # rad; the first thruster pushes along x
    force = push(command=np.eye(12)[0], misalignment=turn)["force"]
    np.testing.assert_allclose(force, [np.cos(0.01), np.sin(0.01), 0.0], atol=1e-6)  # angle³/12


@pytest.mark.parametrize(("time", "thrust"), [(9.99, 0.25), (10.0, 1.0), (30.0, 1.0)])
def test_a_valve_that_is_stuck_on_gives_full_thrust(time, thrust):
    given = push(command=np.full(12, 0.25), time=np.array(time),
                 stuck_on_time=np.where(np.arange(12) == 3, 10.0, 1e12))["thrust"]
    np.testing.assert_array_equal(given, np.where(np.arange(12) == 3, thrust, 0.25))


@pytest.mark.parametrize(("time", "thrust"), [(9.99, 0.25), (10.0, 0.0)])
def test_a_valve_that_is_stuck_off_gives_no_thrust(time, thrust):
    given = push(command=np.full(12, 0.25), time=np.array(time),
                 stuck_off_time=np.where(np.arange(12) == 3, 10.0, 1e12))["thrust"]
    np.testing.assert_array_equal(given, np.where(np.arange(12) == 3, thrust, 0.25))


@pytest.mark.parametrize("fault", ["stuck_on_time", "stuck_off_time"])
def test_the_health_mask_shows_a_fault_from_its_time_on(fault):
    when = {fault: np.where(np.arange(12) == 3, 10.0, 1e12)}
    before, after = (push(time=np.array(t), **when)["healthy"] for t in (9.0, 10.0))
    np.testing.assert_array_equal(before, np.ones(12))
    np.testing.assert_array_equal(after, np.where(np.arange(12) == 3, 0.0, 1.0))


def test_thrust_rises_with_its_time_constant():
    times = np.linspace(0.0, 0.2, 5)
    solution = solve_ivp(
        lambda _, F: rate(command=COMMAND, lagged=F, rise_time=np.array(0.05))["lagged"],
        (0.0, 0.2), np.zeros(12), rtol=1e-10, atol=1e-12, t_eval=times)
    np.testing.assert_allclose(solution.y, np.outer(COMMAND, 1.0 - np.exp(-times / 0.05)),
                               atol=1e-8)


def test_thrust_falls_with_a_time_constant_of_its_own():
    falling = rate(command=np.zeros(12), lagged=COMMAND, rise_time=np.array(0.05),
                   fall_time=np.array(0.2))["lagged"]
    np.testing.assert_allclose(falling, -COMMAND / 0.2)


def test_with_lag_the_lagged_thrust_pushes():
    given = push(command=np.ones(12), lagged=COMMAND, rise_time=np.array(0.05))
    np.testing.assert_array_equal(given["thrust"], COMMAND)


def test_the_mass_flow_follows_from_the_specific_impulse():
    impulse = np.linspace(60.0, 300.0, 12)  # s
    expected = np.sum(COMMAND / (STANDARD_GRAVITY * impulse))
    assert push(command=COMMAND, specific_impulse=impulse)["mass_flow"] == pytest.approx(expected)
    assert rate(command=COMMAND, specific_impulse=impulse)["propellant_used"] == pytest.approx(
        expected)
