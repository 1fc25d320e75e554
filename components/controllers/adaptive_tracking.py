"""Errors and regressors of adaptive tracking in six degrees of freedom, and their frames.

e = x - x_d,   s = e' + Λ_T e                                                      before (8)
q̃ = q_d^-1 q,   ω̃ = ω - R(q̃)^T ω_d,   s_R = ω̃ + Λ_R ε̃                            before (15)
ω_r = R(q̃)^T ω_d - Λ_R ε̃

q̃ turns from the body to the desired body frame; of ±q̃ the one with a scalar part that is not
negative is taken, so that the sign of an attitude does not matter and no turn exceeds 180 degrees.
The inertia matrix counts as θ = (H11, H22, H33, H23, H13, H12).

Source: 6-DOF precision formation flying at L2 paper, sections on control law design.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..declarations import Array, Scalar
from ..maths import conjugate, cross, multiply, quaternion_rate, rotate_inverse


class AttitudeError(NamedTuple):
    """q̃, ω̃ and the desired angular velocity in body components."""

    quaternion: Array
    angular_velocity: Array
    desired_in_body: Array

    @property
    def angle(self) -> Scalar:
        """The angle of the turn from the desired attitude, rad."""
        return 2.0 * np.arctan2(np.linalg.norm(self.quaternion[:3]), self.quaternion[3])

    def in_body(self, desired: Array) -> Array:
        """A vector given in the desired body frame, in body components: R(q̃)^T v."""
        return rotate_inverse(self.quaternion, desired)

    @property
    def vector_rate(self) -> Array:
        """Rate of ε̃, the vector part of q̃."""
        return quaternion_rate(self.quaternion, self.angular_velocity)[:3]


def attitude_error(attitude: Array, angular_velocity: Array, desired_attitude: Array,
                   desired_angular_velocity: Array) -> AttitudeError:
    """The attitude's error, the nearer of ±q̃."""
    q = multiply(conjugate(desired_attitude), attitude)
    q = np.where(q[3] < 0.0, -q, q)
    desired = rotate_inverse(q, desired_angular_velocity)
    return AttitudeError(q, angular_velocity - desired, desired)


def inertia_times(theta: Array, w: Array) -> Array:
    """H w = L(w) θ."""
    H11, H22, H33, H23, H13, H12 = (theta[i] for i in range(6))
    return np.stack([
        H11 * w[0] + H12 * w[1] + H13 * w[2],
        H12 * w[0] + H22 * w[1] + H23 * w[2],
        H13 * w[0] + H23 * w[1] + H33 * w[2],
    ])


def inertia_regressor(w: Array, s: Array) -> Array:
    """L(w)^T s."""
    mixed = w[[1, 0, 0]] * s[[2, 2, 1]] + w[[2, 2, 1]] * s[[1, 0, 0]]
    return np.concatenate([w * s, mixed])


def inertia_vector(inertia: Array) -> Array:
    """θ of an inertia matrix."""
    H = inertia
    return np.stack([H[0, 0], H[1, 1], H[2, 2], H[1, 2], H[0, 2], H[0, 1]])


def learning_regressor(attitude: Array, angular_velocity: Array, desired_attitude: Array,
                       desired_angular_velocity: Array, desired_angular_acceleration: Array,
                       error_gain: Scalar) -> Array:
    """Γ_R^T s_R of (17), (18)."""
    ω_r, ω_r_rate = reference_rate(attitude, angular_velocity, desired_attitude,
                                   desired_angular_velocity, desired_angular_acceleration,
                                   error_gain)
    s = angular_velocity - ω_r
    return inertia_regressor(ω_r_rate, s) + inertia_regressor(angular_velocity, cross(s, ω_r))


def reference_rate(attitude: Array, angular_velocity: Array, desired_attitude: Array,
                   desired_angular_velocity: Array, desired_angular_acceleration: Array,
                   error_gain: Scalar) -> tuple[Array, Array]:
    """ω_r and its rate, in body components."""
    error = attitude_error(attitude, angular_velocity, desired_attitude, desired_angular_velocity)
    feedforward = error.in_body(desired_angular_acceleration) \
        - cross(error.angular_velocity, error.desired_in_body)
    return (error.desired_in_body - error_gain * error.quaternion[:3],
            feedforward - error_gain * error.vector_rate)


def to_rotating(vector: Array, angle: Scalar) -> Array:
    """A_ri v: from inertial to axes turned by an angle about z."""
    axis = np.array([0.0, 0.0, 1.0])
    upright = vector * axis
    return upright + np.cos(angle) * (vector - upright) - np.sin(angle) * cross(axis, vector)


def to_inertial(vector: Array, angle: Scalar) -> Array:
    """A_ri^T v."""
    return to_rotating(vector, -angle)
