"""Relative position and velocity from range and line of sight by a Kalman filter."""

import numpy as np

from ..component import Component
from ..declarations import DiscreteState, Input, Output, Parameter, SamplePeriod
from ..maths import product
from .kalman import congruent, corrected, is_covariance
from .relative_motion_model import turn_matrix


class RelativeVelocityKalmanFilter(Component):
    """Kalman filter of a target's position and velocity against the observer, in its body frame.

    x = [p, v];   x -> F x + G a,   F = [[R, T R], [0, R]],   G = [½T² R; T R],   R = exp(-T S(Ω))
    measured  p = d b,   covariance  M = σd² b b^T + d² σb² (I - b b^T)
    K = P H^T S^-1,   S = H P H^T + M,   P <- (I - KH) P (I - KH)^T + K M K^T

    ``acceleration`` is what is known of the target's acceleration against the own one, for example
    from both craft's commands; white noise of density q stands for the rest. NIS = ν·S^-1 ν of
    the innovation ν is chi-squared with 3 degrees of freedom if the parameters are right.

    Source: Y. Bar-Shalom, X. Li, T. Kirubarajan, Estimation with Applications to Tracking and
    Navigation, ch. 5 (Joseph form), ch. 6 (white-noise acceleration), ch. 5.4 (consistency).
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="unit vector to the target")
    range = Input((), "m", 1.0, doc="distance to the target")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    acceleration = Input(3, "m/s2", frame="body", optional=True,
                         doc="target's acceleration minus own")
    valid = Input((), "1", 1.0, type="boolean", optional=True,
                  doc="whether there is a new measurement")
    relative_velocity = Output(3, "m/s", frame="body", doc="target's velocity minus own")
    relative_position = Output(3, "m", frame="body", doc="from own craft to target")
    deviation = Output(6, "1", doc="standard deviations of position, m, and velocity, m/s")
    innovation = Output(3, "m", frame="body", doc="ν, measured minus predicted position")
    normalised_innovation = Output((), "1", doc="NIS, 3 on average; 0 without measurement")
    predicted = DiscreteState(6, "1", doc="x before the next measurement, m and m/s")
    covariance = DiscreteState((6, 6), "1", np.eye(6), doc="P before the next measurement")
    started = DiscreteState((), "1", doc="0 before the first measurement")
    range_deviation = Parameter((), "m", 0.1, min=1e-12, doc="σd of one sample")
    angle_deviation = Parameter((), "rad", 1e-3, min=1e-12, doc="σb of one sample")
    velocity_deviation = Parameter((), "m/s", 1.0, min=1e-12, doc="spread of velocity at the start")
    acceleration_density = Parameter((), "m/s2/sqrt(Hz)", 1e-3, min=1e-12,
                                     doc="sqrt(q), unknown acceleration")
    sample_period = SamplePeriod(start=0.1)

    def outputs(self, line_of_sight, range, valid, started, predicted, covariance,
                range_deviation, angle_deviation, velocity_deviation):
        x, P, ν, nis = corrected(line_of_sight, range, valid, started, predicted, covariance,
                                 range_deviation, angle_deviation, velocity_deviation)
        return {
            "relative_velocity": x[3:],
            "relative_position": x[:3],
            "deviation": np.sqrt(np.maximum(np.diag(P), 0.0)),
            "innovation": ν,
            "normalised_innovation": nis,
        }

    def update(self, line_of_sight, range, angular_velocity, acceleration, valid, started,
               predicted, covariance, range_deviation, angle_deviation, velocity_deviation,
               acceleration_density, sample_period):
        x, P, _, _ = corrected(line_of_sight, range, valid, started, predicted, covariance,
                               range_deviation, angle_deviation, velocity_deviation)
        T, ones = sample_period, np.eye(3)
        R = turn_matrix(angular_velocity, T)
        F = np.block([[R, T * R], [0.0 * ones, R]])
        q = acceleration_density * acceleration_density
        Q = q * np.block([[T**3 / 3.0 * ones, T**2 / 2.0 * ones], [T**2 / 2.0 * ones, T * ones]])
        turned = product(R, acceleration)
        push = np.concatenate([0.5 * T**2 * turned, T * turned])
        return {"predicted": product(F, x) + push, "covariance": congruent(F, P) + Q,
                "started": np.where(valid > 0.5, 1.0, started)}

    def requirements(self, sample_period, covariance):
        return {
            "sample_period must be positive": sample_period > 0.0,
            "covariance must be symmetric and positive definite": is_covariance(covariance),
        }
