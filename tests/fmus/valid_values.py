"""Random values that a block accepts: near its start values, directions and attitudes of norm 1."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from sightline.components import Component, Input
from sightline.components.declarations import Array

UNIT_NORM = ("attitude", "attitudes", "line_of_sight")


def valid_inputs(block: Component, seed: int) -> dict[str, Array]:
    """Inputs by port name; the block's requirements hold for them."""
    rng = np.random.default_rng(seed)
    inputs = {}
    for name, port in block.of_type(Input).items():
        value = port.value + 0.1 * rng.random(port.dimensions)
        if name.endswith(UNIT_NORM):
            value /= np.linalg.norm(value, axis=-1, keepdims=True)
        inputs[name] = np.clip(value, port.min, port.max) if port.type == "real" else port.value
    return inputs


def by_scalar(values: Mapping[str, Array]) -> dict[str, float]:
    """FMI 2.0 names of all scalars."""
    return {
        f"{name}[{','.join(str(i + 1) for i in index)}]" if index else name: float(value[index])
        for name, value in values.items()
        for index in np.ndindex(value.shape)
    }
