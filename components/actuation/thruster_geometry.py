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
from ..factorisation import factorise, solve
from ..maths import UNIT_TOLERANCE, cross, product

TWELVE_POSITIONS = (
    (-1.0, 0.8, 0.0), (-1.0, -0.8, 0.0), (1.0, 0.8, 0.0), (1.0, -0.8, 0.0),  # +x +x -x -x
    (0.0, -1.0, 0.8), (0.0, -1.0, -0.8), (0.0, 1.0, 0.8), (0.0, 1.0, -0.8),  # +y +y -y -y
    (0.8, 0.0, -1.0), (-0.8, 0.0, -1.0), (0.8, 0.0, 1.0), (-0.8, 0.0, 1.0),  # +z +z -z -z
)  # m
PAIR_DIRECTIONS = ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, -1.0, 0.0),
                   (0.0, 0.0, 1.0), (0.0, 0.0, -1.0))
DEPENDENT = 1e-12  # square of the part of a row of B, of length 1, that others do not have
INDEPENDENT = 1e-12  # least determinant of the rows of B, each scaled to length 1


def default_positions(thrusters: int) -> Array:
    """Positions of the twelve-thruster layout; zeros for another number."""
    return np.array(TWELVE_POSITIONS) if thrusters == 12 else np.zeros((thrusters, 3))


def default_directions(thrusters: int) -> Array:
    """Directions of the twelve-thruster layout; zeros for another number."""
    return np.repeat(PAIR_DIRECTIONS, 2, axis=0) if thrusters == 12 else np.zeros((thrusters, 3))


def default_groups(groups: int, thrusters: int) -> Array:
    """One row per axis of the twelve-thruster layout: its four thrusters together give no wrench.

    Zeros for another layout: no shifts.
    """
    if (groups, thrusters) != (3, 12):
        return np.zeros((groups, thrusters))
    return np.repeat(np.eye(3), 4, axis=1)


def control_sensitivity(positions: Array, directions: Array, center_of_mass: Array) -> Array:
    """B, shape (6, thrusters): the wrench about the centre of mass of each unit thrust."""
    arms = positions - center_of_mass
    return np.concatenate([directions.T, cross(arms.T, directions.T)])


def row_lengths(sensitivity: Array) -> Array:
    """Length of each row of B, to make forces and torques comparable; 1 for a row of zeros."""
    length = np.sqrt(product(sensitivity * sensitivity, np.ones(sensitivity.shape[1])))
    return np.where(length > 0.0, length, 1.0)


def has_full_rank(sensitivity: Array) -> Condition:
    """Whether forces and torques about all axes are independent, whatever the units of length."""
    rows = sensitivity.T / row_lengths(sensitivity)
    return np.linalg.det(rows.T @ rows) > INDEPENDENT


def least_squares(sensitivity: Array, wrench: Array) -> Array:
    """B^T (B B^T)^-1 U (20), refined once.

    A component of the wrench that cannot be given independently of those before it, because
    thrusters are lost, is left out.
    """
    lengths = row_lengths(sensitivity)
    B, U = sensitivity / np.reshape(lengths, (6, 1)), wrench / lengths
    factors = factorise(product(B, B.T), DEPENDENT)
    multiplier = solve(factors, U)
    multiplier = multiplier + solve(factors, U - product(B, product(B.T, multiplier)))
    return product(B.T, multiplier)


def directions_requirement(directions: Array) -> dict[str, Condition]:
    """The requirement that each direction has length 1."""
    length = np.sqrt(np.sum(directions * directions, axis=1))
    return {
        "directions must be unit vectors (for other than 12 thrusters, give positions and "
        "directions)": np.max(np.abs(length - 1.0)) <= UNIT_TOLERANCE,
    }


def layout_requirement(positions: Array, directions: Array,
                       center_of_mass: Array) -> dict[str, Condition]:
    """The requirement that a layout can be allocated to."""
    B = control_sensitivity(positions, directions, center_of_mass)
    return {
        **directions_requirement(directions),
        "positions and directions must give force and torque about all axes": has_full_rank(B),
    }
