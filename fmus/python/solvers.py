"""Integration of continuous states inside a communication step: RK4 and Dormand-Prince 5(4).

The native runtime performs the same operations in the same order.
Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.1 and II.5.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from ...components.declarations import Array

Rate: TypeAlias = Callable[[float, Array], Array]
Project: TypeAlias = Callable[[float, Array], Array]

C = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)
SAFETY, SHRINK, GROW = 0.9, 0.2, 5.0


class StepUnderflow(Exception):
    """The adaptive step became too small to go on."""


def rk4(rate: Rate, project: Project, t: float, x: Array, h: float, step: float) -> Array:
    """States at t + h by equal Runge-Kutta steps no longer than ``step``."""
    count = max(1, math.ceil(h / step - 1e-9))
    dt = h / count
    for i in range(count):
        s = t + i * dt
        k1 = rate(s, x)
        k2 = rate(s + 0.5 * dt, x + 0.5 * dt * k1)
        k3 = rate(s + 0.5 * dt, x + 0.5 * dt * k2)
        k4 = rate(s + dt, x + dt * k3)
        x = project(s + dt, x + dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4))
    return x


def dormand_prince(
    rate: Rate, project: Project, t: float, x: Array, h: float,
    proposal: float, relative: float, absolute: float,
) -> tuple[Array, float]:  # fmt: skip
    """States at t + h, and the step size to try first in the next call.

    Raises StepUnderflow if the tolerances cannot be met.
    """
    end, rejected = t + h, False
    while t < end:
        cut = t + proposal >= end
        dt = end - t if cut else proposal
        if not dt > 1e-14 * max(abs(t), 1e-3) and not cut:
            raise StepUnderflow(f"step size {dt:.3g} s at {t:.9g} s")
        k: list[Array] = []
        new = x
        for c, row in zip(C, A, strict=True):
            new = x.copy()
            for a, slope in zip(row, k, strict=True):
                new = new + dt * a * slope
            k.append(rate(t + c * dt, new))
        error = sum((dt * e * slope for e, slope in zip(ERROR, k, strict=True)), np.zeros_like(x))
        scale = absolute + relative * np.maximum(np.abs(x), np.abs(new))
        norm = math.sqrt(float(np.sum((error / scale) ** 2)) / x.size)
        factor = GROW if norm == 0.0 else min(GROW, max(SHRINK, SAFETY * norm**-0.2))
        if norm <= 1.0:
            factor = min(factor, 1.0) if rejected else factor
            t = end if cut else t + dt
            x = project(t, new)
            proposal = max(proposal, dt * factor) if cut else dt * factor
            rejected = False
        else:
            proposal, rejected = dt * min(factor, 1.0), True
            if not math.isfinite(norm) or proposal < 1e-14 * max(abs(t), 1e-3):
                raise StepUnderflow(f"step size {proposal:.3g} s at {t:.9g} s")
    return x, proposal
