"""Allocation to thrusters that only push, by shifts along the null space."""

import numpy as np

from ..declarations import Output, Parameter, Structure
from .allocator import Allocator, report
from .thruster_geometry import (
    control_sensitivity,
    default_groups,
    layout_requirement,
    least_squares,
)


class ShiftedThrusterAllocation(Allocator):
    """Pseudo-inverse, then in each axis group the smallest shift that leaves no thrust negative.

    F = B^T (B B^T)^-1 U + Σ_g a_g n_g,   B n_g = 0,   n_g >= 0                         (20)
    a_g = max(0, max_k -F_k / n_gk)       over the thrusters k of group g

    A shift changes thrusts but not the wrench. A group that has lost a thruster cannot be shifted;
    what is negative there is cut, and the residual says so.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (19), (20); thrusters only push.
    """

    groups = Structure(3, doc="number of axis groups")
    command = Output("thrusters", "N", doc="thrust of each thruster")
    residual_force = Output(3, "N", frame="body", doc="wanted minus given force")
    residual_torque = Output(3, "N.m", frame="body", doc="wanted minus given torque")
    saturated = Output("thrusters", "1", type="boolean", doc="thrusters at their limit")
    lost_authority = Output((), "1", doc="part of the wanted wrench that is not given, 0 to 1")
    shifts = Parameter(("groups", "thrusters"), "1", default_groups, min=0.0,
                       doc="n_g in each row: thrusts that together give no wrench")

    def outputs(self, force, torque, healthy, positions, directions, center_of_mass, max_thrust,
                shifts, groups):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        F = least_squares(B * healthy, U)                                              # (20)
        for n in [shifts[g] for g in range(groups)]:
            member = n > 0.0
            need = np.max(np.where(member, -F / np.where(member, n, 1.0), 0.0))
            whole = np.min(np.where(member, healthy, 1.0)) > 0.5
            F = F + np.where(whole, np.maximum(need, 0.0), 0.0) * n
        return report(B, U, np.clip(F, 0.0, max_thrust * healthy), max_thrust)

    def requirements(self, positions, directions, center_of_mass, shifts):
        B = control_sensitivity(positions, directions, center_of_mass)
        return {
            **layout_requirement(positions, directions, center_of_mass),
            "each row of shifts must give no wrench":
                np.max(np.abs(shifts @ B.T)) <= 1e-9 * np.max(np.abs(B)),
        }
