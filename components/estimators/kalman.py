"""Correction of a relative state by a measured position."""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition, Scalar
from ..factorisation import factorise, solve
from ..maths import product

LEAST_VARIANCE = 1e-300
SYMMETRY = 1e-9  # of the largest element: difference across the diagonal of a covariance


def position_covariance(line_of_sight: Array, distance: Scalar, range_deviation: Scalar,
                        angle_deviation: Scalar) -> Array:
    """M = σd² b b^T + d² σb² (I - b b^T) of the position d b."""
    along = np.outer(line_of_sight, line_of_sight)
    across = np.eye(3) - along
    lateral = distance * angle_deviation
    return range_deviation * range_deviation * along + lateral * lateral * across


def congruent(matrix: Array, covariance: Array) -> Array:
    """A P A^T: the covariance of A x."""
    return product(product(matrix, covariance), matrix.T)


def is_covariance(matrix: Array) -> Condition:
    """Whether a matrix is symmetric and positive definite."""
    asymmetry, size = np.max(np.abs(matrix - matrix.T)), np.max(np.abs(matrix))
    pivots = np.stack(factorise(matrix, LEAST_VARIANCE).inverse)
    return np.logical_and(asymmetry <= SYMMETRY * size, np.min(pivots) > 0.0)


def corrected(line_of_sight: Array, distance: Scalar, valid: Scalar, started: Scalar,
              predicted: Array, covariance: Array, range_deviation: Scalar,
              angle_deviation: Scalar, velocity_deviation: Scalar,
              ) -> tuple[Array, Array, Array, Scalar]:
    """State, covariance, innovation and NIS after a measurement; as predicted without one.

    The first measurement is the start: its position, with velocity 0 ± ``velocity_deviation``.
    """
    M = position_covariance(line_of_sight, distance, range_deviation, angle_deviation)
    measured, nothing = distance * line_of_sight, np.zeros((3, 3))
    innovation = measured - predicted[:3]
    factors = factorise(covariance[:3, :3] + M)
    gain = solve(factors, covariance[:3]).T
    keep = np.eye(6) - np.concatenate([gain, np.zeros((6, 3))], axis=1)
    joseph = congruent(keep, covariance) + congruent(gain, M)
    first_state = np.concatenate([measured, np.zeros(3)])
    unknown = velocity_deviation * velocity_deviation * np.eye(3)
    first_covariance = np.block([[M, nothing], [nothing, unknown]])
    new, later = valid > 0.5, started > 0.5
    followed, state = np.logical_and(new, later), predicted + product(gain, innovation)
    return (
        np.where(new, np.where(later, state, first_state), predicted),
        np.where(new, np.where(later, joseph, first_covariance), covariance),
        np.where(followed, innovation, 0.0),
        np.where(followed, product(innovation, solve(factors, innovation)), 0.0),
    )
