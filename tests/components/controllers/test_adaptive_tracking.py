"""Adaptive laws on the plants that they are made for: their Lyapunov functions fall as stated."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from sightline.components import catalogue
from sightline.components.controllers import adaptive_tracking as at
from sightline.components.dynamics.rigid_rotation import angular_acceleration
from sightline.components.maths import quaternion_rate, rotate, unit

TRANSLATION, ATTITUDE, MONITOR = (catalogue.find(name)() for name in (
    "AdaptiveTranslationController", "AdaptiveAttitudeController", "PrecisionFormationMonitor"))
INERTIA = np.array([[320.0, -15.0, 10.0], [-15.0, 280.0, -12.0], [10.0, -12.0, 250.0]])
θ1, θ2 = np.array([2e-5, -1e-5, 3e-5]), np.array([-1e-5, 4e-5, 0.0])  # m/s2
FAST = np.array(1e-3)  # rad/s, so that θ2 turns
TURNED = Rotation.from_rotvec([0.4, -0.7, 0.3]).as_quat()
SPIN = np.array([0.01, -0.02, 0.015])


def outputs(block, **values):
    return block.evaluate("outputs", block.start_values() | values)


def derivatives(block, **values):
    return block.evaluate("derivatives", block.start_values() | values)


def translate(times, believed_mass=1.0):
    """States under constant θ (5): x, x', θ^1, θ^2; a craft of 1 kg that should stay at 0."""

    def rate(t, x):
        known = {"time": np.asarray(t), "relative_position": x[:3], "relative_velocity": x[3:6],
                 "inertial_estimate": x[6:9], "rotating_estimate": x[9:], "orbit_rate": FAST,
                 "mass": np.array(believed_mass)}
        u = outputs(TRANSLATION, **known)["force"]
        learning = derivatives(TRANSLATION, **{n: v for n, v in known.items() if n != "mass"})
        return np.concatenate([x[3:6], u - θ1 - at.to_inertial(θ2, FAST * t),
                               *learning.values()])

    x0 = np.concatenate([[0.1, -0.2, 0.05], np.zeros(9)])
    return solve_ivp(rate, (0.0, times[-1]), x0, "DOP853", rtol=1e-11, atol=1e-14,
                     t_eval=times).y.T


def watch_translation(x):
    return outputs(MONITOR, relative_position=x[:3], relative_velocity=x[3:6],
                   inertial_estimate=x[6:9], rotating_estimate=x[9:], inertial_disturbance=θ1,
                   rotating_disturbance=θ2)


def turn(times, adaptation_gain, estimate, attitude=TURNED, spin=SPIN):
    """States of a body that should come to rest at the identity: q, ω, θ^_R."""

    def rate(_, x):
        known = {"attitude": unit(x[:4]), "angular_velocity": x[4:7], "inertia_estimate": x[7:]}
        torque = outputs(ATTITUDE, **known)["torque"]
        learning = derivatives(ATTITUDE, adaptation_gain=np.array(adaptation_gain), **known)
        return np.concatenate([quaternion_rate(unit(x[:4]), x[4:7]),
                               angular_acceleration(INERTIA, x[4:7], torque),
                               learning["inertia_estimate"]])

    x0 = np.concatenate([attitude, spin, estimate])
    return solve_ivp(rate, (0.0, times[-1]), x0, "DOP853", rtol=1e-11, atol=1e-14,
                     t_eval=times).y.T


def watch_rotation(x, adaptation_gain):
    return outputs(MONITOR, attitude=unit(x[:4]), angular_velocity=x[4:7],
                   inertia_estimate=x[7:], inertia=INERTIA,
                   rotation_adaptation_gain=np.array(adaptation_gain))


def slopes(times, watched, name):
    """Central differences at the inner samples, and the formula there."""
    V = np.array([w[name] for w in watched])
    rates = np.array([w[f"{name}_rate"] for w in watched])
    fourth = (V[:-4] - 8.0 * V[1:-3] + 8.0 * V[3:-1] - V[4:]) / (12.0 * (times[1] - times[0]))
    return fourth, rates[2:-2]


def test_the_lyapunov_function_of_translation_falls_at_its_rate():
    times = np.arange(0.0, 2000.0, 5.0)
    slope, rate = slopes(times, [watch_translation(x) for x in translate(times)],
                         "translation_lyapunov")
    assert np.all(rate < 0.0)
    np.testing.assert_allclose(slope, rate, rtol=0.0, atol=1e-6 * np.max(np.abs(rate)))


def test_translation_converges_under_constant_disturbances():
    last = translate(np.array([0.0, 8e4]))[-1]
    assert np.linalg.norm(last[:3]) < 1e-9


def test_translation_converges_with_a_wrong_mass():
    last = translate(np.array([0.0, 8e4]), believed_mass=1.4)[-1]
    assert np.linalg.norm(last[:3]) < 1e-9


def test_a_force_held_in_a_turning_body_is_right_in_the_middle_of_the_hold():
    known = {"relative_position": np.array([0.3, -0.1, 0.2])}
    u = outputs(TRANSLATION, **known)["acceleration"]
    held = outputs(TRANSLATION, attitude=TURNED, angular_velocity=SPIN,
                   hold_time=np.array(0.5), **known)["force"]
    middle = (Rotation.from_quat(TURNED) * Rotation.from_rotvec(0.25 * SPIN)).as_quat()
    np.testing.assert_allclose(rotate(middle, held), u, rtol=1e-6)  # (½ h ω)³/12


def sampled_translation(period, ticks):
    """States at the ticks of a law sampled with this period, under constant θ1: x, x', θ^1."""
    x, v, learnt, rows = np.array([0.1, -0.2, 0.05]), np.zeros(3), np.zeros(3), []
    for _ in range(ticks):
        known = {"relative_position": x, "relative_velocity": v, "inertial_estimate": learnt,
                 "sample_period": np.array(period), "orbit_rate": np.array(0.0)}
        held = TRANSLATION.evaluate("update", TRANSLATION.start_values() | known)
        a = outputs(TRANSLATION, **known)["acceleration"] - θ1
        learnt = learnt + period * derivatives(TRANSLATION, **known, **held)["inertial_estimate"]
        x, v = x + period * v + 0.5 * period**2 * a, v + period * a
        rows.append(np.concatenate([x, v, learnt]))
    return np.array(rows)


def test_a_sampled_translation_law_converges_and_learns_the_disturbance():
    last = sampled_translation(period=20.0, ticks=4000)[-1]
    assert np.linalg.norm(last[:3]) < 1e-9


@pytest.mark.parametrize(("block", "estimate"), [(TRANSLATION, "inertial_estimate"),
                                                 (ATTITUDE, "inertia_estimate")])
def test_a_sampled_law_learns_at_the_rate_of_the_last_tick_whatever_happens_since(block, estimate):
    then = {name: np.array(value) for name, value in (
        ("relative_position", [0.3, -0.1, 0.2]), ("angular_velocity", SPIN), ("attitude", TURNED),
    ) if name in block.quantities}
    period = {"sample_period": np.array(0.5)}
    held = block.evaluate("update", block.start_values() | period | then)
    since = derivatives(block, **period, **held)
    np.testing.assert_array_equal(since[estimate], derivatives(block, **then)[estimate])
    assert np.all(np.abs(since[estimate][:3]) > 0.0)


@pytest.mark.parametrize("gain", [1e9, 0.0])
def test_the_lyapunov_function_of_rotation_falls_at_its_rate(gain):
    estimate = at.inertia_vector(INERTIA) * (1.0 if gain == 0.0 else 0.7)
    times = np.arange(0.0, 200.0, 0.25)
    slope, rate = slopes(times, [watch_rotation(x, gain) for x in turn(times, gain, estimate)],
                         "rotation_lyapunov")
    assert np.all(rate < 0.0)
    # the samples of every 0.25 s resolve the learning to 1e-4
    np.testing.assert_allclose(slope, rate, rtol=0.0, atol=2e-4 * np.max(np.abs(rate)))


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_body_at_rest_turns_the_short_way_whatever_the_sign_of_its_quaternion(sign):
    times = np.arange(0.0, 2000.0, 1.0)
    x = turn(times, 1e9, at.inertia_vector(INERTIA), sign * TURNED, np.zeros(3))
    angle = Rotation.from_quat(TURNED).magnitude()
    turned = np.trapezoid(np.linalg.norm(x[:, 4:7], axis=1), times)
    assert np.linalg.norm(x[-1, :3]) < 1e-5  # arrived, but for the slow tail of the learning
    assert turned == pytest.approx(angle, rel=0.05)  # unwinding would turn 2π less the angle


def test_the_sign_of_a_quaternion_does_not_matter():
    same = [outputs(ATTITUDE, attitude=a * TURNED, desired_attitude=b * TURNED[[1, 0, 2, 3]],
                    angular_velocity=SPIN)["torque"] for a in (1.0, -1.0) for b in (1.0, -1.0)]
    np.testing.assert_array_equal(same[1:], [same[0]] * 3)


def test_the_attitude_error_is_the_angle_between_the_attitudes():
    there = Rotation.from_rotvec([0.2, 0.1, -2.9])
    error = at.attitude_error(there.as_quat(), SPIN, TURNED, np.zeros(3))
    expected = (Rotation.from_quat(TURNED).inv() * there).magnitude()
    assert error.angle == pytest.approx(expected, rel=1e-14)


def test_the_regressor_is_the_transpose_of_the_product_with_the_inertia():
    w, s = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.7, -1.1])
    θ = at.inertia_vector(INERTIA)
    np.testing.assert_allclose(at.inertia_times(θ, w), INERTIA @ w)
    assert at.inertia_regressor(w, s) @ θ == pytest.approx(s @ INERTIA @ w)


def test_the_rotating_frame_turns_about_z():
    turned = at.to_rotating(np.array([1.0, 2.0, 3.0]), np.array(0.3))
    expected = Rotation.from_rotvec([0.0, 0.0, -0.3]).apply([1.0, 2.0, 3.0])
    np.testing.assert_allclose(turned, expected, rtol=1e-14)
    np.testing.assert_allclose(at.to_inertial(turned, np.array(0.3)), [1.0, 2.0, 3.0])
