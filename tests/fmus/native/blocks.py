"""Blocks that only tests use: together they touch every feature of a block."""

from __future__ import annotations

from typing import NamedTuple

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
from sightline.components.declarations import Array
from sightline.components.loops import repeat


class Everything(Component):
    """Continuous and discrete states, noise, ticks, all value types, requirements."""

    force = Input(3, "N", frame="body", doc="input that feeds through")
    level = Input((), "m", 1.0, min=-10.0, max=10.0, doc="limited input")
    switch = Input((), "1", type="boolean", doc="boolean input")
    gain = Parameter((), "1/kg", 2.0, tunable=True, doc="tunable gain")
    order = Parameter((), "1", 3.0, type="integer", min=0, max=9, doc="integer parameter")
    matrix = Parameter((2, 3), "1", ((1.0, 2.0, 3.0), (4.0, 5.0, 6.0)), doc="matrix")
    ticks = DiscreteState((), "1", output=True, doc="ticks so far")
    memory = DiscreteState(3, "N", doc="the force of the tick before")
    speed = State(3, "m/s", 0.1, output=True, nominal=10.0, doc="integral of the input")
    phase = State(2, "1", (1.0, 0.0), doc="a turning unit vector")
    pull = Output(3, "N", frame="body", doc="input with noise, at ticks")
    mixed = Output(2, "1", doc="matrix times noisy force")
    noise = Noise(3, doc="white noise")
    jitter = Noise(6, doc="more white noise")
    sample_period = SamplePeriod(start=0.1)

    def derivatives(self, time, force, gain, speed, phase, level, memory):
        turn = (1.0 + level) * np.stack([-phase[1], phase[0]])
        rate = gain * force - 0.3 * speed * np.abs(speed) + np.sin(time) + 0.1 * memory
        return {"speed": rate, "phase": turn}

    def outputs(self, force, noise, level, speed, memory, matrix, jitter, switch, order):
        pull = force + noise + np.sqrt(level) * speed - memory
        mixed = matrix @ (force + jitter[:3]) + jitter[3] * jitter[4] - jitter[5]
        return {"pull": pull, "mixed": np.where(switch > 0.5, mixed, order * mixed)}

    def update(self, ticks, force, noise, time):
        return {"ticks": ticks + 1.0, "memory": force * np.cos(time) + noise}

    def project(self, phase):
        return {"phase": phase / np.linalg.norm(phase)}

    def requirements(self, level, speed):
        return {
            "speed must stay below 1000 m/s: 100 % of the limit":
                np.max(np.abs(speed)) < 1000.0,
            "level must not be 7": np.abs(level - 7.0) > 0.1,
        }


class Oscillator(Component):
    """A nonlinear oscillator x'' = -x - x³ + u whose reading is fed through from the input."""

    push = Input((), "m/s2", doc="acceleration")
    position = State((), "m", 1.0, output=True, doc="position")
    velocity = State((), "m/s", doc="velocity")
    energy = Output((), "m2/s2", doc="½ v² + ½ x² + ¼ x⁴ + u")

    def derivatives(self, push, position, velocity):
        return {"position": velocity, "velocity": push - position - position**3}

    def outputs(self, push, position, velocity):
        return {"energy": 0.5 * velocity**2 + 0.5 * position**2 + 0.25 * position**4 + push}


class Gain(Component):
    """No state at all: y = k u."""

    u = Input((), "1", doc="input")
    k = Parameter((), "1", 2.0, doc="gain")
    y = Output((), "1", doc="output")

    def outputs(self, u, k):
        return {"y": k * u}


class Branching(Component):
    """Cannot be traced: it branches on a value."""

    u = Input((), "1", doc="input")
    y = Output((), "1", doc="output")

    def outputs(self, u):
        if u > 0:
            return {"y": u}
        return {"y": -u}


class Orbit(NamedTuple):
    """What the loop of `Iterating` hands on."""

    x: Array
    count: Array


class Iterating(Component):
    """Newton's iteration for a root of each u, as a loop that native code keeps."""

    u = Input(3, "1", (2.0, 3.0, 5.0), min=0.1, doc="squares")
    k = Parameter((), "1", 1.0, min=0.1, doc="factor")
    root = Output(3, "1", doc="their roots times k")
    turns = Output((), "1", doc="number of iterations")

    def outputs(self, u, k):
        def step(given: tuple[Array, None, float], orbit: Orbit) -> Orbit:
            square, _, half = given
            return Orbit(half * (orbit.x + square / orbit.x), orbit.count + 1.0)

        orbit = repeat(step, 8, (u, None, 0.5), Orbit(np.ones(3), np.zeros(())))
        return {"root": k * orbit.x, "turns": orbit.count}
