"""The scenario of the 6-DOF precision formation flying paper, co-simulated from its config."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import simpson

from sightline.components.dynamics.rigid_body_with_wheels import default_axes
from sightline.components.maths import rotate
from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "precision_formation"
ERRORS = {  # computed by DOP853: t, s -> |e|, m
    600: 1.255e-3, 1020: 1.566e-3, 3600: 1.120e-4, 43200: 8.687e-5, 86400: 1.798e-6,
    129600: 1.780e-6,
}  # fmt: skip
BETWEEN = {  # the same by test_precision_formation_equations; guidance kinks at 86400 s
    7200: 5.1860e-6, 21600: 4.4310e-5, 64800: 5.3434e-5, 84360: 2.7183e-6, 86520: 1.78735e-6,
    86760: 1.77426e-6, 108000: 1.77876e-6,
}  # fmt: skip
ORDERS = {"hold": 1, "linear": 2, "quadratic": 3}
LIMIT = 0.1  # N
EXHAUST = 220.0 * 9.80665  # m/s, impulse per mass of propellant
WHEELS, SPIN_INERTIA = default_axes(4), 0.05  # kg m2
LEADER_INERTIA = np.diag([1500.0, 1400.0, 1300.0])  # kg m2


def variant(folder: Path, base: str, *lines: str) -> Results:
    """The run of one of the example's configs with other settings."""
    config = folder / "variant.toml"
    config.write_text("\n".join([f"extends = '{EXAMPLE / base}'", *lines]), encoding="utf-8")
    return System.from_toml(config).simulate(folder)


def at(results: Results, name: str, time: float) -> float:
    """A scalar at a recorded instant."""
    return float(results[name][np.argmin(np.abs(results.time - time))])


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 36 h at 1 s."""
    return System.from_toml(EXAMPLE / "system.toml").simulate(tmp_path_factory.mktemp("precision"))


@pytest.mark.parametrize("time", ERRORS)
def test_the_position_error_is_within_half_a_percent_of_the_table(
    results: Results, time: float
) -> None:
    assert at(results, "monitor.position_error", time) == pytest.approx(ERRORS[time], rel=5e-3)


@pytest.mark.parametrize("time", BETWEEN)
def test_the_position_error_is_within_1_percent_between_the_table_s_instants(
    results: Results, time: float
) -> None:
    assert at(results, "monitor.position_error", time) == pytest.approx(BETWEEN[time], rel=1e-2)


def test_the_attitude_error_peaks_as_computed(results: Results) -> None:
    arcseconds = np.degrees(results["monitor.attitude_error"]) * 3600.0
    assert arcseconds.max() == pytest.approx(359.0, rel=0.01)
    assert results.time[np.argmax(arcseconds)] == 420.0
    assert results.time[np.flatnonzero(arcseconds >= 1.0)[-1] + 1] == 2220.0


def test_the_effort_is_the_computed_one(results: Results) -> None:
    acceleration = np.linalg.norm(results["translation.acceleration"], axis=1)
    assert acceleration.max() == pytest.approx(1.5468e-4, rel=0.01)
    torque = np.linalg.norm(results["rotation.torque"], axis=1)
    assert torque.max() == pytest.approx(7.326e-4, rel=0.01)
    assert np.abs(results["allocation.command"]).max() == pytest.approx(0.01655, rel=0.01)


def test_the_inertia_estimate_stays_near_its_computed_value(results: Results) -> None:
    np.testing.assert_allclose(results["rotation.inertia_estimate"][-1],
                               [229.0, 209.0, 190.0, 29.0, 17.0, 16.0], atol=0.6)


@pytest.mark.parametrize("name", ["monitor.translation_lyapunov", "monitor.rotation_lyapunov"])
def test_the_lyapunov_functions_fall_while_the_environment_is_constant(
    results: Results, name: str
) -> None:
    turning = results.time <= 1800.0  # the slew ends, and what the rotation can learn with it
    assert np.all(np.diff(results[name][turning]) < 0.0)


def test_the_leader_ends_looking_at_the_follower(results: Results) -> None:
    looks = rotate(results["leader_body.attitude"][-1], np.array([1.0, 0.0, 0.0]))
    x = results["follower.relative_position"][-1]
    np.testing.assert_allclose(looks, x / np.linalg.norm(x), atol=5e-6)  # 1 arcsecond


def test_the_wheels_take_the_momentum_of_the_leader_s_body(results: Results) -> None:
    rate = results["leader_body.angular_velocity"]
    speed = results["leader_body.wheel_speed"]
    wheels = SPIN_INERTIA * (speed + rate @ WHEELS.T) @ WHEELS
    assert np.linalg.norm(wheels, axis=1).max() > 2.0  # N m s
    np.testing.assert_allclose(wheels, -rate @ LEADER_INERTIA, atol=1e-9)  # RK4 over 1800 s


def test_the_leader_s_orbit_is_ballistic(results: Results) -> None:
    np.testing.assert_array_equal(results["leader.control_acceleration"], 0.0)


def test_bidirectional_thrusters_give_the_computed_impulse(results: Results) -> None:
    thrust = np.abs(results["allocation.command"]).sum(axis=1)
    assert simpson(thrust, x=results.time) == pytest.approx(7041.0, abs=0.5)


@pytest.fixture(scope="module", params=[("one_sided", 7532.0), ("non_negative", 7041.0)],
                ids=lambda case: case[0])
def pushed(request: pytest.FixtureRequest,
           tmp_path_factory: pytest.TempPathFactory) -> tuple[Results, float]:
    """A run with thrusters that only push, at 10 s, and the computed impulse, N s."""
    name, impulse = request.param
    run = variant(tmp_path_factory.mktemp(name), f"{name}.toml", "[simulation]", "step = 10.0")
    return run, impulse


def test_thrusters_that_only_push_give_the_computed_impulse(
    pushed: tuple[Results, float]
) -> None:
    run, impulse = pushed
    assert EXHAUST * run["thrusters.propellant_used"][-1] == pytest.approx(impulse, abs=0.5)


def test_thrusters_that_only_push_stay_within_the_computed_thrust(
    pushed: tuple[Results, float]
) -> None:
    thrust = pushed[0]["thrusters.thrust"]
    assert thrust.min() >= 0.0
    assert thrust.max() == pytest.approx(0.03311, abs=5e-6)


@pytest.mark.parametrize("pair", [("thrusters.force", "translation.force"),
                                  ("thrusters.torque", "rotation.torque")])
def test_thrusters_that_only_push_leave_no_residual(
    pushed: tuple[Results, float], pair: tuple[str, str]
) -> None:
    run, (given, wanted) = pushed[0], pair
    np.testing.assert_allclose(run[given], run[wanted], atol=5e-12)  # interior point; shift 1e-16


@pytest.mark.parametrize("time", ERRORS)
def test_thrusters_that_only_push_keep_the_position_error(
    pushed: tuple[Results, float], time: float
) -> None:
    assert at(pushed[0], "monitor.position_error", time) == pytest.approx(ERRORS[time], rel=5e-3)


@pytest.mark.parametrize("coupling", ORDERS)
def test_positions_converge_at_the_order_of_the_coupling(coupling: str, tmp_path: Path) -> None:
    ends = [variant(tmp_path, "system.toml", "[simulation]", f"coupling = '{coupling}'",
                    f"step = {step}", "stop_time = 600.0", "[record]", "every = 600.0",
                    )["follower.relative_position"][-1] for step in (10.0, 5.0, 2.5)]
    coarse, fine = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    assert coarse / fine == pytest.approx(2.0 ** ORDERS[coupling], rel=0.03)


@pytest.fixture(scope="module")
def held(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run with commands held over steps of 1 s, aimed at the middle of each."""
    holds = [f"[instances.{name}.parameters]\nhold_time = 1.0"
             for name in ("separation", "slew", "translation")]
    return variant(tmp_path_factory.mktemp("held"), "system.toml", "[simulation]",
                   "coupling = 'hold'", *holds)


@pytest.mark.parametrize("time", ERRORS)
def test_commands_held_for_a_second_keep_the_error_within_5_percent_of_the_table(
    held: Results, time: float
) -> None:
    assert at(held, "monitor.position_error", time) == pytest.approx(ERRORS[time], rel=0.05)
