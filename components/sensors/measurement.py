"""The first set of measurement errors, shared by all sensors: constant bias and white noise.

error_k = bias + (noise_density / sqrt(T)) n_k,   n_k ~ N(0, 1),   T = sample_period

``noise_density`` is the amplitude spectral density (two-sided, as the angle random walk of a
gyro), so that the meaning of a parameter file does not change with the sample period: averages
over a given time have the same variance at any T. A continuous sensor (T = 0) has no noise: white
noise of finite density has no value at an instant.
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition, Scalar


def noise_sigma(noise_density: Scalar, sample_period: Scalar) -> Scalar:
    """Standard deviation of one sample; 0 for a continuous sensor."""
    sampled = sample_period > 0.0
    return np.where(sampled, noise_density / np.sqrt(np.where(sampled, sample_period, 1.0)), 0.0)


def measurement_error(bias: Array, noise_density: Scalar, noise: Array,
                      sample_period: Scalar) -> Array:
    """What a sample adds to the true value."""
    return bias + noise_sigma(noise_density, sample_period) * noise


def noise_requirement(noise_density: Scalar, sample_period: Scalar) -> dict[str, Condition]:
    """The requirement that noise comes with ticks."""
    return {
        "noise_density must be 0 unless sample_period is positive":
            np.where(sample_period > 0.0, 0.0, noise_density) <= 0.0,
    }
