"""Range sensor: the distance to another spacecraft."""

import numpy as np

from ..component import Component
from ..declarations import Input, Noise, Output, Parameter, SamplePeriod
from .measurement import measurement_error, noise_requirement


class RangeSensor(Component):
    """Distance between the centres of mass of the observer and another spacecraft.

    d = |r_j - r_i|                                                                     (14)

    measured = d + bias + noise.

    Source: coupled LOS attitude and position control paper, eq. (14).
    """

    position = Input(3, "m", frame="inertial", doc="observer's centre of mass")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="observed centre of mass")
    range = Output((), "m", doc="distance to the target")
    bias = Parameter((), "m", doc="constant error")
    noise_density = Parameter((), "m/sqrt(Hz)", min=0.0,
                              doc="amplitude spectral density of the white noise")
    noise = Noise((), doc="white noise")
    sample_period = SamplePeriod()

    def outputs(self, position, target_position, bias, noise_density, noise, sample_period):
        d = np.linalg.norm(target_position - position)                                 # (14)
        return {"range": d + measurement_error(bias, noise_density, noise, sample_period)}

    def requirements(self, noise_density, sample_period):
        return noise_requirement(noise_density, sample_period)
