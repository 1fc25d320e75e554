"""Desired attitude on a turn about a fixed axis."""

import numpy as np

from ..component import Component
from ..declarations import Output, Parameter
from ..maths import IDENTITY, is_unit, multiply, scalar_last
from .profiles import (
    duration_parameter,
    hold_time_parameter,
    linear_parameter,
    progress,
    start_time_parameter,
)


class SlewGuidance(Component):
    """Turns the desired attitude about an eigenaxis by an angle, then holds it.

    q_d = q_0 [n sin(½ φ), cos(½ φ)],   ω_d = φ' n,   ω_d' = φ'' n,   φ = φ1 s(t)

    with the profile s, quintic (at rest at both ends) or linear. The axis n has the same
    components in the body frame at the start and in the turning desired one.

    Source: 6-DOF precision formation flying at L2 paper, section on simulation.
    """

    desired_attitude = Output(4, "1", IDENTITY, frame="desired_body",
                              doc="q_d, desired body to inertial, scalar last")
    desired_angular_velocity = Output(3, "rad/s", frame="desired_body", doc="ω_d")
    desired_angular_acceleration = Output(3, "rad/s2", frame="desired_body", doc="rate of ω_d")
    start_attitude = Parameter(4, "1", IDENTITY, frame="desired_body",
                               doc="q_0, at the start, body to inertial")
    axis = Parameter(3, "1", (0.0, 0.0, 1.0), frame="desired_body", doc="n, unit vector")
    angle = Parameter((), "rad", 0.0, doc="φ1, of the whole turn")
    start_time = start_time_parameter()
    duration = duration_parameter("of the turn")
    linear = linear_parameter()
    hold_time = hold_time_parameter()

    def outputs(self, time, start_attitude, axis, angle, start_time, duration, linear, hold_time):
        s, rate, acceleration = progress(time, start_time, duration, linear, hold_time)
        half = 0.5 * angle * s
        turn = scalar_last(np.sin(half) * axis, np.cos(half))
        return {
            "desired_attitude": multiply(start_attitude, turn),
            "desired_angular_velocity": angle * rate * axis,
            "desired_angular_acceleration": angle * acceleration * axis,
        }

    def requirements(self, start_attitude, axis):
        return {
            "start_attitude must be a unit quaternion": is_unit(start_attitude),
            "axis must be a unit vector": is_unit(axis),
        }
