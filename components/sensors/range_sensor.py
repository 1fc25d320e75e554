"""Range sensor: the distance to another spacecraft."""

import numpy as np

from ..declarations import Input, Output, Parameter
from .measurement import in_range
from .sensor import Channel, Sensor


class RangeSensor(Sensor, channels=[Channel("range")]):
    """Distance between the centres of mass of the observer and another spacecraft.

    d = |r_j - r_i|                                                                     (14)

    measured = (1 + scale_factor) d + bias + drift + noise.

    Source: coupled LOS attitude and position control paper, eq. (14).
    """

    position = Input(3, "m", frame="inertial", doc="observer's centre of mass")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="observed centre of mass")
    range = Output((), "m", 1.0, doc="distance to the target")
    minimum_range = Parameter((), "m", min=0.0, doc="nearest distance that can be measured")
    maximum_range = Parameter((), "m", 1e12, min=0.0, doc="farthest distance that can be measured")

    def truth(self, position, target_position, minimum_range, maximum_range):
        d = np.linalg.norm(target_position - position)                                 # (14)
        return {"range": d, "valid": in_range(d, minimum_range, maximum_range)}
