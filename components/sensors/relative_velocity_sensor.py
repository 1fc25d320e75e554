"""Relative velocity sensor: the velocity of another spacecraft against one's own."""

from ..component import Component
from ..declarations import Input, Noise, Output, Parameter, SamplePeriod
from ..maths import IDENTITY, is_unit, rotate_inverse
from .measurement import measurement_error, noise_requirement


class RelativeVelocitySensor(Component):
    """Inertial velocity of another spacecraft against the observer's, in the observer's body frame.

    v_ij = R_i^T (v_j - v_i)                                                            (13)

    measured = v_ij + bias + noise. This is the difference of two inertial velocities, not the
    rate of the relative position in the turning body frame.

    Source: coupled LOS attitude and position control paper, eq. (13).
    """

    velocity = Input(3, "m/s", frame="inertial", doc="observer's velocity")
    target_velocity = Input(3, "m/s", frame="inertial", doc="observed velocity")
    attitude = Input(4, "1", IDENTITY, doc="observer's attitude, body to inertial, scalar last")
    relative_velocity = Output(3, "m/s", frame="body", doc="target's velocity minus observer's")
    bias = Parameter(3, "m/s", frame="body", doc="constant error")
    noise_density = Parameter((), "m/s/sqrt(Hz)", min=0.0,
                              doc="amplitude spectral density of the white noise on each axis")
    noise = Noise(3, doc="white noise of the three axes")
    sample_period = SamplePeriod()

    def outputs(self, velocity, target_velocity, attitude, bias, noise_density, noise,
                sample_period):
        v12 = rotate_inverse(attitude, target_velocity - velocity)                     # (13)
        error = measurement_error(bias, noise_density, noise, sample_period)
        return {"relative_velocity": v12 + error}

    def requirements(self, attitude, noise_density, sample_period):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            **noise_requirement(noise_density, sample_period),
        }
