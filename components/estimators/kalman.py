"""Correction of a relative state by a measured position."""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Scalar


def position_covariance(line_of_sight: Array, distance: Scalar, range_deviation: Scalar,
                        angle_deviation: Scalar) -> Array:
    """M = σd² b b^T + d² σb² (I - b b^T) of the position d b."""
    along = np.outer(line_of_sight, line_of_sight)
    across = np.eye(3) - along
    lateral = distance * angle_deviation
    return range_deviation * range_deviation * along + lateral * lateral * across


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
    inverse = np.linalg.inv(covariance[:3, :3] + M)
    gain = covariance[:, :3] @ inverse
    keep = np.eye(6) - np.concatenate([gain, np.zeros((6, 3))], axis=1)
    joseph = keep @ covariance @ keep.T + gain @ M @ gain.T
    first_state = np.concatenate([measured, np.zeros(3)])
    unknown = velocity_deviation * velocity_deviation * np.eye(3)
    first_covariance = np.block([[M, nothing], [nothing, unknown]])
    new, later = valid > 0.5, started > 0.5
    followed = np.logical_and(new, later)
    return (
        np.where(new, np.where(later, predicted + gain @ innovation, first_state), predicted),
        np.where(new, np.where(later, joseph, first_covariance), covariance),
        np.where(followed, innovation, 0.0),
        np.where(followed, innovation @ inverse @ innovation, 0.0),
    )
