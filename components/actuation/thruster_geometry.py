"""Where thrusters sit and push, and the wrench that they make together.

U = [force; torque] = B F,   B = [directions^T; ((positions - center_of_mass) × directions)^T]

``directions`` are those of the force on the spacecraft, opposite to the plumes. The default is a
layout of twelve in pairs. There is none for another number of thrusters: zeros, which the blocks
refuse until positions and directions are given.

Source: 6-DOF precision formation flying at L2 paper, section on actuators, eqs. (19), (20).
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition
from ..maths import UNIT_TOLERANCE, cross

TWELVE_POSITIONS = (
    (-1.0, 0.8, 0.0), (-1.0, -0.8, 0.0), (1.0, 0.8, 0.0), (1.0, -0.8, 0.0),  # +x +x -x -x
    (0.0, -1.0, 0.8), (0.0, -1.0, -0.8), (0.0, 1.0, 0.8), (0.0, 1.0, -0.8),  # +y +y -y -y
    (0.8, 0.0, -1.0), (-0.8, 0.0, -1.0), (0.8, 0.0, 1.0), (-0.8, 0.0, 1.0),  # +z +z -z -z
)  # m
PAIR_DIRECTIONS = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0),
                   (0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
INDEPENDENT = 1e-12  # least determinant of the rows of B, each scaled to length 1


def default_positions(thrusters: int) -> Array:
    """Positions of the twelve-thruster layout; zeros for another number."""
    return np.array(TWELVE_POSITIONS) if thrusters == 12 else np.zeros((thrusters, 3))


def default_directions(thrusters: int) -> Array:
    """Directions of the twelve-thruster layout; zeros for another number."""
    return np.repeat(PAIR_DIRECTIONS, 2, axis=0) if thrusters == 12 else np.zeros((thrusters, 3))


def control_sensitivity(positions: Array, directions: Array, center_of_mass: Array) -> Array:
    """B, shape (6, thrusters): the wrench about the centre of mass of each unit thrust."""
    arms = positions - center_of_mass
    return np.concatenate([directions.T, cross(arms.T, directions.T)])


def has_full_rank(sensitivity: Array) -> Condition:
    """Whether forces and torques about all axes are independent, whatever the units of length."""
    length = np.sqrt(np.sum(sensitivity * sensitivity, axis=1))
    rows = sensitivity.T / np.where(length > 0.0, length, 1.0)
    return np.linalg.det(rows.T @ rows) > INDEPENDENT


def directions_requirement(directions: Array) -> dict[str, Condition]:
    """The requirement that each direction has length 1."""
    length = np.sqrt(np.sum(directions * directions, axis=1))
    return {
        "directions must be unit vectors (for other than 12 thrusters, give positions and "
        "directions)": np.max(np.abs(length - 1.0)) <= UNIT_TOLERANCE,
    }
