"""Gravity of a point mass: at one position, and its difference between two positions.

The difference is formed without cancellation: subtracting two accelerations leaves an error of
1e-16 of their size however near the positions are, this form 1e-16 of the difference itself.

Source: R. H. Battin, An Introduction to the Mathematics and Methods of Astrodynamics, 8.4
(Encke's method).
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Scalar


def gravity(gravitational_parameter: Scalar, position: Array) -> Array:
    """-μ r / |r|³, position from the mass to the craft."""
    return -gravitational_parameter / np.linalg.norm(position) ** 3 * position


def gravity_difference(gravitational_parameter: Scalar, position: Array, offset: Array) -> Array:
    """Gravity at position + offset less that at position.

    -(μ / |r + d|³) (d - f(q) r),   q = d·(2 r + d) / |r|²
    """
    r, d = position, offset
    f = encke(d @ (2.0 * r + d) / (r @ r))
    return -gravitational_parameter / np.linalg.norm(r + d) ** 3 * (d - f * r)


def encke(q: Scalar) -> Scalar:
    """f(q) = (1 + q)^(3/2) - 1 = q (3 + 3 q + q²) / (1 + (1 + q)^(3/2)), exact for small q too."""
    return q * (3.0 + q * (3.0 + q)) / (1.0 + (1.0 + q) ** 1.5)
