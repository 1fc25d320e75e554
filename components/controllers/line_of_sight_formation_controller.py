"""Coupled attitude and position control of two spacecraft from lines of sight: Laws A and B."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import cross, is_unit


class LineOfSightFormationController(Component):
    """Points two spacecraft at each other and brings them to a wanted distance, one per craft.

    τ1      = -kΩ Ω1 - (k1/γ) b21 × b12                                          (23), (42)
    R1^T u1 = kv v12 - k2 (d0 - d) b12 + (k1/(γ d)) (b21 - (b12·b21) b12)        (25), (44)
    f1      = m u1, in the body frame

    The second spacecraft uses the same with 1 and 2 exchanged: (24), (26), (43), (45).
    γ = 1 is Law A; a smaller γ, below `gamma_bound` (46), is Law B. The paper prints a minus
    before (k1/(γ d)); with it its Lyapunov function need not decrease and at a small d0 the
    formation does not converge. `printed_sign` restores it to reproduce the paper's figures.
    The paper normalises masses: k1 counts in N m in the torque and in m2/s2 in u.

    Source: coupled LOS attitude and position control paper, eqs. (23)-(26), (42)-(45).
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="own unit vector to target")
    target_line_of_sight = Input(3, "1", (-1.0, 0.0, 0.0), frame="target_body",
                                 doc="target's unit vector to own craft, received from it")
    range = Input((), "m", 1.0, doc="distance to the target")
    relative_velocity = Input(3, "m/s", frame="body", doc="target's velocity minus own")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    force = Output(3, "N", frame="body", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="own mass")
    rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ, damps the angular velocity")
    velocity_gain = Parameter((), "1/s", 0.025, min=0.0, doc="kv, damps the relative velocity")
    alignment_gain = Parameter((), "N.m", 0.05, min=0.0, doc="k1, turns towards the target")
    range_gain = Parameter((), "1/s2", 0.001, min=0.0, doc="k2, pulls to the desired range")
    desired_range = Parameter((), "m", 20.0, min=0.0, doc="d0, wanted distance")
    gamma = Parameter((), "1", 1.0, min=1e-12, doc="γ of Law B; 1 is Law A")
    printed_sign = Parameter((), "1", 0.0, type="boolean",
                             doc="use the sign printed in (25), (26), (44), (45)")
    sample_period = SamplePeriod()

    def outputs(self, line_of_sight, target_line_of_sight, range, relative_velocity,
                angular_velocity, mass, rate_gain, velocity_gain, alignment_gain, range_gain,
                desired_range, gamma, printed_sign):
        b12, b21, d = line_of_sight, target_line_of_sight, range
        k1 = alignment_gain / gamma
        sign = np.where(printed_sign > 0.5, -1.0, 1.0)
        damping = velocity_gain * relative_velocity
        spring = range_gain * (desired_range - d) * b12
        turning = k1 / d * (b21 - (b12 @ b21) * b12)
        return {
            "torque": -rate_gain * angular_velocity - k1 * cross(b21, b12),       # (23), (42)
            "force": mass * (damping - spring + sign * turning),                  # (25), (44)
        }

    def requirements(self, line_of_sight, target_line_of_sight, range):
        return {
            "line_of_sight must be a unit vector": is_unit(line_of_sight),
            "target_line_of_sight must be a unit vector": is_unit(target_line_of_sight),
            "range must be positive": range > 0.0,
        }
