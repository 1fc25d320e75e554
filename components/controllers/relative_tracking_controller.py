"""Tracking of a trajectory in the LVLH frame of any Keplerian orbit: computed torque."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from .relative_motion import coriolis, gravity_terms


class RelativeTrackingController(Component):
    """Leads a deputy along a desired trajectory near a chief in a circular or elliptic orbit.

    u = q_d'' - Kd e' - Kp e + C q' + g(q),   e = q - q_d,   f = m u                    (19)

    Source: relative motion in the LVLH frame paper, section III.C.
    """

    position = Input(3, "m", frame="lvlh", doc="q, deputy's position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    desired_position = Input(3, "m", frame="lvlh", doc="q_d")
    desired_velocity = Input(3, "m/s", frame="lvlh", optional=True, doc="rate of q_d")
    desired_acceleration = Input(3, "m/s2", frame="lvlh", optional=True, doc="second rate of q_d")
    orbit_rate = Input((), "rad/s", doc="ω, chief's orbit rate")
    orbit_acceleration = Input((), "rad/s2", doc="rate of ω")
    gravity_gradient = Input((), "1/s2", doc="k, the planet's μ by the cube of chief's radius")
    lvlh_force = Output(3, "N", frame="lvlh", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="deputy's mass")
    position_gain = Parameter(3, "1/s2", 1e-4, min=0.0, frame="lvlh", doc="diagonal of Kp")
    velocity_gain = Parameter(3, "1/s", 0.1, min=0.0, frame="lvlh", doc="diagonal of Kd")
    sample_period = SamplePeriod()

    def outputs(self, position, velocity, desired_position, desired_velocity,
                desired_acceleration, orbit_rate, orbit_acceleration, gravity_gradient, mass,
                position_gain, velocity_gain):
        e, e_rate = position - desired_position, velocity - desired_velocity
        wanted = desired_acceleration - velocity_gain * e_rate - position_gain * e
        g = gravity_terms(position, orbit_rate, orbit_acceleration, gravity_gradient)   # (6)
        return {"lvlh_force": mass * (wanted + coriolis(velocity, orbit_rate) + g)}    # (19)

    def requirements(self, position_gain, velocity_gain):
        return {
            "position_gain must be positive on all axes": np.min(position_gain) > 0.0,
            "velocity_gain must be positive on all axes": np.min(velocity_gain) > 0.0,
        }
