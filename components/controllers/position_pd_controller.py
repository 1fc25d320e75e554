"""Position control by position and velocity errors: the neutral baseline."""

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import IDENTITY, is_unit, rotate_inverse


class PositionPdController(Component):
    """Brings a spacecraft to a wanted position and velocity; the force comes out in its body frame.

    f = R^T m (a_d - kp (r - r_d) - kd (v - v_d))

    Source: B. Wie, Space Vehicle Dynamics and Control, ch. 2 (proportional-derivative control).
    """

    position = Input(3, "m", frame="inertial", doc="own centre of mass")
    velocity = Input(3, "m/s", frame="inertial", doc="own velocity")
    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="own attitude, body to inertial, scalar last")
    desired_position = Input(3, "m", frame="inertial", doc="r_d")
    desired_velocity = Input(3, "m/s", frame="inertial", optional=True, doc="v_d")
    desired_acceleration = Input(3, "m/s2", frame="inertial", optional=True, doc="a_d")
    force = Output(3, "N", frame="body", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="own mass")
    position_gain = Parameter((), "1/s2", 0.01, min=0.0, doc="kp")
    velocity_gain = Parameter((), "1/s", 0.2, min=0.0, doc="kd")
    sample_period = SamplePeriod()

    def outputs(self, position, velocity, attitude, desired_position, desired_velocity,
                desired_acceleration, mass, position_gain, velocity_gain):
        spring = position_gain * (position - desired_position)
        damping = velocity_gain * (velocity - desired_velocity)
        return {"force": rotate_inverse(attitude, mass * (desired_acceleration - spring - damping))}

    def requirements(self, attitude):
        return {"attitude must be a unit quaternion": is_unit(attitude)}
