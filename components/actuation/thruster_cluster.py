"""Thruster cluster: from thruster commands to force and torque on the spacecraft."""

from ..component import Component
from ..declarations import Input, Output, Parameter, Structure
from .thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
    directions_requirement,
)


class ThrusterCluster(Component):
    """Force and torque about the centre of mass of thrusters that give what is commanded.

    force = Σ F_k e_k,   torque = Σ F_k (p_k - c) × e_k                                 (19)

    Thrusters are ideal here: bidirectional, without limit or delay.

    Source: 6-DOF precision formation flying at L2 paper, eq. (19).
    """

    thrusters = Structure(12, doc="number of thrusters")
    command = Input("thrusters", "N", doc="thrust of each thruster")
    force = Output(3, "N", frame="body", doc="total force")
    torque = Output(3, "N.m", frame="body", doc="total torque about the centre of mass")
    positions = Parameter(("thrusters", 3), "m", default_positions, frame="body",
                          doc="where each thruster pushes")
    directions = Parameter(("thrusters", 3), "1", default_directions, frame="body",
                           doc="direction of the force on the spacecraft, unit vectors")
    center_of_mass = Parameter(3, "m", frame="body", doc="centre of mass")

    def outputs(self, command, positions, directions, center_of_mass):
        U = control_sensitivity(positions, directions, center_of_mass) @ command       # (19)
        return {"force": U[:3], "torque": U[3:]}

    def requirements(self, directions):
        return directions_requirement(directions)
