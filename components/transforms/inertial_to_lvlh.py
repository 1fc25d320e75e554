"""Relative motion of a deputy in the LVLH frame of its chief."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter
from ..dynamics.planet_environment import EARTH, START_RADIUS, START_SPEED
from ..maths import cross
from .lvlh import lvlh_axes, orbit_rate, orbit_requirement

AXIS = np.array([0.0, -1.0, 0.0])  # of the frame's turn


class InertialToLvlh(Component):
    """Relative position and velocity in the turning LVLH frame, and how this frame turns.

    q = C ρ,   q' = C ρ' - Ω × q,   Ω = (0, -ω, 0)
    ω = |r × v|/r²,   ω' = -2 ω (r·v)/r²,   k = μ/r³

    The velocity is the one that an observer in the frame sees. ω' is that of an orbit without
    forces across the radius; the turn of the orbit's plane by oblateness, 1e-6 rad/s, is left out.

    Source: relative motion in the LVLH frame paper, section II.
    """

    chief_position = Input(3, "m", (START_RADIUS, 0.0, 0.0), frame="inertial",
                           doc="chief's centre of mass from the planet's centre")
    chief_velocity = Input(3, "m/s", (0.0, START_SPEED, 0.0), frame="inertial",
                           doc="chief's velocity")
    relative_position = Input(3, "m", frame="inertial", doc="ρ, from the chief to the deputy")
    relative_velocity = Input(3, "m/s", frame="inertial", doc="deputy's velocity less the chief's")
    position = Output(3, "m", frame="lvlh", doc="q, deputy's position in the frame")
    velocity = Output(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    orbit_rate = Output((), "rad/s", doc="ω, the frame's angular velocity about -y")
    orbit_acceleration = Output((), "rad/s2", doc="rate of ω")
    gravity_gradient = Output((), "1/s2", doc="k, the planet's μ by the cube of the radius")
    gravitational_parameter = Parameter((), "m3/s2", EARTH, min=1.0, doc="μ of the planet")

    def outputs(self, chief_position, chief_velocity, relative_position, relative_velocity,
                gravitational_parameter):
        r, v = chief_position, chief_velocity
        C, ω = lvlh_axes(r, v), orbit_rate(r, v)
        q = C @ relative_position
        return {
            "position": q,
            "velocity": C @ relative_velocity - ω * cross(AXIS, q),
            "orbit_rate": ω,
            "orbit_acceleration": -2.0 * ω * (r @ v) / (r @ r),
            "gravity_gradient": gravitational_parameter / np.linalg.norm(r) ** 3,
        }

    def requirements(self, chief_position, chief_velocity):
        return orbit_requirement(chief_position, chief_velocity)
