"""Lines of sight of two craft to each other and to a common object, and the planes they span.

b12, b13 are the lines of sight of craft 1 to craft 2 and to the object 3, in its body frame; b21,
b23 those of craft 2. Both planes are the one through the two craft and the object.

Source: relative attitude control on SO(3) paper, section III, eqs. (7), (8).
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Condition
from ..maths import cross, is_unit, unit

PARALLEL = 1e-9  # sine of the angle between lines of sight below which they span no plane


def plane_normal(line_of_sight: Array, object_line_of_sight: Array) -> Array:
    """Unit normal b12 × b13 / |b12 × b13| of the plane through the craft and the object."""
    return unit(cross(line_of_sight, object_line_of_sight))


def lines_of_sight_requirement(**directions: Array) -> dict[str, Condition]:
    """The requirement that each has length 1 and each pair spans a plane.

    Received by name in pairs: the line of sight to the other craft, then that to the object.
    """
    names = list(directions)
    conditions = {f"{n} must be a unit vector": is_unit(b) for n, b in directions.items()}
    for other, common in zip(names[::2], names[1::2], strict=True):
        sine = np.linalg.norm(cross(directions[other], directions[common]))
        conditions[f"{common} must not be parallel to {other}"] = sine > PARALLEL
    return conditions
