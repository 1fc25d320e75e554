"""Relative velocity from range and line of sight by a filtered difference."""

import numpy as np

from ..component import Component
from ..declarations import Array, DiscreteState, Input, Output, Parameter, SamplePeriod, Scalar
from .relative_motion_model import seen_after


class RelativeVelocityDifferentiator(Component):
    """Inertial velocity of a target against the observer: the slope of a low-pass filter.

    p_k = d b                                                        measured position
    v_k = (1 - a) (p_k - z_k) / T                                    with a = exp(-T/τ)
    z   = R (z_k + (1 - a) (p_k - z_k)),   R = exp(-T S(Ω))          low-passed, one sample later

    The filter's memory turns with the gyro's angular velocity, so that a turn of the body is not
    taken for motion. A steady velocity comes out exact, a change of it late by τ.

    Source: G. Franklin, J. Powell, M. Workman, Digital Control of Dynamic Systems, ch. 6.
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="unit vector to the target")
    range = Input((), "m", 1.0, doc="distance to the target")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    valid = Input((), "1", 1.0, type="boolean", optional=True,
                  doc="whether there is a new measurement")
    relative_velocity = Output(3, "m/s", frame="body", doc="target's velocity minus own")
    filtered = DiscreteState(3, "m", frame="body", doc="z, low-passed relative position")
    velocity = DiscreteState(3, "m/s", frame="body", doc="the last relative velocity")
    started = DiscreteState((), "1", doc="0 before the first measurement")
    time_constant = Parameter((), "s", 1.0, min=1e-9, doc="τ of the low-pass filter")
    sample_period = SamplePeriod(start=0.1)

    def outputs(self, line_of_sight, range, valid, filtered, velocity, started, time_constant,
                sample_period):
        new = np.logical_and(valid > 0.5, started > 0.5)
        lag = range * line_of_sight - filtered
        return {"relative_velocity":
                np.where(new, slope(lag, time_constant, sample_period), velocity)}

    def update(self, line_of_sight, range, angular_velocity, valid, filtered, velocity, started,
               time_constant, sample_period):
        p, T, new = range * line_of_sight, sample_period, valid > 0.5
        v = np.where(np.logical_and(new, started > 0.5),
                     slope(p - filtered, time_constant, T), velocity)
        z = np.where(started > 0.5, filtered + T * v, np.where(new, p, filtered))
        return {
            "filtered": seen_after(z, angular_velocity, T),
            "velocity": seen_after(v, angular_velocity, T),
            "started": np.where(valid > 0.5, 1.0, started),
        }

    def requirements(self, sample_period):
        return {"sample_period must be positive": sample_period > 0.0}


def slope(lag: Array, time_constant: Scalar, sample_period: Scalar) -> Array:
    """(1 - a)/T times the distance of the measured from the low-passed position."""
    T = np.where(sample_period > 0.0, sample_period, 1.0)
    return (1.0 - np.exp(-T / time_constant)) / T * lag
