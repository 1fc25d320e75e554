"""Line-of-sight formation control without coupling: a plain baseline to swap in."""

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import cross, is_unit


class LineOfSightPdController(Component):
    """Two spacecraft face each other and keep a distance: a PD law on each, one per craft.

    τ1 = -kΩ Ω1 - k1 b21 × b12
    f1 = m (kv v12 + k2 (d - d0) b12), in the body frame

    Law A of the formation controller without the force that couples position to attitude; the
    same ports, so that one can stand in for the other.

    Source: coupled LOS attitude and position control paper, eqs. (23), (25), uncoupled.
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="own unit vector to target")
    target_line_of_sight = Input(3, "1", (-1.0, 0.0, 0.0), frame="target_body",
                                 doc="target's unit vector to own craft, received from it")
    range = Input((), "m", 1.0, doc="distance to the target")
    relative_velocity = Input(3, "m/s", frame="body", doc="target's velocity minus own")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    force = Output(3, "N", frame="body", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="own mass")
    rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ, damps the angular velocity")
    velocity_gain = Parameter((), "1/s", 0.025, min=0.0, doc="kv, damps the relative velocity")
    alignment_gain = Parameter((), "N.m", 0.05, min=0.0, doc="k1, turns towards the target")
    range_gain = Parameter((), "1/s2", 0.001, min=0.0, doc="k2, pulls to the desired range")
    desired_range = Parameter((), "m", 20.0, min=0.0, doc="d0, wanted distance")
    sample_period = SamplePeriod()

    def outputs(self, line_of_sight, target_line_of_sight, range, relative_velocity,
                angular_velocity, mass, rate_gain, velocity_gain, alignment_gain, range_gain,
                desired_range):
        turn = cross(target_line_of_sight, line_of_sight)
        pull = range_gain * (range - desired_range) * line_of_sight
        return {
            "torque": -rate_gain * angular_velocity - alignment_gain * turn,           # (23)
            "force": mass * (velocity_gain * relative_velocity + pull),                # (25)
        }

    def requirements(self, line_of_sight, target_line_of_sight):
        return {
            "line_of_sight must be a unit vector": is_unit(line_of_sight),
            "target_line_of_sight must be a unit vector": is_unit(target_line_of_sight),
        }
