"""Blocks that act at instants of their own, or feed through, for tests of the stepper."""

from __future__ import annotations

import numpy as np

from sightline.components import (
    Component,
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    SamplePeriod,
    State,
)


class NoisyHold(Component):
    """z = u + s n at multiples of the period, counted and held"""

    sample_period = SamplePeriod()
    u = Input((2,), "m", doc="input")
    s = Parameter((), "m", 0.01, doc="standard deviation")
    noise = Noise((2,))
    count = DiscreteState((), "1", output=True, doc="samples until now")
    z = Output((2,), "m", doc="sample")

    def outputs(self, u, s, noise):
        return {"z": u + s * noise}

    def update(self, count):
        return {"count": count + 1.0}


class Follower(Component):
    """x' = (u - x) / T"""

    u = Input((), "m", doc="goal")
    T = Parameter((), "s", 1.0, doc="time constant")
    x = State((), "m", output=True, doc="follows")

    def derivatives(self, u, T, x):
        return {"x": (u - x) / T}


class TimeIntegral(Component):
    """x' = u"""

    u = Input((), "s", doc="time")
    x = State((), "s2", output=True, doc="integral of time")

    def derivatives(self, u):
        return {"x": u}


class Affine(Component):
    """y = k u + c, at once"""

    u = Input((2,), "1", doc="input")
    k = Parameter((2, 2), "1", [[0.3, -0.5], [0.4, 0.2]], doc="gain")
    c = Parameter((2,), "1", [1.0, 2.0], doc="constant")
    y = Output((2,), "1", doc="output")

    def outputs(self, u, k, c):
        return {"y": k @ u + c}


class Cosine(Component):
    """y = a cos u, at once"""

    u = Input((), "1", doc="input")
    a = Parameter((), "1", 1.0, doc="amplitude")
    y = Output((), "1", doc="output")

    def outputs(self, u, a):
        return {"y": a * np.cos(u)}


class Crossed(Component):
    """y1 = t, y2 = 2 u1, at once; u2 acts on nothing"""

    u1 = Input((), "1", doc="input")
    u2 = Input((), "1", doc="idle input")
    y1 = Output((), "1", doc="time")
    y2 = Output((), "1", doc="twice the input")

    def outputs(self, time, u1):
        return {"y1": time * 1.0, "y2": 2.0 * u1}
