"""Error functions of the formation and the bound on γ."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components.controllers.line_of_sight_errors import alignment_error, gamma_bound

INERTIA = np.array([[0.116, -0.032, 0.0010], [-0.032, 0.109, 0.00014], [0.0010, 0.00014, 0.114]])
GAINS = {"alignment_gain": 0.05, "range_gain": 0.001, "desired_range": 20.0}
EXAMPLE = {  # 5.1
    "positions": np.array([[0.0, 0.0, 0.0], [25.0, 0.0, 0.0]]),
    "velocities": np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]]),
    "attitudes": Rotation.from_rotvec([[np.pi, 0, 0], [0, 0.99 * np.pi, 0]]).as_quat(),
    "angular_velocities": np.zeros((2, 3)),
    "inertias": [INERTIA, INERTIA],
}


def test_the_alignment_error_is_one_plus_the_product_of_the_lines_of_sight():
    first, second = Rotation.random(2, rng=np.random.default_rng(4))
    here, there = np.array([1.0, 2.0, 3.0]), np.array([-4.0, 0.0, 9.0])
    line = (there - here) / np.linalg.norm(there - here)
    expected = 1.0 + first.apply(line, inverse=True) @ second.apply(-line, inverse=True)
    computed = alignment_error(here, there, first.as_quat(), second.as_quat())
    assert computed == pytest.approx(expected, rel=1e-14)


def test_the_bound_of_example_5_1():
    assert gamma_bound(**EXAMPLE, **GAINS) == pytest.approx(5.45e-6, abs=0.005e-6)


def test_the_bound_weighs_the_spin_by_the_largest_moment_of_inertia():
    spinning = EXAMPLE | {"velocities": np.zeros((2, 3)),
                          "positions": np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]]),
                          "inertias": [np.diag([1.0, 2.0, 2.5]), INERTIA],
                          "attitudes": Rotation.identity(2).as_quat(),
                          "angular_velocities": np.array([[0.2, 0.0, 0.0], [0.0, 0.0, 0.0]])}
    assert gamma_bound(**spinning, **GAINS) == pytest.approx(2 * 0.05 / (2.5 * 0.04), rel=1e-14)


def test_there_is_no_bound_at_rest_at_the_desired_range():
    resting = EXAMPLE | {"velocities": np.zeros((2, 3)),
                         "positions": np.array([[0.0, 0.0, 0.0], [20.0, 0.0, 0.0]])}
    assert gamma_bound(**resting, **GAINS) == np.inf
