"""Relative attitude of two spacecraft from four lines of sight."""

import numpy as np

from ..component import Component
from ..controllers.lines_of_sight import lines_of_sight_requirement, plane_normal
from ..declarations import Input, Output, SamplePeriod
from ..maths import cross, from_matrix


class RelativeAttitudeDetermination(Component):
    """The only relative attitude Q = R2^T R1 that fits the four lines of sight.

    Q b12 = -b21                                                                         (7)
    Q (b12 × b13) / |b12 × b13| = -(b21 × b23) / |b21 × b23|                             (8)
    Q = [-b21, -n21, b21 × n21] [b12, n12, b12 × n12]^T,   n12, n21: the normals of (8)

    (7) and (8) hold for any measured directions; an error in the line of sight to the common
    object turns Q about the line between the craft only.

    Source: relative attitude control on SO(3) paper, section III, eqs. (7), (8).
    """

    line_of_sight = Input(3, "1", (1.0, 0.0, 0.0), frame="body", doc="own unit vector to target")
    target_line_of_sight = Input(3, "1", (-1.0, 0.0, 0.0), frame="target_body",
                                 doc="target's unit vector to own craft, received from it")
    object_line_of_sight = Input(3, "1", (0.0, 1.0, 0.0), frame="body",
                                 doc="own unit vector to the common object")
    target_object_line_of_sight = Input(3, "1", (0.0, 1.0, 0.0), frame="target_body",
                                        doc="target's unit vector to the common object")
    relative_attitude = Output(4, "1", doc="Q, from own body frame to the target's, scalar last")
    sample_period = SamplePeriod()

    def outputs(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                target_object_line_of_sight):
        b12, b21 = line_of_sight, target_line_of_sight
        n12 = plane_normal(b12, object_line_of_sight)
        n21 = plane_normal(b21, target_object_line_of_sight)
        own = np.stack([b12, n12, cross(b12, n12)])
        target = np.stack([-b21, -n21, cross(b21, n21)])                            # (7), (8)
        return {"relative_attitude": from_matrix(target.T @ own)}

    def requirements(self, line_of_sight, target_line_of_sight, object_line_of_sight,
                     target_object_line_of_sight):
        return lines_of_sight_requirement(
            line_of_sight=line_of_sight, object_line_of_sight=object_line_of_sight,
            target_line_of_sight=target_line_of_sight,
            target_object_line_of_sight=target_object_line_of_sight,
        )
