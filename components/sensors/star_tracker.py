"""Star tracker: the attitude of the spacecraft that carries it."""

import numpy as np

from ..declarations import Input, Output, Parameter
from ..maths import IDENTITY, is_unit
from .sensor import Channel, Sensor


class StarTracker(
    Sensor, channels=[Channel("measured_attitude", errors="attitude", frame="body")]
):
    """Attitude as a quaternion, turned by small errors about the body axes.

    measured = q [½ (bias + drift + noise), 1] / norm

    Above a turn rate stars smear and the last attitude stays.

    Source: J. Crassidis, J. Junkins, Optimal Estimation of Dynamic Systems, ch. 7.
    """

    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="true attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", optional=True, doc="true angular velocity")
    measured_attitude = Output(4, "1", IDENTITY, frame="body",
                               doc="measured attitude, body to inertial")
    maximum_rate = Parameter((), "rad/s", 1e6, min=0.0, doc="fastest turn that can be followed")

    def truth(self, attitude, angular_velocity, maximum_rate):
        steady = np.linalg.norm(angular_velocity) <= maximum_rate
        return {"measured_attitude": attitude, "valid": steady}

    def requirements(self, attitude):
        return {"attitude must be a unit quaternion": is_unit(attitude)}
