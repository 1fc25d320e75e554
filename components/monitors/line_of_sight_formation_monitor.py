"""Errors and Lyapunov function of a formation of two spacecraft, from their true states."""

import numpy as np

from ..component import Component
from ..controllers.line_of_sight_errors import alignment_error, half_square, range_error_squared
from ..declarations import Input, Output, Parameter
from ..maths import IDENTITY, is_unit


class LineOfSightFormationMonitor(Component):
    """Alignment, range and velocity errors and the Lyapunov function of Laws A and B.

    Ψ1 = 1 + b12·b21,   Ψ2 = (d - d0)²,   Ψ3 = ½ |v2 - v1|²                      (18)-(20)
    V  = k1 Ψ1 + γ (k2 Ψ2 + Ψ3 + ½ Ω1·J1Ω1 + ½ Ω2·J2Ω2)                               (22)
    V' = -γ (kΩ1 |Ω1|² + kΩ2 |Ω2|² + (kv1 + kv2) |v2 - v1|²)                          (48)

    (48) is what V' becomes under the corrected law; compare it with the slope of V.

    Source: coupled LOS attitude and position control paper, eqs. (18)-(22), (48).
    """

    position = Input(3, "m", frame="inertial", doc="first craft's centre of mass")
    velocity = Input(3, "m/s", frame="inertial", doc="first craft's velocity")
    attitude = Input(4, "1", IDENTITY, frame="body", doc="first craft's attitude, body to inertial")
    angular_velocity = Input(3, "rad/s", frame="body", doc="first craft's angular velocity")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="second craft's centre of mass")
    target_velocity = Input(3, "m/s", frame="inertial", doc="second craft's velocity")
    target_attitude = Input(4, "1", IDENTITY, frame="target_body",
                            doc="second craft's attitude, body to inertial")
    target_angular_velocity = Input(3, "rad/s", frame="target_body",
                                    doc="second craft's angular velocity")
    alignment_error = Output((), "1", doc="Ψ1, from 0 (facing each other) to 2")
    range_error_squared = Output((), "m2", doc="Ψ2")
    velocity_error = Output((), "m2/s2", doc="Ψ3")
    lyapunov = Output((), "J", doc="V, masses normalised to 1 kg")
    lyapunov_rate = Output((), "W", doc="V' by its formula")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="first craft's inertia")
    target_inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="target_body",
                               doc="second craft's inertia")
    rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ1")
    target_rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ2")
    velocity_gain = Parameter((), "1/s", 0.025, min=0.0, doc="kv1")
    target_velocity_gain = Parameter((), "1/s", 0.025, min=0.0, doc="kv2")
    alignment_gain = Parameter((), "N.m", 0.05, min=0.0, doc="k1")
    range_gain = Parameter((), "1/s2", 0.001, min=0.0, doc="k2")
    desired_range = Parameter((), "m", 20.0, min=0.0, doc="d0, wanted distance")
    gamma = Parameter((), "1", 1.0, min=1e-12, doc="γ of Law B; 1 is Law A")

    def outputs(self, position, velocity, attitude, angular_velocity, target_position,
                target_velocity, target_attitude, target_angular_velocity, inertia,
                target_inertia, rate_gain, target_rate_gain, velocity_gain,
                target_velocity_gain, alignment_gain, range_gain, desired_range, gamma):
        Ω1, Ω2 = angular_velocity, target_angular_velocity
        Ψ1 = alignment_error(position, target_position, attitude, target_attitude)      # (18)
        Ψ2 = range_error_squared(position, target_position, desired_range)              # (19)
        Ψ3 = half_square(target_velocity - velocity)                                    # (20)
        spin = 0.5 * (Ω1 @ (inertia @ Ω1) + Ω2 @ (target_inertia @ Ω2))
        damping = rate_gain * (Ω1 @ Ω1) + target_rate_gain * (Ω2 @ Ω2)
        drag = (velocity_gain + target_velocity_gain) * 2.0 * Ψ3
        return {
            "alignment_error": Ψ1,
            "range_error_squared": Ψ2,
            "velocity_error": Ψ3,
            "lyapunov": alignment_gain * Ψ1 + gamma * (range_gain * Ψ2 + Ψ3 + spin),    # (22)
            "lyapunov_rate": -gamma * (damping + drag),                                 # (48)
        }

    def requirements(self, position, target_position, attitude, target_attitude):
        return {
            "target_position must differ from position":
                np.linalg.norm(target_position - position) > 0.0,
            "attitude must be a unit quaternion": is_unit(attitude),
            "target_attitude must be a unit quaternion": is_unit(target_attitude),
        }
