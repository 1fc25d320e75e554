"""The comparison law (53)-(55)."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components.controllers.line_of_sight_attitude_controller import (
    LineOfSightAttitudeController,
)

LAW = LineOfSightAttitudeController()
R1, R2 = Rotation.random(2, rng=np.random.default_rng(3))
P1, P2, P3 = np.array([0.0, 1.0, 0.0]), np.array([10.0, 0.0, 2.0]), np.array([3.0, -4.0, 8.0])


def seen(attitude, origin, target):
    """Unit vector to the target in the body frame."""
    return attitude.apply((target - origin) / np.linalg.norm(target - origin), inverse=True)


def normal(attitude, origin, target, third):
    """b_ijk as (55) writes it, from positions."""
    n = np.cross(target - origin, third - origin)
    return attitude.apply(n / np.linalg.norm(n), inverse=True)


def refused(**values):
    conditions = LAW.evaluate("requirements", LAW.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


def test_the_torque_is_that_of_the_law_written_with_positions():
    rate = np.array([0.1, -0.2, 0.3])
    torque = LAW.evaluate("outputs", LAW.start_values() | {
        "line_of_sight": seen(R1, P1, P2), "object_line_of_sight": seen(R1, P1, P3),
        "target_line_of_sight": seen(R2, P2, P1), "target_object_line_of_sight": seen(R2, P2, P3),
        "angular_velocity": rate,
    })["torque"]
    expected = (-0.25 * rate - 0.05 * np.cross(seen(R2, P2, P1), seen(R1, P1, P2))
                - 0.08 * np.cross(normal(R2, P2, P1, P3), normal(R1, P1, P2, P3)))
    np.testing.assert_allclose(torque, expected, atol=1e-15)


def test_equal_attitudes_at_rest_ask_for_nothing():
    torque = LAW.evaluate("outputs", LAW.start_values())["torque"]
    np.testing.assert_array_equal(torque, np.zeros(3))


@pytest.mark.parametrize(("values", "message"), [
    ({"object_line_of_sight": np.array([-1.0, 0.0, 0.0])},
     "object_line_of_sight must not be parallel to line_of_sight"),
    ({"target_object_line_of_sight": np.array([1.0, 0.0, 0.0])},
     "target_object_line_of_sight must not be parallel to target_line_of_sight"),
    ({"line_of_sight": np.array([2.0, 0.0, 0.0])}, "line_of_sight must be a unit vector"),
])
def test_lines_of_sight_without_a_plane_are_refused(values, message):
    assert refused(**values) == [message]
