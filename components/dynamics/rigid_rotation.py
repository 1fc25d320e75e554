"""Rotation of a rigid body: Euler's equation, and which inertia matrices there are."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..declarations import Array, Condition
from ..maths import cross, leading_minors


def angular_acceleration(inertia: Array, angular_velocity: Array, torque: Array) -> Array:
    """J^-1 (J Ω × Ω + τ)."""
    moment = cross(inertia @ angular_velocity, angular_velocity) + torque
    acceleration: Any = np.linalg.solve(inertia, moment)
    return acceleration


def inertia_requirements(inertia: Array) -> dict[str, Condition]:
    """The requirements that a matrix is the inertia of some body."""
    J = inertia
    # J_j + J_k >= J_i for the principal moments is: ½ tr(J) I - J positive semidefinite
    margin = (0.5 + 1e-9) * np.trace(J) * np.eye(3) - J
    return {
        "inertia must be symmetric": np.max(np.abs(J - J.T)) <= 1e-9 * np.trace(J),
        "inertia must be positive definite": np.min(np.stack(leading_minors(J))) > 0.0,
        "inertia must satisfy the triangle inequality of its principal moments":
            np.min(np.stack(leading_minors(margin))) > 0.0,
    }
