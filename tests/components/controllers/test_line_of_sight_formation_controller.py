"""Laws A and B, term by term."""

import numpy as np
import pytest

from sightline.components.controllers.line_of_sight_formation_controller import (
    LineOfSightFormationController,
)

LAW = LineOfSightFormationController()
B12 = np.array([0.6, 0.8, 0.0])
B21 = np.array([0.0, 0.28, -0.96])


def act(**values):
    return LAW.evaluate("outputs", LAW.start_values() | {
        name: np.asarray(value, float) for name, value in values.items()
    })


def refused(**values):
    conditions = LAW.evaluate("requirements", LAW.start_values() | {
        name: np.asarray(value, float) for name, value in values.items()
    })
    return [message for message, holds in conditions.items() if not holds]


def test_the_formation_at_rest_asks_for_nothing():
    wrench = act(range=20.0)
    np.testing.assert_array_equal([wrench["force"], wrench["torque"]], np.zeros((2, 3)))


def test_the_torque_turns_the_lines_of_sight_against_each_other():
    wrench = act(line_of_sight=B12, target_line_of_sight=B21)
    np.testing.assert_allclose(wrench["torque"], -0.05 * np.cross(B21, B12), rtol=1e-15)


def test_the_torque_damps_the_angular_velocity():
    wrench = act(angular_velocity=[0.1, 0.2, 0.3])
    np.testing.assert_allclose(wrench["torque"], [-0.025, -0.05, -0.075], rtol=1e-15)


def test_a_target_too_far_pulls_along_the_line_of_sight():
    np.testing.assert_allclose(act(range=25.0, mass=10.0)["force"], [0.05, 0.0, 0.0], rtol=1e-15)


def test_the_force_follows_the_target_s_velocity():
    wrench = act(range=20.0, mass=10.0, relative_velocity=[0.0, 3.0, 0.0])
    np.testing.assert_allclose(wrench["force"], [0.0, 0.75, 0.0], rtol=1e-15)


def test_the_sideways_force_has_the_corrected_sign():
    wrench = act(range=20.0, line_of_sight=B12, target_line_of_sight=B21)
    sideways = 0.05 / 20.0 * (B21 - (B12 @ B21) * B12)
    np.testing.assert_allclose(wrench["force"], sideways, rtol=1e-15)


def test_the_printed_sign_turns_the_sideways_force_around():
    values = {"range": 20.0, "line_of_sight": B12, "target_line_of_sight": B21}
    np.testing.assert_array_equal(act(printed_sign=1.0, **values)["force"], -act(**values)["force"])


def test_law_b_is_law_a_with_the_alignment_gain_divided_by_gamma():
    values = {"line_of_sight": B12, "target_line_of_sight": B21, "relative_velocity": [1, 2, 3]}
    np.testing.assert_equal(act(gamma=0.25, **values), act(alignment_gain=0.2, **values))


@pytest.mark.parametrize(("port", "value", "message"), [
    ("line_of_sight", [1.0, 1.0, 0.0], "line_of_sight must be a unit vector"),
    ("target_line_of_sight", [0.0, 0.0, 0.0], "target_line_of_sight must be a unit vector"),
    ("range", 0.0, "range must be positive"),
    ("range", np.nan, "range must be positive"),
])
def test_an_impossible_measurement_is_refused(port, value, message):
    assert refused(**{port: value}) == [message]
