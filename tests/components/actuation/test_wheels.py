"""Wheel allocation against the body that the wheels turn, and against the pseudo-inverse."""

import numpy as np
import pytest

from sightline.components.actuation.wheel_allocation import WheelAllocation
from sightline.components.dynamics.rigid_body_with_wheels import RigidBodyWithWheels

RNG = np.random.default_rng(11)
TORQUES = list(RNG.standard_normal((5, 3)))
INERTIA = np.array([[2.1, -0.2, 0.1], [-0.2, 1.9, 0.05], [0.1, 0.05, 1.4]])
UPRIGHT = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.6, 0.8, 0.0]])


def allocate(wheels, torque):
    block = WheelAllocation(wheels=wheels)
    return block.evaluate("outputs", block.start_values() | {"torque": torque})["wheel_torque"]


def refused(**values):
    block = WheelAllocation()
    conditions = block.evaluate("requirements", block.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


@pytest.mark.parametrize("torque", TORQUES)
@pytest.mark.parametrize("wheels", [3, 4])
def test_a_body_at_rest_turns_as_the_wanted_torque_says(wheels, torque):
    body = RigidBodyWithWheels(wheels=wheels)
    values = body.start_values() | {"inertia": INERTIA, "wheel_torque": allocate(wheels, torque)}
    turning = body.evaluate("derivatives", values)["angular_velocity"]
    np.testing.assert_allclose(turning, np.linalg.inv(INERTIA) @ torque, atol=1e-14)


@pytest.mark.parametrize("torque", TORQUES)
def test_four_wheels_share_the_torque_by_the_pseudo_inverse(torque):
    axes = WheelAllocation(wheels=4).start_values()["wheel_axes"]
    np.testing.assert_allclose(allocate(4, torque), -np.linalg.pinv(axes.T) @ torque, atol=1e-14)


def test_axes_in_a_plane_are_refused():
    assert refused(wheel_axes=UPRIGHT) == [
        "wheel_axes must give torque about all axes (for other than 3 or 4 wheels, give them)"]


def test_axes_of_another_length_are_refused():
    assert refused(wheel_axes=2.0 * np.eye(3)) == ["each row of wheel_axes must be a unit vector"]


def test_five_wheels_need_axes():
    block = WheelAllocation(wheels=5)
    conditions = block.evaluate("requirements", block.start_values())
    assert not all(conditions.values())
