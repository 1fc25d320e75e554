"""Random values that a block's variables may take."""

from __future__ import annotations

from typing import Any

import numpy as np

from sightline.fmus.model import Model, Variable
from sightline.fmus.python.runtime import InstanceError

Values = dict[str, np.ndarray]


def random_value(rng: np.random.Generator, variable: Variable) -> np.ndarray:
    """Near the start value; unit vectors and symmetric matrices stay such, limits are kept."""
    start = np.asarray(variable.start, dtype=float)
    if variable.type == "boolean":
        return rng.integers(0, 2, variable.shape).astype(float)
    if variable.type == "integer":
        low, high = variable.min or 0, variable.max if variable.max is not None else 9
        return rng.integers(int(low), int(high) + 1, variable.shape).astype(float)
    if variable.shape and variable.shape[-1] in (3, 4):
        norms = np.linalg.norm(start, axis=-1, keepdims=True)
        if np.allclose(norms, 1.0):
            vector = start + 0.5 * rng.standard_normal(variable.shape)
            return vector / np.linalg.norm(vector, axis=-1, keepdims=True)
    scale = np.where(start == 0.0, 0.1, 0.05 * np.abs(start))
    noise = rng.standard_normal(variable.shape)
    if len(variable.shape) == 2 and np.array_equal(start, start.T):
        noise = 0.3 * (noise + noise.T)  # an inertia or a covariance
    return np.clip(start + scale * noise,
                   variable.min, variable.max)  # fmt: skip


def random_values(rng: np.random.Generator, model: Model, *kinds: Any) -> Values:
    return {v.name: random_value(rng, v) for v in model.of_kind(*kinds)
            if v.name != "sample_period"}


def acceptable(native: Any, values: Values) -> bool:
    """Whether the block's requirements accept these start values."""
    reference = native.reference()
    for name, value in values.items():
        reference.set(list(native.model.by_name[name].references), np.ravel(value).tolist())
    try:
        reference.require()
    except InstanceError:
        return False
    return True
