"""Desired relative position along a fixed inertial direction."""

from ..component import Component
from ..declarations import Output, Parameter
from ..maths import is_unit
from .profiles import (
    duration_parameter,
    hold_time_parameter,
    linear_parameter,
    progress,
    start_time_parameter,
)


class SeparationGuidance(Component):
    """Moves the desired position along a direction from one distance to another, then holds it.

    x_d = (d0 + (d1 - d0) s(t)) n

    with the profile s, quintic (at rest at both ends) or linear.

    Source: 6-DOF precision formation flying at L2 paper, section on simulation.
    """

    desired_position = Output(3, "m", frame="inertial", doc="x_d")
    desired_velocity = Output(3, "m/s", frame="inertial", doc="rate of x_d")
    desired_acceleration = Output(3, "m/s2", frame="inertial", doc="second rate of x_d")
    direction = Parameter(3, "1", (1.0, 0.0, 0.0), frame="inertial", doc="n, unit vector")
    start_distance = Parameter((), "m", 0.0, doc="d0")
    end_distance = Parameter((), "m", 1.0, doc="d1")
    start_time = start_time_parameter()
    duration = duration_parameter("of the manoeuvre")
    linear = linear_parameter()
    hold_time = hold_time_parameter()

    def outputs(self, time, direction, start_distance, end_distance, start_time, duration, linear,
                hold_time):
        s, rate, acceleration = progress(time, start_time, duration, linear, hold_time)
        way = end_distance - start_distance
        return {
            "desired_position": (start_distance + way * s) * direction,
            "desired_velocity": way * rate * direction,
            "desired_acceleration": way * acceleration * direction,
        }

    def requirements(self, direction):
        return {"direction must be a unit vector": is_unit(direction)}
