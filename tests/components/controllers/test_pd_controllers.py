"""The plain baselines: right direction, right size, insensitive to a quaternion's sign."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components import catalogue

WANTED = Rotation.from_rotvec([0.3, -1.0, 0.5])
ERROR = np.array([1e-4, -2e-4, 3e-4])  # rad, in the body frame


def act(name, **values):
    block = catalogue.find(name)()
    numbers = {n: np.asarray(v, float) for n, v in values.items()}
    return block.evaluate("outputs", block.start_values() | numbers)


def ports(block):
    """What wiring checks of inputs and outputs."""
    return {n: (q.dimensions, q.unit, q.frame)
            for n, q in (block.inputs_ | block.outputs_).items()}


def test_the_torque_is_against_a_small_error_of_attitude():
    attitude = (WANTED * Rotation.from_rotvec(ERROR)).as_quat()
    acted = act("AttitudePdController", attitude=attitude, desired_attitude=WANTED.as_quat())
    np.testing.assert_allclose(acted["attitude_error"], ERROR, atol=1e-11)  # |error|³/24
    np.testing.assert_allclose(acted["torque"], -0.1 * ERROR, atol=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_attitude_torque_turns_the_short_way_round(sign):
    attitude = sign * Rotation.from_rotvec([0.0, 0.0, 3.0]).as_quat()
    assert act("AttitudePdController", attitude=attitude)["torque"][2] < 0.0


def test_the_wanted_angular_velocity_is_given_in_the_wanted_body_frame():
    spin = np.array([0.1, 0.2, -0.3])  # rad/s
    turned = Rotation.from_rotvec([0.0, 0.0, 1.0])
    values = {"attitude": turned.as_quat(), "attitude_gain": 0.0,
              "angular_velocity": turned.apply(spin, inverse=True),
              "desired_angular_velocity": spin}
    np.testing.assert_allclose(act("AttitudePdController", **values)["torque"], 0.0, atol=1e-15)


def test_the_position_force_is_in_the_body_frame():
    quarter = Rotation.from_rotvec([0.0, 0.0, np.pi / 2]).as_quat()
    force = act("PositionPdController", attitude=quarter, position=[2.0, 0.0, 0.0], mass=3.0)
    np.testing.assert_allclose(force["force"], [0.0, 3.0 * 0.02, 0.0], atol=1e-15)


def test_the_position_force_adds_spring_damping_and_wanted_acceleration():
    force = act("PositionPdController", velocity=[1.0, 0.0, 0.0], desired_position=[0.0, 1.0, 0.0],
                desired_velocity=[0.0, 0.0, 1.0], desired_acceleration=[1.0, 1.0, 1.0], mass=2.0)
    np.testing.assert_allclose(force["force"], [2.0 * 0.8, 2.0 * 1.01, 2.0 * 1.2])


def test_the_line_of_sight_baseline_is_law_a_where_law_a_does_not_couple():
    values = {"range": 25.0, "relative_velocity": [1.0, 2.0, 3.0], "mass": 10.0,
              "angular_velocity": [0.1, 0.2, 0.3]}  # facing each other: no coupling
    np.testing.assert_equal(act("LineOfSightPdController", **values),
                            act("LineOfSightFormationController", **values))


def test_the_line_of_sight_baseline_can_stand_in_for_the_formation_controller():
    baseline, formation = (catalogue.find(name)() for name in (
        "LineOfSightPdController", "LineOfSightFormationController"))
    assert ports(baseline) == ports(formation)
