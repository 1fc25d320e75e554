"""Error and Lyapunov functions of relative motion control in the LVLH frame."""

import numpy as np

from ..component import Component
from ..controllers.relative_motion import potential
from ..declarations import Input, Output, Parameter


class RelativeMotionMonitor(Component):
    """Tracking error of a deputy and the Lyapunov function of its controller.

    V = ½ e'·e' + ½ e·Kp e,   V' = -e'·Kd e',   e = q - q_d                   (17), (18), (19)
    V = ½ q'·q' + ½ q·Kp q + U(q),   V' = -q'·Kd q'                                (13), (15)

    The second, with the potential U (8), is that of the rendezvous in a circular orbit: choose it
    by `with_potential`. In (17) of the paper read Kp for Kd.

    Source: relative motion in the LVLH frame paper, sections II and III.
    """

    position = Input(3, "m", frame="lvlh", doc="q, deputy's position")
    velocity = Input(3, "m/s", frame="lvlh", doc="q', deputy's velocity in the frame")
    desired_position = Input(3, "m", frame="lvlh", doc="q_d")
    desired_velocity = Input(3, "m/s", frame="lvlh", optional=True, doc="rate of q_d")
    orbit_rate = Input((), "rad/s", doc="ω, chief's orbit rate")
    gravity_gradient = Input((), "1/s2", doc="k, the planet's μ by the cube of chief's radius")
    position_error = Output((), "m", doc="|e|")
    velocity_error = Output((), "m/s", doc="|e'|")
    potential = Output((), "m2/s2", doc="U")
    lyapunov = Output((), "m2/s2", doc="V")
    lyapunov_rate = Output((), "m2/s3", doc="V' by its formula")
    position_gain = Parameter(3, "1/s2", 1e-4, min=0.0, frame="lvlh", doc="diagonal of Kp")
    velocity_gain = Parameter(3, "1/s", 0.1, min=0.0, frame="lvlh", doc="diagonal of Kd")
    with_potential = Parameter((), "1", 0.0, type="boolean", doc="V of (13) instead of (17)")

    def outputs(self, position, velocity, desired_position, desired_velocity, orbit_rate,
                gravity_gradient, position_gain, velocity_gain, with_potential):
        e, e_rate = position - desired_position, velocity - desired_velocity
        U = potential(position, orbit_rate, gravity_gradient)                           # (8)
        V = 0.5 * (e_rate @ e_rate + e @ (position_gain * e))                          # (17)
        return {
            "position_error": np.linalg.norm(e),
            "velocity_error": np.linalg.norm(e_rate),
            "potential": U,
            "lyapunov": V + np.where(with_potential > 0.5, U, 0.0),                    # (13)
            "lyapunov_rate": -e_rate @ (velocity_gain * e_rate),                 # (15), (18)
        }

    def requirements(self, position_gain, velocity_gain):
        return {
            "gains must be finite":
                np.maximum(np.max(position_gain), np.max(velocity_gain)) < np.inf,
        }
