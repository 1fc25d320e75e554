"""Line-of-sight sensor: the direction to another spacecraft."""

import numpy as np

from ..declarations import Input, Output, Parameter
from ..maths import IDENTITY, is_unit, rotate_inverse, unit
from .measurement import in_view
from .sensor import Channel, Sensor

EVERYWHERE = 3.2  # rad, beyond π: no direction is out of view


class LineOfSightSensor(
    Sensor, channels=[Channel("line_of_sight", errors="direction", frame="body")]
):
    """Direction from the observer to another spacecraft, seen in the observer's body frame.

    b_ij = R_i^T (r_j - r_i) / |r_j - r_i|                                              (12)

    Errors turn the direction by small angles about the body axes, so that its norm stays 1:
    measured = R(bias + drift + noise) b_ij. Out of view the last direction stays.

    Source: coupled LOS attitude and position control paper, eqs. (11), (12).
    """

    position = Input(3, "m", frame="inertial", doc="observer's centre of mass")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="observed centre of mass")
    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="observer's attitude, body to inertial, scalar last")
    line_of_sight = Output(3, "1", (1.0, 0.0, 0.0), frame="body", doc="unit vector to the target")
    boresight = Parameter(3, "1", (1.0, 0.0, 0.0), frame="body", doc="middle of the field of view")
    field_of_view = Parameter((), "rad", EVERYWHERE, min=0.0, doc="half angle; π or more: all")
    minimum_range = Parameter((), "m", min=0.0, doc="nearest distance of a visible target")
    maximum_range = Parameter((), "m", 1e12, min=0.0, doc="farthest distance of a visible target")

    def truth(self, position, target_position, attitude, boresight, field_of_view,
              minimum_range, maximum_range):
        offset = target_position - position
        b12 = rotate_inverse(attitude, unit(offset))                             # (11), (12)
        seen = in_view(b12, np.linalg.norm(offset), boresight, field_of_view, minimum_range,
                       maximum_range)
        return {"line_of_sight": b12, "valid": seen}

    def requirements(self, position, target_position, attitude, boresight):
        return {
            "target_position must differ from position":
                np.linalg.norm(target_position - position) > 0.0,
            "attitude must be a unit quaternion": is_unit(attitude),
            "boresight must be a unit vector": is_unit(boresight),
        }
