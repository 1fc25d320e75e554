"""A controller of one's own as a Sightline block: becomes a native or a Python FMU."""

import numpy as np

from sightline.components import Component, Input, Output, Parameter


class OwnBlock(Component):
    """Law A of the line-of-sight paper.

    τ1 = -kΩ Ω1 - k1 b21 × b12
    f1 = m (kv v12 - k2 (d0 - d) b12 + (k1/d) (b21 - (b12·b21) b12))
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="b12")
    target_line_of_sight = Input(3, "1", (-1.0, 0.0, 0.0), frame="target_body", doc="b21")
    range = Input((), "m", 1.0, doc="d")
    relative_velocity = Input(3, "m/s", frame="body", doc="v12")
    angular_velocity = Input(3, "rad/s", frame="body", doc="Ω1")
    torque = Output(3, "N.m", frame="body", doc="τ1")
    force = Output(3, "N", frame="body", doc="f1")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="m")
    rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ")
    velocity_gain = Parameter((), "1/s", 0.025, min=0.0, doc="kv")
    alignment_gain = Parameter((), "N.m", 0.05, min=0.0, doc="k1")
    range_gain = Parameter((), "1/s2", 0.001, min=0.0, doc="k2")
    desired_range = Parameter((), "m", 20.0, min=0.0, doc="d0")

    def outputs(self, line_of_sight, target_line_of_sight, range, relative_velocity,
                angular_velocity, mass, rate_gain, velocity_gain, alignment_gain, range_gain,
                desired_range):
        b12, b21 = line_of_sight, target_line_of_sight
        pull = range_gain * (range - desired_range) * b12
        swing = alignment_gain / range * (b21 - (b12 @ b21) * b12)
        turn = alignment_gain * np.cross(b21, b12)
        return {
            "torque": -rate_gain * angular_velocity - turn,
            "force": mass * (velocity_gain * relative_velocity + pull + swing),
        }
