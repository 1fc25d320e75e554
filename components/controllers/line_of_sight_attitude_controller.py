"""Relative attitude control from lines of sight to the other craft and to a common object."""

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import cross
from .lines_of_sight import lines_of_sight_requirement, plane_normal


class LineOfSightAttitudeController(Component):
    """Comparison law: full relative attitude of two spacecraft that stay where they are.

    τ1 = -kΩ Ω1 - k1 b21 × b12 - kθ b213 × b123                                         (53)
    b123 = b12 × b13 / |b12 × b13|,   b213 = b21 × b23 / |b21 × b23|                    (55)

    The second spacecraft uses the same with 1 and 2 exchanged (54). Object 3 is any point that
    both see and that is not on the line through them.

    Source: coupled LOS attitude and position control paper, eqs. (53)-(55).
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="own unit vector to target")
    target_line_of_sight = Input(3, "1", (-1.0, 0.0, 0.0), frame="target_body",
                                 doc="target's unit vector to own craft, received from it")
    object_line_of_sight = Input(3, "1", (0.0, 1.0, 0.0), frame="body",
                                 doc="own unit vector to the common object")
    target_object_line_of_sight = Input(3, "1", (0.0, 1.0, 0.0), frame="target_body",
                                        doc="target's unit vector to the common object")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    rate_gain = Parameter((), "N.m.s/rad", 0.25, min=0.0, doc="kΩ, damps the angular velocity")
    alignment_gain = Parameter((), "N.m", 0.05, min=0.0, doc="k1, turns towards the target")
    normal_gain = Parameter((), "N.m", 0.08, min=0.0, doc="kθ, aligns the planes' normals")
    sample_period = SamplePeriod()

    def outputs(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                target_object_line_of_sight, angular_velocity, rate_gain, alignment_gain,
                normal_gain):
        b12, b21 = line_of_sight, target_line_of_sight
        b123 = plane_normal(b12, object_line_of_sight)                                 # (55)
        b213 = plane_normal(b21, target_object_line_of_sight)                          # (55)
        alignment = alignment_gain * cross(b21, b12)
        return {
            "torque": -rate_gain * angular_velocity - alignment
                      - normal_gain * cross(b213, b123),                               # (53)
        }

    def requirements(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                     target_object_line_of_sight):
        return lines_of_sight_requirement(
            line_of_sight=line_of_sight, object_line_of_sight=object_line_of_sight,
            target_line_of_sight=target_line_of_sight,
            target_object_line_of_sight=target_object_line_of_sight,
        )
