"""Reaction wheel allocation: from a wanted torque on the body to motor torques."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, Structure
from ..dynamics.rigid_body_with_wheels import axes_requirement, default_axes
from ..maths import leading_minors

INDEPENDENT = 1e-9  # least determinant of A^T A


class WheelAllocation(Component):
    """Shares a wanted torque among reaction wheels with the least sum of squares.

    u = -A (A^T A)^-1 τ,   so that the body gets -A^T u = τ

    The rows of A are the wheels' axes. A motor turns its wheel one way and the body the other,
    hence the sign.

    Source: F. Markley, J. Crassidis, Fundamentals of Spacecraft Attitude Determination and Control
    (2014), section on redundant wheel configurations (pseudo-inverse distribution).
    """

    wheels = Structure(3, min=3, doc="number of wheels")
    torque = Input(3, "N.m", frame="body", doc="wanted torque on the body")
    wheel_torque = Output("wheels", "N.m", doc="motor torque on each wheel")
    wheel_axes = Parameter(("wheels", 3), "1", default_axes, frame="body", doc="a_k in each row")

    def outputs(self, torque, wheel_axes):
        A = wheel_axes
        return {"wheel_torque": -A @ np.linalg.solve(A.T @ A, torque)}

    def requirements(self, wheel_axes):
        spread = leading_minors(wheel_axes.T @ wheel_axes)[2]
        return {
            **axes_requirement(wheel_axes),
            "wheel_axes must give torque about all axes (for other than 3 or 4 wheels, give them)":
                spread > INDEPENDENT,
        }
