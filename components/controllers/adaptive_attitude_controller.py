"""Adaptive tracking of an attitude by a rigid body of unknown inertia."""

import numpy as np

from ..component import Component
from ..declarations import DiscreteState, Input, Output, Parameter, SamplePeriod, State
from ..maths import IDENTITY, cross, is_unit
from .adaptive_tracking import inertia_times, learning_regressor, reference_rate


class AdaptiveAttitudeController(Component):
    """Leads a body along a desired attitude, learning its inertia matrix.

    τ = Γ_R θ^_R - K_R s_R,   Γ_R θ_R = H ω_r' - (H ω) × ω_r                       (16), (17)
    θ^_R' = -G_R Γ_R^T s_R,   θ_R = (H11, H22, H33, H23, H13, H12)                      (18)
    ω_r = R(q̃)^T ω_d - Λ_R ε̃,   s_R = ω - ω_r

    q̃ turns from the body to the desired body frame, the nearer of ±q̃. With `adaptation_gain` 0
    and the true inertia as start value it is the law for known inertia (15). The paper prints ω_r
    without R(q̃); that converges too. A sampled law learns from one tick to the next at the rate
    of the first.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (15)-(18).
    """

    default_solver_step = 1.0  # s

    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="own attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", doc="ω, own angular velocity")
    desired_attitude = Input(4, "1", IDENTITY, frame="desired_body",
                             doc="q_d, desired body to inertial, scalar last")
    desired_angular_velocity = Input(3, "rad/s", frame="desired_body", optional=True, doc="ω_d")
    desired_angular_acceleration = Input(3, "rad/s2", frame="desired_body", optional=True,
                                         doc="rate of ω_d")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    error_gain = Parameter((), "rad/s", 0.02, min=0.0, doc="Λ_R, weighs ε̃ in s_R")
    metric_gain = Parameter((), "N.m.s/rad", 8.0, min=0.0, doc="K_R, damps s_R")
    adaptation_gain = Parameter((), "kg.m2.s2", 1e9, min=0.0, doc="G_R; 0: no learning, (15)")
    sample_period = SamplePeriod()
    inertia_estimate = State(6, "kg.m2", (1.0, 1.0, 1.0, 0.0, 0.0, 0.0), frame="body",
                             output=True, doc="θ^_R = (H11, H22, H33, H23, H13, H12)")
    sampled_regressor = DiscreteState(6, "rad2/s3", frame="body", doc="Γ_R^T s_R of the last tick")

    def derivatives(self, attitude, angular_velocity, desired_attitude, desired_angular_velocity,
                    desired_angular_acceleration, error_gain, adaptation_gain, sample_period,
                    sampled_regressor):
        present = learning_regressor(attitude, angular_velocity, desired_attitude,
                                     desired_angular_velocity, desired_angular_acceleration,
                                     error_gain)
        regressor = np.where(sample_period > 0.0, sampled_regressor, present)
        return {"inertia_estimate": -adaptation_gain * regressor}                      # (18)

    def update(self, attitude, angular_velocity, desired_attitude, desired_angular_velocity,
               desired_angular_acceleration, error_gain):
        return {"sampled_regressor": learning_regressor(
            attitude, angular_velocity, desired_attitude, desired_angular_velocity,
            desired_angular_acceleration, error_gain)}

    def outputs(self, attitude, angular_velocity, desired_attitude, desired_angular_velocity,
                desired_angular_acceleration, error_gain, metric_gain, inertia_estimate):
        ω_r, ω_r_rate = reference_rate(attitude, angular_velocity, desired_attitude,
                                       desired_angular_velocity, desired_angular_acceleration,
                                       error_gain)
        momentum = inertia_times(inertia_estimate, angular_velocity)
        model = inertia_times(inertia_estimate, ω_r_rate) - cross(momentum, ω_r)       # (17)
        return {"torque": model - metric_gain * (angular_velocity - ω_r)}        # (15), (16)

    def requirements(self, attitude, desired_attitude, error_gain, metric_gain):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            "desired_attitude must be a unit quaternion": is_unit(desired_attitude),
            "error_gain and metric_gain must be positive":
                np.minimum(error_gain, metric_gain) > 0.0,
        }
