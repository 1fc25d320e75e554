"""Relative navigation sensor: position and velocity in the LVLH frame of a chief."""

import numpy as np

from ..declarations import Input, Output, Parameter
from .measurement import in_range
from .sensor import Channel, Sensor


class LvlhNavigationSensor(Sensor, channels=[
    Channel("measured_position", "position_", frame="lvlh"),
    Channel("measured_velocity", "velocity_", frame="lvlh"),
]):
    """Position and velocity of a deputy in the chief's LVLH frame, as relative GNSS gives them.

    measured = R(misalignment) (1 + scale_factor) q + bias + drift + noise, alike for q'

    Source: relative motion in the LVLH frame paper, section II.
    """

    position = Input(3, "m", (1.0, 0.0, 0.0), frame="lvlh", doc="q, true position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', true velocity in the frame")
    measured_position = Output(3, "m", (1.0, 0.0, 0.0), frame="lvlh", doc="measured position")
    measured_velocity = Output(3, "m/s", frame="lvlh", doc="measured velocity")
    maximum_range = Parameter((), "m", 1e12, min=0.0, doc="farthest distance that can be measured")

    def truth(self, position, velocity, maximum_range):
        seen = in_range(np.linalg.norm(position), 0.0, maximum_range)
        return {"measured_position": position, "measured_velocity": velocity, "valid": seen}
