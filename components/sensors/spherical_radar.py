"""Radar: range and two angles of a target in the LVLH frame."""

import numpy as np

from ..declarations import Input, Output, Parameter
from ..maths import is_unit, unit
from ..transforms.spherical import to_spherical
from .measurement import in_view
from .sensor import Channel, Sensor


class SphericalRadar(Sensor, channels=[
    Channel("range", "range_"), Channel("elevation", "elevation_"), Channel("azimuth", "azimuth_"),
]):
    """Range r, elevation ψ and azimuth θ of a position in the LVLH frame, each with its errors.

    x = r cos ψ cos θ,   y = r sin ψ,   z = -r cos ψ sin θ                              (A1)

    Source: relative motion in the LVLH frame paper, appendix.
    """

    position = Input(3, "m", (1.0, 0.0, 0.0), frame="lvlh", doc="q, true position")
    range = Output((), "m", 1.0, doc="r, distance")
    elevation = Output((), "rad", doc="ψ, out of the orbit's plane, towards +y")
    azimuth = Output((), "rad", doc="θ, in the orbit's plane, from +x towards -z")
    boresight = Parameter(3, "1", (1.0, 0.0, 0.0), frame="lvlh", doc="middle of the field of view")
    field_of_view = Parameter((), "rad", 3.2, min=0.0, doc="half angle; π or more: all")
    minimum_range = Parameter((), "m", min=0.0, doc="nearest distance that can be measured")
    maximum_range = Parameter((), "m", 1e12, min=0.0, doc="farthest distance that can be measured")

    def truth(self, position, boresight, field_of_view, minimum_range, maximum_range):
        r, ψ, θ = to_spherical(position)                                               # (A1)
        seen = in_view(unit(position), r, boresight, field_of_view, minimum_range, maximum_range)
        return {"range": r, "elevation": ψ, "azimuth": θ, "valid": seen}

    def requirements(self, position, boresight):
        return {
            "position must not be on the frame's y axis":
                np.sqrt(position[0] * position[0] + position[2] * position[2]) > 0.0,
            "boresight must be a unit vector": is_unit(boresight),
        }
