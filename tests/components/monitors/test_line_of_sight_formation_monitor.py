"""Errors and Lyapunov function in closed form."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components.monitors.line_of_sight_formation_monitor import (
    LineOfSightFormationMonitor,
)

MONITOR = LineOfSightFormationMonitor()


def watch(**values):
    return MONITOR.evaluate("outputs", MONITOR.start_values() | {
        name: np.asarray(value, float) for name, value in values.items()
    })


def test_craft_that_face_each_other_have_no_alignment_error():
    assert watch()["alignment_error"] == 0.0


def test_a_turn_of_one_craft_by_an_angle_gives_one_minus_its_cosine():
    turned = Rotation.from_rotvec([0.0, 0.0, 1e-4]).as_quat()
    error = watch(target_attitude=turned)["alignment_error"]
    assert error == pytest.approx(2.0 * np.sin(0.5e-4) ** 2, rel=1e-10)


def test_the_range_error_is_squared():
    assert watch(target_position=[23.0, 0.0, 0.0])["range_error_squared"] == 9.0


def test_the_velocity_error_is_half_the_square_of_the_relative_velocity():
    assert watch(velocity=[1.0, 0.0, 0.0], target_velocity=[0.0, 3.0, 0.0])["velocity_error"] == 5.0


def test_the_lyapunov_function_adds_errors_and_spin():
    flipped = Rotation.from_rotvec([0.0, 0.0, np.pi]).as_quat()
    watched = watch(target_attitude=flipped, target_position=[23.0, 0.0, 0.0], gamma=0.5,
                    velocity=[2.0, 0.0, 0.0], inertia=2.0 * np.eye(3),
                    angular_velocity=[0.0, 0.1, 0.0], target_angular_velocity=[0.3, 0.0, 0.0])
    expected = 0.05 * 2.0 + 0.5 * (0.001 * 9.0 + 2.0 + 0.5 * 2.0 * 0.01 + 0.5 * 0.09)
    assert watched["lyapunov"] == pytest.approx(expected, rel=1e-14)


def test_the_lyapunov_rate_adds_the_damping_of_both_craft():
    watched = watch(gamma=0.5, rate_gain=0.1, target_rate_gain=0.2, velocity_gain=0.3,
                    target_velocity_gain=0.4, velocity=[2.0, 0.0, 0.0],
                    angular_velocity=[0.0, 1.0, 0.0], target_angular_velocity=[3.0, 0.0, 0.0])
    assert watched["lyapunov_rate"] == pytest.approx(-0.5 * (0.1 + 0.2 * 9.0 + 0.7 * 4.0))
