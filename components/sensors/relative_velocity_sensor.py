"""Relative velocity sensor: the velocity of another spacecraft against one's own."""

from ..declarations import Input, Output
from ..maths import IDENTITY, is_unit, rotate_inverse
from .sensor import Channel, Sensor


class RelativeVelocitySensor(Sensor, channels=[Channel("relative_velocity", frame="body")]):
    """Inertial velocity of another spacecraft against the observer's, in the observer's body frame.

    v_ij = R_i^T (v_j - v_i)                                                            (13)

    measured = R(misalignment) (1 + scale_factor) v_ij + bias + drift + noise. This is the
    difference of two inertial velocities, not the rate of the relative position in the turning
    body frame.

    Source: coupled LOS attitude and position control paper, eq. (13).
    """

    velocity = Input(3, "m/s", frame="inertial", doc="observer's velocity")
    target_velocity = Input(3, "m/s", frame="inertial", doc="observed velocity")
    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="observer's attitude, body to inertial, scalar last")
    relative_velocity = Output(3, "m/s", frame="body", doc="target's velocity minus observer's")

    def truth(self, velocity, target_velocity, attitude):
        return {"relative_velocity": rotate_inverse(attitude, target_velocity - velocity)}  # (13)

    def requirements(self, attitude):
        return {"attitude must be a unit quaternion": is_unit(attitude)}
