"""Allocation to thrusters with limits, at the least propellant."""

import numpy as np

from ..declarations import Output, Parameter
from .allocator import EXACT, Allocator, least, report
from .thruster_geometry import control_sensitivity, layout_requirement

STEPS = 12


class LeastPropellantThrusterAllocation(Allocator):
    """The wrench exactly wherever it can be reached within the limits, at the least mass flow.

    min Σ F_k / (g0 Isp_k) + penalty Σ_i |(S (U - B F))_i|,   0 <= F_k <= F_k,max      (19)

    a linear programme. S makes forces and torques comparable: it divides each row of B by its
    length. The penalty is large enough for no residual to pay.

    Source: 6-DOF precision formation flying at L2 paper, eq. (19); T. Johansen, T. Fossen, Control
    allocation - a survey, Automatica 49 (2013), on linear programming.
    """

    command = Output("thrusters", "N", doc="thrust of each thruster")
    residual_force = Output(3, "N", frame="body", doc="wanted minus given force")
    residual_torque = Output(3, "N.m", frame="body", doc="wanted minus given torque")
    saturated = Output("thrusters", "1", type="boolean", doc="thrusters at their limit")
    lost_authority = Output((), "1", doc="part of the wanted wrench that is not given, 0 to 1")
    specific_impulse = Parameter("thrusters", "s", 220.0, min=1.0, doc="Isp")

    def outputs(self, force, torque, healthy, positions, directions, center_of_mass, max_thrust,
                specific_impulse, thrusters):
        B = control_sensitivity(positions, directions, center_of_mass)
        U = np.concatenate([force, torque])                                            # (19)
        F = least(B, U, healthy, max_thrust, cost=np.min(specific_impulse) / specific_impulse,
                  weight=np.zeros(thrusters), penalty=np.full(6, EXACT), steps=STEPS)
        return report(B, U, F, max_thrust)

    def requirements(self, positions, directions, center_of_mass):
        return layout_requirement(positions, directions, center_of_mass)
