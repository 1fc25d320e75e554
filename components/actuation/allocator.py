"""What all allocators share: ports, geometry, and the report on what was allocated."""

from __future__ import annotations

import numpy as np

from ..component import Component
from ..declarations import Array, Input, Parameter, Scalar, Structure
from ..maths import product
from .interior_point import Programme, minimise
from .thruster_geometry import (
    default_directions,
    default_positions,
    row_lengths,
)

EXACT = 100.0  # penalty of a residual against the cost of thrust, both of order 1
REACHED = 1e-9  # of the wrench: a residual that is none
OFF = 1e-11  # of the wrench: a smaller thrust is none
CONVERGED = 1e-12
AT_LIMIT = 1.0 - 1e-6  # of the limit: a thruster that gives as much is saturated
SMOOTH = 1e-200
SMALLEST = 1e-12  # N, scale of an allocation that asks for nothing


class Allocator(Component):
    """Base of the allocators: a wanted wrench and a geometry in, with the thrusters' health."""

    thrusters = Structure(12, min=6, doc="number of thrusters")
    force = Input(3, "N", frame="body", doc="wanted force")
    torque = Input(3, "N.m", frame="body", doc="wanted torque about the centre of mass")
    healthy = Input("thrusters", "1", 1.0, type="boolean", optional=True,
                    doc="thrusters that may be used")
    positions = Parameter(("thrusters", 3), "m", default_positions, frame="body",
                          doc="where each thruster pushes")
    directions = Parameter(("thrusters", 3), "1", default_directions, frame="body",
                           doc="direction of the force on the spacecraft, unit vectors")
    center_of_mass = Parameter(3, "m", frame="body", doc="centre of mass")
    max_thrust = Parameter("thrusters", "N", 1e6, min=1e-9, doc="largest thrust of each thruster")


def report(sensitivity: Array, wrench: Array, command: Array,
           limits: Array) -> dict[str, Array | Scalar]:
    """The outputs of every allocator: command, what is missing, and why."""
    lengths = row_lengths(sensitivity)
    wanted = _size(wrench / lengths)
    difference = wrench - product(sensitivity, command)
    missing = np.where(np.abs(difference) > REACHED * wanted * lengths, difference, 0.0)
    return {
        "command": command,
        "residual_force": missing[:3],
        "residual_torque": missing[3:],
        "saturated": np.where(np.abs(command) >= AT_LIMIT * limits, 1.0, 0.0),
        "lost_authority": _size(missing / lengths) / np.maximum(wanted, SMALLEST),
    }


def least(sensitivity: Array, wrench: Array, healthy: Array, limits: Array | None, *,
          cost: Array, weight: Array, penalty: Array | None, steps: int,
          tolerance: float = CONVERGED) -> Array:
    """The solution of the programme for the healthy thrusters, in newtons."""
    lengths = row_lengths(sensitivity)
    scaled = wrench / lengths
    scale = np.maximum(np.sqrt(product(scaled, scaled)), SMALLEST)
    bounds = None if limits is None else limits / scale
    B = sensitivity * healthy / np.reshape(lengths, (6, 1))
    programme = Programme(B, scaled / scale, cost, weight, bounds, penalty, tolerance)
    F = minimise(programme, steps)
    return np.where(np.logical_and(F > OFF, healthy > 0.5), scale * F, 0.0)


def _size(vector: Array) -> Scalar:
    """The norm, with a derivative of 0 at 0."""
    size: Scalar = np.sqrt(product(vector, vector) + SMOOTH)
    return size
