"""The example of the relative attitude control on SO(3) paper, in plain numpy.

The blocks are wired by hand and integrated by scipy at tight tolerance. The expected figures are
the paper's, and those of an independent integration of the same equations.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from sightline.components.controllers.relative_attitude_controller import (
    RelativeAttitudeController,
)
from sightline.components.dynamics.free_rigid_body import FreeRigidBody
from sightline.components.estimators.relative_attitude_determination import (
    RelativeAttitudeDetermination,
)
from sightline.components.maths import conjugate, multiply, unit
from sightline.components.monitors.relative_attitude_monitor import RelativeAttitudeMonitor
from sightline.components.sensors.line_of_sight_sensor import LineOfSightSensor

BODY, LOS, CONTROL = FreeRigidBody(), LineOfSightSensor(), RelativeAttitudeController()
MONITOR, DETERMINATION = RelativeAttitudeMonitor(), RelativeAttitudeDetermination()
DEFAULTS = {block.name: block.start_values() for block in (
    BODY, LOS, CONTROL, MONITOR, DETERMINATION)}
INERTIA = np.diag([0.23, 0.28, 0.35])
POSITIONS = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0]])
OBJECT = np.array([1.0, -5.0, 2.5])
START = np.concatenate([
    Rotation.from_rotvec([np.pi, 0.0, 0.0]).as_quat(), [1.0, 0.5, 0.3],
    Rotation.from_rotvec(0.99 * np.pi * np.array([0.0, -1.0, -2.0]) / np.sqrt(5.0)).as_quat(),
    [0.2, -0.1, 0.6],
])
SYNCHRONISED = tuple(np.eye(4)[3])
TURNED = tuple(Rotation.from_rotvec([0.4, -1.1, 0.7]).as_quat())
RANDOM = list(np.random.default_rng(3).standard_normal((4, 14)))
PUBLISHED = np.array([[0.0547, 0.6200, 0.7827], [-0.0475, -0.7814, 0.6223],
                      [0.9974, -0.0712, -0.0133]])
COMPUTED = np.array([[0.05466575, 0.62000058, 0.78269466], [-0.04751807, -0.78136330, 0.62226476],
                     [0.99737340, -0.07120871, -0.01325258]])


def evaluate(block, **values):
    return block.evaluate("outputs", DEFAULTS[block.name] | values)


def craft(x):
    """Attitudes, of norm 1, and angular velocities of both craft."""
    return [(unit(half[:4]), half[4:]) for half in np.split(x, 2)]


def sight(attitude, here, there):
    return evaluate(LOS, position=here, target_position=there,
                    attitude=attitude)["line_of_sight"]


def measurements(own, other):
    """What the craft of index ``own`` measures, and receives from the other."""
    (i, (R1, ω1)), (j, (R2, _)) = own, other
    return {
        "line_of_sight": sight(R1, POSITIONS[i], POSITIONS[j]),
        "object_line_of_sight": sight(R1, POSITIONS[i], OBJECT),
        "target_line_of_sight": sight(R2, POSITIONS[j], POSITIONS[i]),
        "target_object_line_of_sight": sight(R2, POSITIONS[j], OBJECT),
        "angular_velocity": ω1,
    }


def torques(x, desired):
    both = list(enumerate(craft(x)))
    wanted = (np.array(desired), conjugate(np.array(desired)))
    return [
        evaluate(CONTROL, desired_relative_attitude=Qd, **measurements(*pair))["torque"]
        for pair, Qd in zip((both, both[::-1]), wanted, strict=True)
    ]


def rate(x, desired):
    rates = []
    for (R, ω), torque in zip(craft(x), torques(x, desired), strict=True):
        change = BODY.evaluate("derivatives", DEFAULTS[BODY.name] | {
            "attitude": R, "angular_velocity": ω, "torque": torque, "inertia": INERTIA})
        rates += [change["attitude"], change["angular_velocity"]]
    return np.concatenate(rates)


@cache
def fly(desired, duration):
    return solve_ivp(lambda _, x: rate(x, desired), (0.0, duration), START, "DOP853", rtol=1e-12,
                     atol=1e-13, dense_output=True).sol


def watch(x, desired=SYNCHRONISED):
    (R1, ω1), (R2, ω2) = craft(x)
    return evaluate(MONITOR, position=POSITIONS[0], attitude=R1, angular_velocity=ω1,
                    target_position=POSITIONS[1], target_attitude=R2, target_angular_velocity=ω2,
                    object_position=OBJECT, inertia=INERTIA, target_inertia=INERTIA,
                    desired_relative_attitude=np.array(desired))


def matrices(x):
    return [Rotation.from_quat(R).as_matrix() for R, _ in craft(x)]


@pytest.mark.parametrize("number", [0, 1])
def test_both_craft_reach_the_published_attitude(number):
    reached = matrices(fly(SYNCHRONISED, 10.0)(10.0))[number]
    np.testing.assert_allclose(reached, PUBLISHED, atol=5e-5)  # half a printed digit


@pytest.mark.parametrize("number", [0, 1])
def test_both_craft_reach_the_computed_attitude(number):
    reached = matrices(fly(SYNCHRONISED, 10.0)(10.0))[number]
    np.testing.assert_allclose(reached, COMPUTED, atol=1e-5)  # they still differ by 9e-6


def test_the_first_craft_reaches_the_computed_attitude_to_its_last_digit():
    np.testing.assert_allclose(matrices(fly(SYNCHRONISED, 10.0)(10.0))[0], COMPUTED, atol=6e-9)


def test_the_errors_start_at_the_published_values():
    errors = watch(START)
    np.testing.assert_allclose([errors["alignment_error"], errors["normal_error"]],
                               [1.9995, 2.0], atol=5e-5)


@pytest.mark.parametrize(("time", "alignment", "normal"), [
    (1.0, 1.8162532, 1.7589429), (2.0, 0.3335308, 0.2108352), (5.0, 1.03959e-5, 1.78614e-5),
    (10.0, 1.377e-11, 4.189e-11),
])
def test_the_errors_fall_as_computed(time, alignment, normal):
    errors = watch(fly(SYNCHRONISED, 10.0)(time))
    np.testing.assert_allclose(errors["alignment_error"], alignment, rtol=4e-4)
    np.testing.assert_allclose(errors["normal_error"], normal, rtol=4e-4)


def test_the_torques_have_the_computed_peaks():
    solution = fly(SYNCHRONISED, 10.0)
    norms = [np.linalg.norm(torques(solution(t), SYNCHRONISED), axis=1)
             for t in np.linspace(0.0, 10.0, 2001)]
    np.testing.assert_allclose(np.max(norms, axis=0), [0.979, 0.525], atol=5e-4)


def test_any_wanted_relative_attitude_is_reached():
    (R1, _), (R2, _) = craft(fly(TURNED, 40.0)(40.0))
    reached = multiply(conjugate(R2), R1)
    assert abs(reached @ np.array(TURNED)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("x", RANDOM)
@pytest.mark.parametrize("desired", [SYNCHRONISED, TURNED])
def test_the_lyapunov_function_falls_as_its_formula_says(x, desired):
    h = 1e-5  # s; central difference, error h² V'''/6
    x = np.concatenate([np.concatenate(pair) for pair in craft(x)])
    ahead, behind = (watch(x + s * h * rate(x, desired), desired) for s in (1.0, -1.0))
    slope = (ahead["lyapunov"] - behind["lyapunov"]) / (2.0 * h)
    assert slope == pytest.approx(watch(x, desired)["lyapunov_rate"], abs=1e-7)


@pytest.mark.parametrize("x", RANDOM)
def test_the_attitude_error_is_that_of_the_matrices(x):
    R1, R2 = matrices(x)
    difference = Rotation.from_quat(TURNED).as_matrix().T @ R2.T @ R1
    skew = 0.5 * (difference - difference.T)
    expected = [skew[2, 1], skew[0, 2], skew[1, 0]]
    np.testing.assert_allclose(watch(x, TURNED)["attitude_error"], expected, atol=1e-14)


@pytest.mark.parametrize("x", [START, *RANDOM])
def test_the_relative_attitude_is_found_from_lines_of_sight(x):
    both = list(enumerate(craft(x)))
    seen = measurements(*both)
    seen.pop("angular_velocity")
    found = Rotation.from_quat(evaluate(DETERMINATION, **seen)["relative_attitude"])
    R1, R2 = matrices(x)
    np.testing.assert_allclose(found.as_matrix(), R2.T @ R1, atol=1e-14)
