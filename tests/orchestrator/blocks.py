"""Small blocks with known answers, built as user files by the tests that run."""

from __future__ import annotations

import numpy as np

from sightline.components import Component, Input, Output, Parameter, State


class Integrator(Component):
    """x' = u"""

    u = Input((), "m/s", doc="rate")
    x = State((), "m", output=True, doc="integral")

    def derivatives(self, u):
        return {"x": u}


class Gain(Component):
    """y = k x, at once"""

    x = Input((), "m", 1.0, doc="input")
    k = Parameter((), "1/s", -1.0, doc="gain")
    limit = Parameter((), "m", 1e9, doc="fails beyond")
    y = Output((), "m/s", doc="output")

    def outputs(self, x, k):
        return {"y": k * x}

    def requirements(self, x, limit):
        return {"x must stay below the limit": np.abs(x) < limit}


class Clock(Component):
    """Puts out the time of the communication points."""

    t = Output((), "s", doc="time")

    def outputs(self, time):
        return {"t": time * 1.0}


class Switch(Component):
    """Counts whole seconds, says whether two have passed, and passes both on."""

    count_in = Input((), "1", type="integer", doc="count of another")
    on_in = Input((), "1", type="boolean", doc="switch of another")
    count = Output((), "1", type="integer", doc="whole seconds")
    on = Output((), "1", type="boolean", doc="two seconds have passed")
    echo = Output((), "1", doc="100 times the switch plus the count of another")

    def outputs(self, time, count_in, on_in):
        count = np.floor(time + 1e-9)
        return {"count": count, "on": count >= 2, "echo": 100.0 * on_in + count_in}


class Follow(Component):
    """y = other - x"""

    x = Input((), "m", doc="own")
    other = Input((), "m", doc="that of another")
    y = Output((), "m/s", doc="rate")

    def outputs(self, x, other):
        return {"y": other - x}
