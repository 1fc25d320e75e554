"""Relative motion in line-of-sight spherical coordinates."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output
from .spherical import spherical_axes, to_spherical


class LvlhToSpherical(Component):
    """Range, elevation and azimuth of a position in the LVLH frame, and their rates.

    x = r cos ψ cos θ,   y = r sin ψ,   z = -r cos ψ sin θ                              (A1)
    r' = e_r·q',   ψ' = e_ψ·q'/r,   θ' = e_θ·q'/(r cos ψ)

    Source: relative motion in the LVLH frame paper, appendix.
    """

    position = Input(3, "m", (1.0, 0.0, 0.0), frame="lvlh", doc="q, deputy's position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    range = Output((), "m", doc="r, distance")
    elevation = Output((), "rad", doc="ψ, out of the orbit's plane, towards +y")
    azimuth = Output((), "rad", doc="θ, in the orbit's plane, from +x towards -z")
    range_rate = Output((), "m/s", doc="rate of r")
    elevation_rate = Output((), "rad/s", doc="rate of ψ")
    azimuth_rate = Output((), "rad/s", doc="rate of θ")

    def outputs(self, position, velocity):
        r, ψ, θ = to_spherical(position)                                               # (A1)
        e_r, e_ψ, e_θ = spherical_axes(ψ, θ)
        return {
            "range": r,
            "elevation": ψ,
            "azimuth": θ,
            "range_rate": e_r @ velocity,
            "elevation_rate": e_ψ @ velocity / r,
            "azimuth_rate": e_θ @ velocity / (r * np.cos(ψ)),
        }

    def requirements(self, position):
        return {"position must not be on the frame's y axis":
                position[0] * position[0] + position[2] * position[2] > 0.0}
