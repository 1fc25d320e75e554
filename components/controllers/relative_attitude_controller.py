"""Relative attitude control of two spacecraft on SO(3), from four lines of sight."""

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod
from ..maths import IDENTITY, cross, is_unit, rotate_inverse
from .lines_of_sight import lines_of_sight_requirement, plane_normal


class RelativeAttitudeController(Component):
    """Brings the relative attitude Q = R2^T R1 of two spacecraft to a wanted one, one per craft.

    u1 = -kΩ Ω1 - kα (Qd^T b21 × b12) - (kβ/c) (Qd^T (b21 × b23)) × (b12 × b13)         (19)
    c  = |b12 × b13| |b21 × b23|                                                        (15)

    The second spacecraft uses the same with 1 and 2 exchanged and Qd inverted (20). Neither
    attitude nor positions are needed; positions stay, and object 3 is any point that both see and
    that is not on the line through them. kα and kβ must differ.

    Source: relative attitude control on SO(3) paper, eqs. (15), (19), (20).
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
    desired_relative_attitude = Parameter(4, "1", IDENTITY,
                                          doc="Qd, from own body frame to the target's")
    rate_gain = Parameter((), "N.m.s/rad", 0.84, min=0.0, doc="kΩ, damps the angular velocity")
    alignment_gain = Parameter((), "N.m", 0.525, min=0.0, doc="kα, on the line between the craft")
    normal_gain = Parameter((), "N.m", 0.5775, min=0.0, doc="kβ, aligns the planes' normals")
    sample_period = SamplePeriod()

    def outputs(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                target_object_line_of_sight, angular_velocity, desired_relative_attitude,
                rate_gain, alignment_gain, normal_gain):
        Qd, b12, b21 = desired_relative_attitude, line_of_sight, target_line_of_sight
        n12 = plane_normal(b12, object_line_of_sight)                                  # (15)
        n21 = plane_normal(b21, target_object_line_of_sight)                           # (15)
        alignment = cross(rotate_inverse(Qd, b21), b12)                                # (13)
        tilt = cross(rotate_inverse(Qd, n21), n12)                                     # (17)
        return {
            "torque": -rate_gain * angular_velocity
                      - alignment_gain * alignment - normal_gain * tilt,               # (19)
        }

    def requirements(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                     target_object_line_of_sight, desired_relative_attitude, alignment_gain,
                     normal_gain):
        return {
            **lines_of_sight_requirement(
                line_of_sight=line_of_sight, object_line_of_sight=object_line_of_sight,
                target_line_of_sight=target_line_of_sight,
                target_object_line_of_sight=target_object_line_of_sight,
            ),
            "desired_relative_attitude must be a unit quaternion":
                is_unit(desired_relative_attitude),
            "alignment_gain and normal_gain must differ": abs(alignment_gain - normal_gain) > 0.0,
        }
