"""Gyro: the angular velocity of the spacecraft that carries it."""

from ..component import Component
from ..declarations import Input, Noise, Output, Parameter, SamplePeriod
from .measurement import measurement_error, noise_requirement


class Gyro(Component):
    """Angular velocity of the spacecraft against inertial space, in its body frame.

    measured = Ω + bias + noise

    Source: coupled LOS attitude and position control paper, table 1.
    """

    angular_velocity = Input(3, "rad/s", frame="body", doc="true angular velocity")
    measured_angular_velocity = Output(3, "rad/s", frame="body", doc="measured angular velocity")
    bias = Parameter(3, "rad/s", frame="body", doc="constant error")
    noise_density = Parameter((), "rad/s/sqrt(Hz)", min=0.0,
                              doc="amplitude spectral density of the white noise on each axis "
                                  "(angle random walk)")
    noise = Noise(3, doc="white noise of the three axes")
    sample_period = SamplePeriod()

    def outputs(self, angular_velocity, bias, noise_density, noise, sample_period):
        error = measurement_error(bias, noise_density, noise, sample_period)
        return {"measured_angular_velocity": angular_velocity + error}

    def requirements(self, noise_density, sample_period):
        return noise_requirement(noise_density, sample_period)
