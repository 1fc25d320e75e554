"""Errors and Lyapunov functions of adaptive tracking in six degrees of freedom."""

import numpy as np

from ..component import Component
from ..controllers.adaptive_tracking import attitude_error, inertia_vector
from ..declarations import Array, Input, Output, Parameter, Scalar
from ..maths import IDENTITY, is_unit


class PrecisionFormationMonitor(Component):
    """Tracking errors of a follower, and the Lyapunov functions of both adaptive laws.

    V_T = ½ s·s + |θ^ - θ|²/(2γ),              V_T' = -K_T s·s                      (8)-(10)
    V_R = ½ s_R·H s_R + |θ^_R - θ_R|²/(2 G_R), V_R' = -K_R s_R·s_R                 (16)-(18)

    The rates hold for constant θ; the true environment's varies slowly and leaves e a floor. Give
    θ1, θ2 where they are known; a gain of 0 leaves out the term of the estimate.

    Source: 6-DOF precision formation flying at L2 paper, sections on control law design.
    """

    relative_position = Input(3, "m", frame="inertial", doc="x, from the leader")
    relative_velocity = Input(3, "m/s", frame="inertial", doc="velocity less the leader's")
    desired_position = Input(3, "m", frame="inertial", doc="x_d")
    desired_velocity = Input(3, "m/s", frame="inertial", optional=True, doc="rate of x_d")
    attitude = Input(4, "1", IDENTITY, frame="body", doc="attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", doc="ω")
    desired_attitude = Input(4, "1", IDENTITY, frame="desired_body",
                             doc="q_d, desired body to inertial, scalar last")
    desired_angular_velocity = Input(3, "rad/s", frame="desired_body", optional=True, doc="ω_d")
    inertial_estimate = Input(3, "m/s2", frame="inertial", doc="θ^1")
    rotating_estimate = Input(3, "m/s2", frame="rotating", doc="θ^2")
    inertia_estimate = Input(6, "kg.m2", (1.0, 1.0, 1.0, 0.0, 0.0, 0.0), frame="body", doc="θ^_R")
    position_error = Output((), "m", doc="|e|")
    attitude_error = Output((), "rad", doc="angle of q̃")
    translation_lyapunov = Output((), "m2/s2", doc="V_T")
    translation_lyapunov_rate = Output((), "m2/s3", doc="V_T' by its formula")
    rotation_lyapunov = Output((), "J", doc="V_R")
    rotation_lyapunov_rate = Output((), "W", doc="V_R' by its formula")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="H, true inertia")
    inertial_disturbance = Parameter(3, "m/s2", frame="inertial", doc="true θ1")
    rotating_disturbance = Parameter(3, "m/s2", frame="rotating", doc="true θ2")
    translation_error_gain = Parameter((), "1/s", 2e-3, min=0.0, doc="Λ_T")
    translation_metric_gain = Parameter((), "1/s", 4e-3, min=0.0, doc="K_T")
    translation_adaptation_gain = Parameter((), "1/s2", 2e-6, min=0.0, doc="γ")
    rotation_error_gain = Parameter((), "rad/s", 0.02, min=0.0, doc="Λ_R")
    rotation_metric_gain = Parameter((), "N.m.s/rad", 8.0, min=0.0, doc="K_R")
    rotation_adaptation_gain = Parameter((), "kg.m2.s2", 1e9, min=0.0, doc="G_R")

    def outputs(self, relative_position, relative_velocity, desired_position, desired_velocity,
                attitude, angular_velocity, desired_attitude, desired_angular_velocity,
                inertial_estimate, rotating_estimate, inertia_estimate, inertia,
                inertial_disturbance, rotating_disturbance, translation_error_gain,
                translation_metric_gain, translation_adaptation_gain, rotation_error_gain,
                rotation_metric_gain, rotation_adaptation_gain):
        e = relative_position - desired_position
        s = relative_velocity - desired_velocity + translation_error_gain * e
        unlearnt = np.concatenate([inertial_estimate - inertial_disturbance,
                                   rotating_estimate - rotating_disturbance])
        turn = attitude_error(attitude, angular_velocity, desired_attitude,
                              desired_angular_velocity)
        s_R = turn.angular_velocity + rotation_error_gain * turn.quaternion[:3]
        unknown = inertia_estimate - inertia_vector(inertia)
        return {
            "position_error": np.linalg.norm(e),
            "attitude_error": turn.angle,
            "translation_lyapunov":
                0.5 * (s @ s + weighed(unlearnt, translation_adaptation_gain)),
            "translation_lyapunov_rate": -translation_metric_gain * (s @ s),
            "rotation_lyapunov":
                0.5 * (s_R @ (inertia @ s_R) + weighed(unknown, rotation_adaptation_gain)),
            "rotation_lyapunov_rate": -rotation_metric_gain * (s_R @ s_R),
        }

    def requirements(self, attitude, desired_attitude):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            "desired_attitude must be a unit quaternion": is_unit(desired_attitude),
        }


def weighed(error: Array, gain: Scalar) -> Scalar:
    """|error|²/gain; 0 if the gain is 0."""
    learning = gain > 0.0
    return np.where(learning, error @ error / np.where(learning, gain, 1.0), 0.0)
