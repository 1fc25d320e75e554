"""A force given in the LVLH frame of the chief, in inertial components."""

from ..component import Component
from ..declarations import Input, Output
from ..dynamics.planet_environment import START_RADIUS, START_SPEED
from .lvlh import lvlh_axes, orbit_requirement


class LvlhToInertial(Component):
    """Turns a control force from the LVLH frame to the inertial one.

    f_inertial = C^T f_lvlh

    Source: relative motion in the LVLH frame paper, section II.
    """

    chief_position = Input(3, "m", (START_RADIUS, 0.0, 0.0), frame="inertial",
                           doc="chief's centre of mass from the planet's centre")
    chief_velocity = Input(3, "m/s", (0.0, START_SPEED, 0.0), frame="inertial",
                           doc="chief's velocity")
    lvlh_force = Input(3, "N", frame="lvlh", doc="force on the deputy")
    force = Output(3, "N", frame="inertial", doc="the same force")

    def outputs(self, chief_position, chief_velocity, lvlh_force):
        return {"force": lvlh_axes(chief_position, chief_velocity).T @ lvlh_force}

    def requirements(self, chief_position, chief_velocity):
        return orbit_requirement(chief_position, chief_velocity)
