"""Allocation to thrusters that only push, by non-negative least squares."""

import numpy as np

from ..declarations import Output
from .allocator import Allocator, least, report
from .thruster_geometry import control_sensitivity, layout_requirement

NORM_WEIGHT = 1e-11  # of |F|² against the residual's: picks the smallest of equally good commands
CONVERGED = 1e-25  # products are small where the residual is
STEPS = 24


class NonNegativeThrusterAllocation(Allocator):
    """The commands that come nearest to the wrench, and of these the smallest.

    min |S (B F - U)|²,   F >= 0;   of all solutions that of least |F|²                 (19)

    S makes forces and torques comparable: it divides each row of B by its length. Commands beyond
    a limit are cut to it afterwards.

    Source: 6-DOF precision formation flying at L2 paper, eq. (19); thrusters only push.
    """

    command = Output("thrusters", "N", doc="thrust of each thruster")
    residual_force = Output(3, "N", frame="body", doc="wanted minus given force")
    residual_torque = Output(3, "N.m", frame="body", doc="wanted minus given torque")
    saturated = Output("thrusters", "1", type="boolean", doc="thrusters at their limit")
    lost_authority = Output((), "1", doc="part of the wanted wrench that is not given, 0 to 1")

    def outputs(self, force, torque, healthy, positions, directions, center_of_mass, max_thrust,
                thrusters):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        F = least(B, U, healthy, None, cost=np.zeros(thrusters), penalty=None,
                  weight=np.full(thrusters, NORM_WEIGHT), tolerance=CONVERGED, steps=STEPS)
        return report(B, U, np.minimum(F, max_thrust), max_thrust)

    def requirements(self, positions, directions, center_of_mass):
        return layout_requirement(positions, directions, center_of_mass)
