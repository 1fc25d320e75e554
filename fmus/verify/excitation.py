"""Inputs that move a little around their start values, and stay what the FMU accepts.

A vector whose start value has norm 1 (a direction, a quaternion) keeps it.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence

import numpy as np

from .subject import Array, Subject, Variable

AMPLITUDES = (0.1, 0.01, 1e-4, 0.0)


class Excitation:
    """A seeded course of all numeric inputs. ``at(k)`` gives their values for step k, flat."""

    def __init__(self, subject: Subject, amplitude: float, seed: int = 0) -> None:
        self.variables = subject.inputs
        self.amplitude = amplitude
        self.base = flat_start(self.variables)
        self._low, self._high = limits(self.variables)
        size = len(self.base)
        # keyed by name, so that FMUs of one model get the same whatever their order
        draws = np.array([_draws(f"{seed}:{n}") for v in self.variables for n in v.elements])
        self._phase, self._speed = (draws.reshape(size, 2) * (6.28, 0.5)).T
        real = np.repeat([v.real for v in self.variables], [v.size for v in self.variables])
        self._scale = np.where(real, _scales(self.variables), 0.0)
        self._unit = [p for p in ports(self.variables) if _unit_norm(self.base[p], real[p])]

    def at(self, k: int) -> Array:
        """Values of all inputs for step k."""
        moved = self._scale * np.sin(self._phase + (0.3 + self._speed) * k)
        values: Array = np.clip(self.base + self.amplitude * moved, self._low, self._high)
        for port in self._unit:
            values[port] /= np.linalg.norm(values[port])
        return values


def flat_start(variables: Sequence[Variable]) -> Array:
    """Start values of all scalars, zero where there is none."""
    parts = [np.zeros(v.size) if v.start is None else v.start for v in variables]
    return np.concatenate([*parts, np.zeros(0)])


def limits(variables: Sequence[Variable]) -> tuple[Array, Array]:
    """Smallest and largest legal values of all scalars."""
    sizes = [v.size for v in variables]
    return np.repeat([v.min for v in variables], sizes), np.repeat(
        [v.max for v in variables], sizes
    )


def ports(variables: Sequence[Variable]) -> list[list[int]]:
    """Positions of the scalars of each array."""
    groups: dict[str, list[int]] = {}
    at = 0
    for variable in variables:
        groups.setdefault(variable.port, []).extend(range(at, at + variable.size))
        at += variable.size
    return list(groups.values())


def _scales(variables: Sequence[Variable]) -> Array:
    scale = np.ones(sum(v.size for v in variables))
    starts = flat_start(variables)
    for port in ports(variables):
        scale[port] = np.max(np.abs(starts[port])) or 1.0
    return scale


def _unit_norm(start: Array, real: Array) -> bool:
    unit = abs(float(np.linalg.norm(start)) - 1.0) < 1e-9
    return unit and bool(np.all(real)) and len(start) in (3, 4)


def _draws(text: str) -> tuple[float, float]:
    seed = zlib.crc32(text.encode())
    first, second = np.random.default_rng(seed).random(2)
    return float(first), float(second)
