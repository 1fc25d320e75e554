"""Attitude control by a quaternion's vector part and the angular velocity: the neutral baseline."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import IDENTITY, conjugate, is_unit, multiply, rotate_inverse


class AttitudePdController(Component):
    """Turns a spacecraft to a wanted attitude and angular velocity, the short way round.

    τ = -kp 2 q̃ - kd (Ω - R(q̃)^T Ω_d),   q̃ = q_d^-1 q, of the sign with a scalar part >= 0

    For small angles 2 q̃ is the rotation vector of the error in the body frame.

    Source: B. Wie, P. Barba, Quaternion feedback for spacecraft large angle maneuvers, J. Guidance
    8 (1985).
    """

    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="own attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    desired_attitude = Input(4, "1", IDENTITY, frame="desired_body", doc="wanted attitude")
    desired_angular_velocity = Input(3, "rad/s", frame="desired_body", optional=True,
                                     doc="wanted angular velocity, in the wanted body frame")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    attitude_error = Output(3, "rad", frame="body", doc="2 q̃, rotation vector of a small error")
    attitude_gain = Parameter((), "N.m/rad", 0.1, min=0.0, doc="kp")
    rate_gain = Parameter((), "N.m.s/rad", 0.5, min=0.0, doc="kd")
    sample_period = SamplePeriod()

    def outputs(self, attitude, angular_velocity, desired_attitude, desired_angular_velocity,
                attitude_gain, rate_gain):
        error = multiply(conjugate(desired_attitude), attitude)
        error = np.where(error[3] < 0.0, -1.0, 1.0) * error
        rate_error = angular_velocity - rotate_inverse(error, desired_angular_velocity)
        angle = 2.0 * error[:3]
        return {"torque": -attitude_gain * angle - rate_gain * rate_error, "attitude_error": angle}

    def requirements(self, attitude, desired_attitude):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            "desired_attitude must be a unit quaternion": is_unit(desired_attitude),
        }
