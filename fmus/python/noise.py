"""Noise that depends on seed, instance, channel and tick only: Philox 4x64-10, Box-Muller.

Step size, rollback and order of evaluation do not change the numbers; the native runtime makes
the same ones.
"""

from __future__ import annotations

import math

import numpy as np

from ...components.declarations import Array

FNV_OFFSET, FNV_PRIME = 0xCBF29CE484222325, 0x100000001B3
MASK = 0xFFFFFFFFFFFFFFFF


def fnv1a(text: str) -> int:
    """FNV-1a hash, 64 bit, of the text in UTF-8."""
    value = FNV_OFFSET
    for byte in text.encode():
        value = ((value ^ byte) * FNV_PRIME) & MASK
    return value


def normal_draws(seed: int, stream: int, tick: int, channel: int, size: int) -> Array:
    """``size`` independent draws from N(0, 1) for one tick of one channel."""
    draws: list[float] = []
    for block in range(-(-size // 4)):
        generator = np.random.Philox(
            key=np.array([seed, stream], dtype=np.uint64),  # a list would pass through float64
            counter=[tick, channel, block, 0],
        )
        words = [int(w) >> 11 for w in generator.random_raw(4)]
        for a, b in ((words[0], words[1]), (words[2], words[3])):
            radius = math.sqrt(-2.0 * math.log((a + 1) * 2.0**-53))
            angle = 2.0 * math.pi * (b * 2.0**-53)
            draws += [radius * math.cos(angle), radius * math.sin(angle)]
    return np.array(draws[:size])
