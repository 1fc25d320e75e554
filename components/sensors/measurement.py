"""The measurement chain: what turns a true value into what a sensor says, error by error.

scale and misalignment    y = R(misalignment) (1 + scale_factor) x
biases and noise          y + bias + turn_on + drift + walk + (noise_density / sqrt(T)) n
saturation, quantisation  clip to ± limit, then round to a multiple of resolution
latency                   the value of so many samples ago
dropout                   the last value stays, and `valid` is false

n ~ N(0, 1), T = sample_period. drift is a Gauss-Markov process, walk a random walk:
drift' = φ drift + σ sqrt(1 - φ²) n, φ = exp(-T/τ);   walk' = walk + walk_density sqrt(T) n

Densities are amplitude spectral densities (two-sided, as the angle random walk of a gyro), so that
the meaning of a parameter file does not change with the sample period. A continuous sensor (T = 0)
has constant errors only: white noise of finite density has no value at an instant.

Source: IEEE Std 952, annex C (error model of a gyro); J. Crassidis, J. Junkins, Optimal Estimation
of Dynamic Systems, ch. 3 (discrete noise from spectral density).
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition, Scalar
from ..maths import small_rotation


def noise_sigma(noise_density: Scalar, sample_period: Scalar) -> Scalar:
    """Standard deviation of one sample; 0 for a continuous sensor."""
    sampled = sample_period > 0.0
    return np.where(sampled, noise_density / np.sqrt(np.where(sampled, sample_period, 1.0)), 0.0)


def scaled(value: Array, scale_factor: Array, misalignment: Array) -> Array:
    """A vector in the sensor's own axes and units."""
    return small_rotation(misalignment, (1.0 + scale_factor) * value)


def next_drift(drift: Array, deviation: Scalar, time_constant: Scalar, sample_period: Scalar,
               noise: Array) -> Array:
    """The Gauss-Markov bias one sample later; its deviation in the long run is ``deviation``."""
    φ = np.exp(-sample_period / time_constant)
    return φ * drift + deviation * np.sqrt(1.0 - φ * φ) * noise


def next_walk(walk: Array, density: Scalar, sample_period: Scalar, noise: Array) -> Array:
    """The random walk of the bias one sample later."""
    return walk + density * np.sqrt(sample_period) * noise


def limited(value: Array, limit: Scalar) -> Array:
    """Saturated at ± limit; 0: no limit."""
    return np.where(limit > 0.0, np.clip(value, -limit, limit), value)


def quantised(value: Array, resolution: Scalar) -> Array:
    """Rounded to a multiple of the resolution; 0: not."""
    step = np.where(resolution > 0.0, resolution, 1.0)
    return np.where(resolution > 0.0, step * np.round(value / step), value)


def drops_out(dropout: Scalar, noise: Array) -> Condition:
    """Whether a sample is lost, with the probability ``dropout``.

    exp(-½|n|²) of two independent normal draws is uniform between 0 and 1.
    """
    return np.exp(-0.5 * (noise @ noise)) < dropout


def in_view(direction: Array, distance: Scalar, boresight: Array, field_of_view: Scalar,
            minimum_range: Scalar, maximum_range: Scalar) -> Condition:
    """Whether a target is within the half angle about the boresight and at a range that works."""
    seen = direction @ boresight >= np.cos(field_of_view)
    return np.logical_and(seen, in_range(distance, minimum_range, maximum_range))


def in_range(distance: Scalar, minimum_range: Scalar | float,
             maximum_range: Scalar) -> Condition:
    """Whether a distance can be measured."""
    return np.logical_and(distance >= minimum_range, distance <= maximum_range)
