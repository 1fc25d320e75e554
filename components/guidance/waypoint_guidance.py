"""Desired position through a sequence of waypoints."""

import numpy as np

from ..component import Component
from ..declarations import Output, Parameter, Structure
from .profiles import hold_time_parameter, linear_parameter, progress


class WaypointGuidance(Component):
    """Leads from waypoint to waypoint on straight lines, resting at each as long as wanted.

    x_d = p_1 + Σ_k (p_k+1 - p_k) s((t - t_k)/T_k)

    Leg k departs at t_k and takes T_k, with the quintic profile (at rest at both ends) or the
    linear one. Legs that overlap in time add up and so round the corner. The reference frame is
    whatever the config binds it to: inertial, LVLH, ...

    Source: relative motion in the LVLH frame paper, section III.C.
    """

    legs = Structure(2, doc="number of legs; there is one waypoint more")
    desired_position = Output(3, "m", frame="reference", doc="x_d")
    desired_velocity = Output(3, "m/s", frame="reference", doc="rate of x_d")
    desired_acceleration = Output(3, "m/s2", frame="reference", doc="second rate of x_d")
    start_position = Parameter(3, "m", frame="reference", doc="p_1, before the first leg")
    waypoints = Parameter(("legs", 3), "m", frame="reference", doc="p_2, p_3, ..., ends of legs")
    departures = Parameter("legs", "s", lambda legs: 3600.0 * np.arange(legs),
                           doc="t_k, when each leg starts")
    durations = Parameter("legs", "s", 3600.0, min=1e-9, doc="T_k, of each leg")
    linear = linear_parameter()
    hold_time = hold_time_parameter()

    def outputs(self, time, start_position, waypoints, departures, durations, linear, hold_time):
        corners = np.concatenate([np.reshape(start_position, (1, 3)), waypoints])
        ways = (corners[1:] - corners[:-1]).T
        s, rate, acceleration = progress(time, departures, durations, linear, hold_time)
        return {
            "desired_position": start_position + ways @ s,
            "desired_velocity": ways @ rate,
            "desired_acceleration": ways @ acceleration,
        }

    def requirements(self, durations):
        return {"durations must be positive": np.min(durations) > 0.0}
