"""Errors and Lyapunov function of the relative attitude of two spacecraft, from true states."""

import numpy as np

from ..component import Component
from ..controllers.line_of_sight_errors import half_square
from ..controllers.lines_of_sight import plane_normal
from ..declarations import Input, Output, Parameter
from ..maths import IDENTITY, conjugate, cross, is_unit, multiply, rotate, rotate_inverse, unit


class RelativeAttitudeMonitor(Component):
    """Error functions and Lyapunov function of the relative attitude control on SO(3).

    Ψα = 1 + b21·Qd b12                                                                 (11)
    Ψβ = 1 + (1/c) Qd (b12 × b13)·(b21 × b23)                                           (14)
    eQ = ½ (Qd^T Q - Q^T Qd)^v,   Q = R2^T R1
    V  = ½ Ω1·J1Ω1 + ½ Ω2·J2Ω2 + kα Ψα + kβ Ψβ
    V' = -kΩ1 |Ω1|² - kΩ2 |Ω2|²                                                         (24)

    Source: relative attitude control on SO(3) paper, eqs. (11), (14), (24), section V.
    """

    position = Input(3, "m", frame="inertial", doc="first craft's centre of mass")
    attitude = Input(4, "1", IDENTITY, frame="body", doc="first craft's attitude, body to inertial")
    angular_velocity = Input(3, "rad/s", frame="body", doc="first craft's angular velocity")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="second craft's centre of mass")
    target_attitude = Input(4, "1", IDENTITY, frame="target_body",
                            doc="second craft's attitude, body to inertial")
    target_angular_velocity = Input(3, "rad/s", frame="target_body",
                                    doc="second craft's angular velocity")
    object_position = Input(3, "m", (0.0, 1.0, 0.0), frame="inertial",
                            doc="common object, off the line through the craft")
    alignment_error = Output((), "1", doc="Ψα, 0 to 2")
    normal_error = Output((), "1", doc="Ψβ, 0 to 2")
    attitude_error = Output(3, "1", frame="body", doc="eQ, sine of the angle along the axis")
    lyapunov = Output((), "J", doc="V")
    lyapunov_rate = Output((), "W", doc="V' by its formula")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="first craft's inertia")
    target_inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="target_body",
                               doc="second craft's inertia")
    desired_relative_attitude = Parameter(4, "1", IDENTITY,
                                          doc="Qd, from first body frame to the second")
    rate_gain = Parameter((), "N.m.s/rad", 0.84, min=0.0, doc="kΩ1")
    target_rate_gain = Parameter((), "N.m.s/rad", 0.84, min=0.0, doc="kΩ2")
    alignment_gain = Parameter((), "N.m", 0.525, min=0.0, doc="kα")
    normal_gain = Parameter((), "N.m", 0.5775, min=0.0, doc="kβ")

    def outputs(self, position, attitude, angular_velocity, target_position, target_attitude,
                target_angular_velocity, object_position, inertia, target_inertia,
                desired_relative_attitude, rate_gain, target_rate_gain, alignment_gain,
                normal_gain):
        R1, R2, Qd = attitude, target_attitude, desired_relative_attitude
        Ω1, Ω2 = angular_velocity, target_angular_velocity
        s12 = unit(target_position - position)
        n = plane_normal(s12, object_position - position)  # -n seen from the second craft
        Ψα = half_square(rotate(Qd, rotate_inverse(R1, s12)) - rotate_inverse(R2, s12))  # (11)
        Ψβ = half_square(rotate(Qd, rotate_inverse(R1, n)) - rotate_inverse(R2, n))      # (14)
        error = multiply(conjugate(Qd), multiply(conjugate(R2), R1))
        spin = 0.5 * (Ω1 @ (inertia @ Ω1) + Ω2 @ (target_inertia @ Ω2))
        return {
            "alignment_error": Ψα,
            "normal_error": Ψβ,
            "attitude_error": 2.0 * error[3] * error[:3],
            "lyapunov": spin + alignment_gain * Ψα + normal_gain * Ψβ,
            "lyapunov_rate": -rate_gain * (Ω1 @ Ω1) - target_rate_gain * (Ω2 @ Ω2),      # (24)
        }

    def requirements(self, position, target_position, object_position, attitude,
                     target_attitude):
        normal = cross(target_position - position, object_position - position)
        return {
            "the craft and object_position must not be on one line": np.linalg.norm(normal) > 0.0,
            "attitude must be a unit quaternion": is_unit(attitude),
            "target_attitude must be a unit quaternion": is_unit(target_attitude),
        }
