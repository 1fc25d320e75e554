"""Error functions of the two-spacecraft formation, and the bound on the gain γ of Law B.

Ψ1 = ½ |b12 + b21|² = 1 + b12·b21     alignment, 0 to 2                                 (18)
Ψ2 = (d - d0)²                        range, m2                                         (19)
Ψ3 = ½ |v2 - v1|²                     velocity, m2/s2                                   (20)

Source: coupled LOS attitude and position control paper, eqs. (18)-(20), (46).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..declarations import Array, Scalar
from ..maths import rotate_inverse, unit


def alignment_error(position: Array, target_position: Array, attitude: Array,
                    target_attitude: Array) -> Scalar:
    """Ψ1 (18), in the form that keeps its digits near 0."""
    s12 = unit(target_position - position)
    mismatch = rotate_inverse(attitude, s12) - rotate_inverse(target_attitude, s12)
    return half_square(mismatch)


def range_error_squared(position: Array, target_position: Array, desired_range: Scalar) -> Scalar:
    """Ψ2 (19)."""
    error = np.linalg.norm(target_position - position) - desired_range
    return error * error


def half_square(vector: Array) -> Scalar:
    """½ |vector|²: of the relative velocity it is Ψ3 (20)."""
    return 0.5 * np.sum(vector * vector)


def gamma_bound(
    *,
    positions: Sequence[Array],
    velocities: Sequence[Array],
    attitudes: Sequence[Array],
    angular_velocities: Sequence[Array],
    inertias: Sequence[Array],
    alignment_gain: float,
    range_gain: float,
    desired_range: float,
) -> float:
    """The γ below which Law B converges from this start of the two spacecraft (46).

    γ < k1 (2 - Ψ1) / (Σ λmax(J_i) |Ω_i|² + k2 Ψ2 + Ψ3); infinite at rest at the desired range.
    The torque grows as k1/γ: a start near the undesired equilibrium Ψ1 = 2 asks for a lot.
    """
    spin = sum(
        np.linalg.eigvalsh(J)[-1] * (Ω @ Ω)
        for J, Ω in zip(inertias, angular_velocities, strict=True)
    )
    motion = half_square(velocities[1] - velocities[0])
    stretch = range_error_squared(positions[0], positions[1], np.asarray(desired_range))
    energy = float(spin + range_gain * stretch + motion)
    margin = alignment_gain * (2.0 - float(alignment_error(*positions, *attitudes)))
    return margin / energy if energy > 0.0 else np.inf
