"""The local-vertical, local-horizontal frame of a spacecraft in orbit.

+z points to the planet's centre, +y along the negative orbit normal, +x = y × z: along the motion
in a circular orbit. The frame turns at Ω = (0, -ω, 0) in its own axes.

Source: relative motion in the LVLH frame paper, section II.
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition, Scalar
from ..maths import cross, unit


def lvlh_axes(position: Array, velocity: Array) -> Array:
    """Rows x, y, z: the matrix from inertial to LVLH components."""
    z = -unit(position)
    y = -unit(cross(position, velocity))
    return np.stack([cross(y, z), y, z])


def orbit_rate(position: Array, velocity: Array) -> Scalar:
    """ω, the rate at which the frame turns, positive along the motion."""
    return np.linalg.norm(cross(position, velocity)) / (position @ position)


def orbit_requirement(position: Array, velocity: Array) -> dict[str, Condition]:
    """The requirement that position and velocity of the chief span a plane."""
    normal = cross(position, velocity)
    return {"chief_velocity must not be parallel to chief_position": normal @ normal > 0.0}
