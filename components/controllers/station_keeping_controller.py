"""Regulation of a deputy to a constant position in the LVLH frame of any Keplerian orbit."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from .relative_motion import gravity_terms


class StationKeepingController(Component):
    """Keeps a deputy at a constant position near a chief in a circular or elliptic orbit.

    u = g(q) - Kp (q - q_d) - Kd q',   f = m u                                          (16)

    Coriolis terms do no work and are not cancelled. In (17) of the paper read Kp for Kd.

    Source: relative motion in the LVLH frame paper, section III.B.
    """

    position = Input(3, "m", frame="lvlh", doc="q, deputy's position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    desired_position = Input(3, "m", frame="lvlh", doc="q_d")
    orbit_rate = Input((), "rad/s", doc="ω, chief's orbit rate")
    orbit_acceleration = Input((), "rad/s2", doc="rate of ω")
    gravity_gradient = Input((), "1/s2", doc="k, the planet's μ by the cube of chief's radius")
    lvlh_force = Output(3, "N", frame="lvlh", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="deputy's mass")
    position_gain = Parameter(3, "1/s2", 1e-4, min=0.0, frame="lvlh", doc="diagonal of Kp")
    velocity_gain = Parameter(3, "1/s", 0.1, min=0.0, frame="lvlh", doc="diagonal of Kd")
    sample_period = SamplePeriod()

    def outputs(self, position, velocity, desired_position, orbit_rate, orbit_acceleration,
                gravity_gradient, mass, position_gain, velocity_gain):
        g = gravity_terms(position, orbit_rate, orbit_acceleration, gravity_gradient)   # (6)
        spring = position_gain * (position - desired_position)
        return {"lvlh_force": mass * (g - spring - velocity_gain * velocity)}          # (16)

    def requirements(self, position_gain, velocity_gain):
        return {
            "position_gain must be positive on all axes": np.min(position_gain) > 0.0,
            "velocity_gain must be positive on all axes": np.min(velocity_gain) > 0.0,
        }
