"""Allocation to thrusters with limits and preferences, by a quadratic programme."""

import numpy as np

from ..declarations import Output, Parameter
from .allocator import EXACT, Allocator, least, report
from .thruster_geometry import control_sensitivity, layout_requirement

STEPS = 12


class BoundedThrusterAllocation(Allocator):
    """The wrench exactly wherever it can be reached within the limits, at least weighted squares.

    min ½ Σ w_k F_k² + 100 Σ_i W_i |(S (U - B F))_i|,   0 <= F_k <= F_k,max            (19)

    S makes forces and torques comparable: it divides each row of B by its length. Out of reach, a
    component of large W_i is kept at the expense of the others. Both sets of weights count
    relative to their largest.

    Source: 6-DOF precision formation flying at L2 paper, eq. (19); T. Johansen, T. Fossen, Control
    allocation - a survey, Automatica 49 (2013), on l1 penalties.
    """

    command = Output("thrusters", "N", doc="thrust of each thruster")
    residual_force = Output(3, "N", frame="body", doc="wanted minus given force")
    residual_torque = Output(3, "N.m", frame="body", doc="wanted minus given torque")
    saturated = Output("thrusters", "1", type="boolean", doc="thrusters at their limit")
    lost_authority = Output((), "1", doc="part of the wanted wrench that is not given, 0 to 1")
    thrust_weights = Parameter("thrusters", "1", 1.0, min=1e-3, doc="w, large to spare a thruster")
    force_weights = Parameter(3, "1", 1.0, min=0.05, frame="body", doc="W of the force")
    torque_weights = Parameter(3, "1", 1.0, min=0.05, frame="body", doc="W of the torque")

    def outputs(self, force, torque, healthy, positions, directions, center_of_mass, max_thrust,
                thrust_weights, force_weights, torque_weights, thrusters):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        W = np.concatenate([force_weights, torque_weights])
        F = least(B, U, healthy, max_thrust, cost=np.zeros(thrusters),
                  weight=thrust_weights / np.max(thrust_weights), penalty=EXACT * W / np.max(W),
                  steps=STEPS)
        return report(B, U, F, max_thrust)

    def requirements(self, positions, directions, center_of_mass):
        return layout_requirement(positions, directions, center_of_mass)
