"""Rendezvous with a chief in a circular orbit by proportional-derivative feedback."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod


class RendezvousController(Component):
    """Brings a deputy to its chief, or to a position near it, without knowing the orbit.

    u = -Kp (q - q_d) - Kd q',   f = m u                                                (12)

    With q_d = 0, as in the paper, it converges in a circular orbit if Kp exceeds 3 ω² along z:
    sufficient, not necessary. Elsewhere the orbit leaves an offset of g(q_d)/Kp;
    `StationKeepingController` takes it away.

    Source: relative motion in the LVLH frame paper, section III.A.
    """

    position = Input(3, "m", frame="lvlh", doc="q, deputy's position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    desired_position = Input(3, "m", frame="lvlh", doc="q_d")
    lvlh_force = Output(3, "N", frame="lvlh", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="deputy's mass")
    position_gain = Parameter(3, "1/s2", 1e-4, min=0.0, frame="lvlh", doc="diagonal of Kp")
    velocity_gain = Parameter(3, "1/s", 0.1, min=0.0, frame="lvlh", doc="diagonal of Kd")
    sample_period = SamplePeriod()

    def outputs(self, position, velocity, desired_position, mass, position_gain, velocity_gain):
        spring = position_gain * (position - desired_position)
        return {"lvlh_force": -mass * (spring + velocity_gain * velocity)}             # (12)

    def requirements(self, velocity_gain):
        return {"velocity_gain must be positive on all axes": np.min(velocity_gain) > 0.0}
