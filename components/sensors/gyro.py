"""Gyro: the angular velocity of the spacecraft that carries it."""

from ..declarations import Input, Output
from .sensor import Channel, Sensor


class Gyro(Sensor, channels=[Channel("measured_angular_velocity", frame="body")]):
    """Angular velocity of the spacecraft against inertial space, in its body frame.

    measured = R(misalignment) (1 + scale_factor) Ω + bias + drift + noise

    ``noise_density`` is the angle random walk, ``walk_density`` the rate random walk,
    ``drift_deviation`` the bias instability.

    Source: coupled LOS attitude and position control paper, table 1; IEEE Std 952.
    """

    angular_velocity = Input(3, "rad/s", frame="body", doc="true angular velocity")
    measured_angular_velocity = Output(3, "rad/s", frame="body", doc="measured angular velocity")

    def truth(self, angular_velocity):
        return {"measured_angular_velocity": angular_velocity}
