"""Thruster allocation: from a wanted wrench to thruster commands."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, Structure
from .thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
    directions_requirement,
    has_full_rank,
)


class ThrusterAllocation(Component):
    """Shares a wanted force and torque among thrusters with the least sum of squares.

    U = [force; torque] = B F                                                           (19)
    F = B^T (B B^T)^-1 U                                                                (20)

    Commands have either sign: the thrusters are taken as bidirectional.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (19), (20).
    """

    thrusters = Structure(12, min=6, doc="number of thrusters")
    force = Input(3, "N", frame="body", doc="wanted force")
    torque = Input(3, "N.m", frame="body", doc="wanted torque about the centre of mass")
    command = Output("thrusters", "N", doc="thrust of each thruster")
    positions = Parameter(("thrusters", 3), "m", default_positions, frame="body",
                          doc="where each thruster pushes")
    directions = Parameter(("thrusters", 3), "1", default_directions, frame="body",
                           doc="direction of the force on the spacecraft, unit vectors")
    center_of_mass = Parameter(3, "m", frame="body", doc="centre of mass")

    def outputs(self, force, torque, positions, directions, center_of_mass):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        return {"command": np.linalg.pinv(B) @ U}                                      # (20)

    def requirements(self, positions, directions, center_of_mass):
        B = control_sensitivity(positions, directions, center_of_mass)
        return {
            **directions_requirement(directions),
            "positions and directions must give force and torque about all axes": has_full_rank(B),
        }
