"""Desired approach in line-of-sight spherical coordinates: first around, then straight in."""

import numpy as np

from ..component import Component
from ..declarations import Array, Output, Parameter, Scalar
from ..transforms.spherical import from_spherical
from .profiles import (
    duration_parameter,
    hold_time_parameter,
    linear_parameter,
    progress,
    start_time_parameter,
)


class SphericalApproachGuidance(Component):
    """Turns around the chief at constant range, then closes in along a line, then holds.

    ψ, θ: from start to end in the first duration;   r: in the second, which follows
    q_d from (r, ψ, θ) by (A1), with its rates

    Each with the quintic profile (at rest at both ends) or, as published, the linear one. With
    both end angles 0 the approach is along +x, "V-bar"; with an azimuth of -π/2 along +z, "R-bar".

    Source: relative motion in the LVLH frame paper, section IV, case 3, and appendix.
    """

    desired_position = Output(3, "m", frame="lvlh", doc="q_d")
    desired_velocity = Output(3, "m/s", frame="lvlh", doc="rate of q_d in the frame")
    desired_acceleration = Output(3, "m/s2", frame="lvlh", doc="second rate of q_d in the frame")
    desired_range = Output((), "m", doc="r")
    desired_elevation = Output((), "rad", doc="ψ")
    desired_azimuth = Output((), "rad", doc="θ")
    desired_range_rate = Output((), "m/s", doc="rate of r")
    desired_elevation_rate = Output((), "rad/s", doc="rate of ψ")
    desired_azimuth_rate = Output((), "rad/s", doc="rate of θ")
    desired_range_acceleration = Output((), "m/s2", doc="second rate of r")
    desired_elevation_acceleration = Output((), "rad/s2", doc="second rate of ψ")
    desired_azimuth_acceleration = Output((), "rad/s2", doc="second rate of θ")
    start_range = Parameter((), "m", 1.0, min=0.0, doc="r at the start")
    start_elevation = Parameter((), "rad", 0.0, doc="ψ at the start")
    start_azimuth = Parameter((), "rad", 0.0, doc="θ at the start")
    end_range = Parameter((), "m", 0.0, min=0.0, doc="r at the end")
    end_elevation = Parameter((), "rad", 0.0, doc="ψ of the final approach")
    end_azimuth = Parameter((), "rad", 0.0, doc="θ of the final approach")
    start_time = start_time_parameter()
    turn_duration = duration_parameter("of the turn")
    approach_duration = duration_parameter("of the approach")
    linear = linear_parameter()
    hold_time = hold_time_parameter()

    def outputs(self, time, start_range, start_elevation, start_azimuth, end_range, end_elevation,
                end_azimuth, start_time, turn_duration, approach_duration, linear, hold_time):
        turn = progress(time, start_time, turn_duration, linear, hold_time)
        approach = progress(time, start_time + turn_duration, approach_duration, linear, hold_time)
        start = np.stack([start_range, start_elevation, start_azimuth])
        way = np.stack([end_range, end_elevation, end_azimuth]) - start
        s, rate, second = (way * np.stack([a, t, t]) for t, a in zip(turn, approach, strict=True))
        coordinates = start + s
        q, q_rate, q_second = from_spherical(coordinates, rate, second)                # (A1)
        return {
            "desired_position": q,
            "desired_velocity": q_rate,
            "desired_acceleration": q_second,
            **named("", coordinates),
            **named("_rate", rate),
            **named("_acceleration", second),
        }

    def requirements(self, turn_duration, approach_duration):
        return {
            "turn_duration must be positive": turn_duration > 0.0,
            "approach_duration must be positive": approach_duration > 0.0,
        }


def named(suffix: str, values: Array) -> dict[str, Scalar]:
    """The outputs that three spherical coordinates, or their rates, are."""
    names = ("desired_range", "desired_elevation", "desired_azimuth")
    return {name + suffix: values[i] for i, name in enumerate(names)}
