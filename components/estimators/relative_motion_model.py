"""Relative position and velocity of a target in the turning body frame of an observer.

Both are differences of inertial vectors, seen in the body frame:  p' = v - Ω × p,  v' = a - Ω × v.
Over one sample at constant Ω and a:  p -> R (p + T v + ½ T² a),  v -> R (v + T a), with R the
turn of the body undone, R = exp(-T S(Ω)).
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Scalar
from ..maths import rotate_inverse, scalar_last


def seen_after(vector: Array, angular_velocity: Array, sample_period: Scalar) -> Array:
    """A vector that stays in inertial space, in the body frame one sample later."""
    angle = np.sqrt(np.sum(angular_velocity * angular_velocity) + 1e-30) * sample_period
    axis = angular_velocity * (0.5 * sample_period * np.sinc(0.5 * angle / np.pi))
    return rotate_inverse(scalar_last(axis, np.cos(0.5 * angle)), vector)


def turn_matrix(angular_velocity: Array, sample_period: Scalar) -> Array:
    """R as a matrix."""
    columns = [seen_after(axis, angular_velocity, sample_period) for axis in np.eye(3)]
    return np.stack(columns).T
