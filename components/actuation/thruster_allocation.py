"""Thruster allocation by the pseudo-inverse: from a wanted wrench to bidirectional commands."""

import numpy as np

from ..declarations import Output
from .allocator import Allocator, report
from .thruster_geometry import control_sensitivity, layout_requirement, least_squares


class ThrusterAllocation(Allocator):
    """Shares a wanted force and torque among thrusters with the least sum of squares.

    U = [force; torque] = B F                                                           (19)
    F = B^T (B B^T)^-1 U                                                                (20)

    Commands have either sign: the thrusters are taken as bidirectional. Columns of B that belong
    to unhealthy thrusters count as zero; commands beyond the limit are cut to it.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (19), (20).
    """

    command = Output("thrusters", "N", doc="thrust of each thruster")
    residual_force = Output(3, "N", frame="body", doc="wanted minus given force")
    residual_torque = Output(3, "N.m", frame="body", doc="wanted minus given torque")
    saturated = Output("thrusters", "1", type="boolean", doc="thrusters at their limit")
    lost_authority = Output((), "1", doc="part of the wanted wrench that is not given, 0 to 1")

    def outputs(self, force, torque, healthy, positions, directions, center_of_mass, max_thrust):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        limits = max_thrust * healthy
        F = np.clip(least_squares(B * healthy, U), -limits, limits)                    # (20)
        return report(B, U, F, max_thrust)

    def requirements(self, positions, directions, center_of_mass):
        return layout_requirement(positions, directions, center_of_mass)
