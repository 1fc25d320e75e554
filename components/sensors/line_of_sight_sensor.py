"""Line-of-sight sensor: the direction to another spacecraft."""

import numpy as np

from ..component import Component
from ..declarations import Input, Noise, Output, Parameter, SamplePeriod
from ..maths import IDENTITY, is_unit, rotate_inverse, small_rotation, unit
from .measurement import measurement_error, noise_requirement


class LineOfSightSensor(Component):
    """Direction from the observer to another spacecraft, seen in the observer's body frame.

    b_ij = R_i^T (r_j - r_i) / |r_j - r_i|                                              (12)

    Errors turn the direction by small angles about the body axes, so that its norm stays 1:
    measured = R(bias + noise) b_ij.

    Source: coupled LOS attitude and position control paper, eqs. (11), (12).
    """

    position = Input(3, "m", frame="inertial", doc="observer's centre of mass")
    target_position = Input(3, "m", (1.0, 0.0, 0.0), frame="inertial",
                            doc="observed centre of mass")
    attitude = Input(4, "1", IDENTITY, doc="observer's attitude, body to inertial, scalar last")
    line_of_sight = Output(3, "1", frame="body", doc="unit vector to the target")
    bias = Parameter(3, "rad", frame="body", doc="constant rotation of the measured direction")
    noise_density = Parameter((), "rad/sqrt(Hz)", min=0.0,
                              doc="amplitude spectral density of the white noise on each angle")
    noise = Noise(3, doc="white noise of the three angles")
    sample_period = SamplePeriod()

    def outputs(self, position, target_position, attitude, bias, noise_density, noise,
                sample_period):
        s12 = unit(target_position - position)                                         # (11)
        b12 = rotate_inverse(attitude, s12)                                            # (12)
        angles = measurement_error(bias, noise_density, noise, sample_period)
        return {"line_of_sight": small_rotation(angles, b12)}

    def requirements(self, position, target_position, attitude, noise_density, sample_period):
        return {
            "target_position must differ from position":
                np.linalg.norm(target_position - position) > 0.0,
            "attitude must be a unit quaternion": is_unit(attitude),
            **noise_requirement(noise_density, sample_period),
        }
