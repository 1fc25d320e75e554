"""How a manoeuvre passes from 0 to 1, with its rates.

Linear:  s = τ
Quintic: s = 10 τ³ - 15 τ⁴ + 6 τ⁵, at rest and without acceleration at both ends

with τ = (t - t0)/T, held at 0 before the start and at 1 after the end. The linear profile jumps
in velocity at both ends; its acceleration there is left out.
"""

from __future__ import annotations

import numpy as np

from ..declarations import Parameter, Scalar


def progress(time: Scalar, start_time: Scalar, duration: Scalar, linear: Scalar,
             hold_time: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """s, its rate and its acceleration; ``linear`` > 0.5 chooses the linear profile.

    The acceleration is the mean over the ``hold_time`` to come, in which whoever uses it holds it:
    held as it is at the start, it would come late by half of that time.
    """
    passed = (time - start_time) / duration
    later = passed + hold_time / duration
    τ, straight = np.clip(passed, 0.0, 1.0), linear > 0.5
    moving = np.where(passed < 0.0, 0.0, np.where(passed < 1.0, 1.0, 0.0))
    held = hold_time > 0.0
    mean = (_quintic_rate(later) - _quintic_rate(passed)) / np.where(held, hold_time, 1.0)
    instant = 60.0 * τ * (1.0 - τ) * (1.0 - 2.0 * τ) / duration
    return (
        np.where(straight, τ, τ**3 * (10.0 - τ * (15.0 - 6.0 * τ))),
        np.where(straight, moving, _quintic_rate(passed)) / duration,
        np.where(straight, 0.0, np.where(held, mean, instant)) / duration,
    )


def _quintic_rate(passed: Scalar) -> Scalar:
    τ = np.clip(passed, 0.0, 1.0)
    return 30.0 * τ**2 * (1.0 - τ) ** 2


def start_time_parameter() -> Parameter:
    """When the manoeuvre starts."""
    return Parameter((), "s", 0.0, doc="when the manoeuvre starts")


def duration_parameter(doc: str) -> Parameter:
    """How long a manoeuvre takes."""
    return Parameter((), "s", 3600.0, min=1e-9, doc=doc)


def linear_parameter() -> Parameter:
    """Which profile."""
    return Parameter((), "1", 0.0, type="boolean", doc="linear profile instead of the quintic one")


def hold_time_parameter() -> Parameter:
    """How long a step holds the acceleration."""
    return Parameter((), "s", 0.0, min=0.0,
                     doc="for which whoever receives the acceleration holds it; 0: not at all")
