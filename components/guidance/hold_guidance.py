"""Desired pose that stays."""

import numpy as np

from ..component import Component
from ..declarations import Output, Parameter
from ..maths import IDENTITY, is_unit


class HoldGuidance(Component):
    """Holds a desired position and attitude: all rates are zero.

    x_d = const,   q_d = const

    The reference frame of the position is whatever the config binds it to: inertial, LVLH, ...

    Source: relative motion in the LVLH frame paper, section III.B.
    """

    desired_position = Output(3, "m", frame="reference", doc="x_d")
    desired_velocity = Output(3, "m/s", frame="reference", doc="zero")
    desired_acceleration = Output(3, "m/s2", frame="reference", doc="zero")
    desired_attitude = Output(4, "1", IDENTITY, frame="desired_body",
                              doc="q_d, desired body to inertial, scalar last")
    desired_angular_velocity = Output(3, "rad/s", frame="desired_body", doc="zero")
    desired_angular_acceleration = Output(3, "rad/s2", frame="desired_body", doc="zero")
    position = Parameter(3, "m", frame="reference", tunable=True, doc="where to stay")
    attitude = Parameter(4, "1", IDENTITY, frame="desired_body", tunable=True,
                         doc="which attitude to keep")

    def outputs(self, position, attitude):
        return {
            "desired_position": position,
            "desired_velocity": np.zeros(3),
            "desired_acceleration": np.zeros(3),
            "desired_attitude": attitude,
            "desired_angular_velocity": np.zeros(3),
            "desired_angular_acceleration": np.zeros(3),
        }

    def requirements(self, attitude):
        return {"attitude must be a unit quaternion": is_unit(attitude)}
