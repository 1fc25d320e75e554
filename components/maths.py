"""Rotations and vectors shared by all blocks.

Attitude is a unit quaternion q = [x, y, z, w], scalar last, body to inertial: R(q) v_body is
v_inertial. R(q) does not depend on the sign of q. All functions accept numpy arrays and, for
code generation, symbols of the same shape.
"""

from __future__ import annotations

import numpy as np

from .declarations import Array, Condition, Scalar

IDENTITY: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)
UNIT_TOLERANCE = 1e-6  # allowed | |q| - 1 | of an attitude that a block receives
NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])  # cyclic successors of the axes x, y, z


def cross(a: Array, b: Array) -> Array:
    """a × b for 3-vectors, or for the columns of two matrices with three rows.

    `np.cross` does the same, several times slower on single vectors.
    """
    return a[NEXT] * b[LAST] - a[LAST] * b[NEXT]


def product(a: Array, b: Array) -> Array:
    """a @ b of vectors and matrices, summed in order of the index on every machine.

    numpy's ``@`` sums in an order, and with fused operations, of its library's choice; generated
    code sums in order. Where an algorithm amplifies rounding, only the same order gives the same
    numbers.
    """
    shape = (*a.shape[:-1], *b.shape[1:])
    rows, columns = np.reshape(a, (-1, b.shape[0])), np.reshape(b, (b.shape[0], -1))
    result = np.outer(rows[:, 0], columns[0])
    for k in range(1, b.shape[0]):
        result = result + np.outer(rows[:, k], columns[k])
    return np.reshape(result, shape)


def reciprocal(x: Array | Scalar) -> Array:
    """1/x of positive numbers, divided once however often it is used.

    Code generation turns a factor 1/x back into a division, slower and rounded otherwise; not so
    the larger of 1/x and 0.
    """
    return np.maximum(1.0 / x, 0.0)


def unit(vector: Array) -> Array:
    """The vector divided by its norm; the norm must not be zero."""
    return vector / np.linalg.norm(vector)


def scalar_last(vector: Array, scalar: Scalar) -> Array:
    """The four numbers [vector, scalar]."""
    return np.concatenate([vector, np.reshape(scalar, (1,))])


def rotate(q: Array, v: Array) -> Array:
    """R(q) v: from the body frame to the inertial frame."""
    t = 2.0 * cross(q[:3], v)
    return v + q[3] * t + cross(q[:3], t)


def rotate_inverse(q: Array, v: Array) -> Array:
    """R(q)^T v: from the inertial frame to the body frame."""
    t = 2.0 * cross(q[:3], v)
    return v - q[3] * t + cross(q[:3], t)


def multiply(p: Array, q: Array) -> Array:
    """Hamilton's product p q, so that R(p q) = R(p) R(q)."""
    vector = p[3] * q[:3] + q[3] * p[:3] + cross(p[:3], q[:3])
    return scalar_last(vector, p[3] * q[3] - p[:3] @ q[:3])


def conjugate(q: Array) -> Array:
    """The inverse rotation of a unit quaternion."""
    return scalar_last(-q[:3], q[3])


def quaternion_rate(q: Array, body_rate: Array) -> Array:
    """dq/dt = ½ q [Ω, 0] for the angular velocity Ω in the body frame (R' = R S(Ω))."""
    return 0.5 * multiply(q, scalar_last(body_rate, np.zeros(())))


def small_rotation(angles: Array, v: Array) -> Array:
    """The vector turned by a rotation vector (rad), exact to second order, norm kept."""
    return rotate(unit(scalar_last(0.5 * angles, np.ones(()))), v)


def from_matrix(matrix: Array) -> Array:
    """The quaternion of a rotation matrix; exact at any angle, of either sign."""
    m, trace = matrix, np.trace(matrix)
    diagonal = np.concatenate([np.diag(m), np.reshape(trace, (1,))])
    square = 1.0 + 2.0 * diagonal - trace  # 4 x², 4 y², 4 z², 4 w²
    xy, yz, zx = m[0, 1] + m[1, 0], m[1, 2] + m[2, 1], m[2, 0] + m[0, 2]
    wx, wy, wz = m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]
    rows = (np.stack([square[0], xy, zx, wx]), np.stack([xy, square[1], yz, wy]),
            np.stack([zx, yz, square[2], wz]), np.stack([wx, wy, wz, square[3]]))  # 4 q_i q
    best, largest = rows[0], square[0]
    for row, size in zip(rows[1:], (square[1], square[2], square[3]), strict=True):
        best, largest = np.where(size > largest, row, best), np.maximum(size, largest)
    return unit(best)


def is_unit(vector: Array) -> Condition:
    """Whether a vector or quaternion has norm 1 within UNIT_TOLERANCE."""
    return np.abs(np.linalg.norm(vector) - 1.0) <= UNIT_TOLERANCE


def leading_minors(matrix: Array) -> tuple[Scalar, Scalar, Scalar]:
    """The three leading principal minors of a 3x3 matrix: all positive if positive definite."""
    first = matrix[0, 0]
    second = matrix[0, 0] * matrix[1, 1] - matrix[0, 1] * matrix[1, 0]
    third = matrix[0] @ cross(matrix[1], matrix[2])
    return first, second, third
