"""Attitude consensus of n spacecraft by virtual springs and dampers between neighbours."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, SamplePeriod, Structure
from ..maths import IDENTITY, cross, is_unit, rotate, rotate_inverse

INSTANT = 1e-9  # s, tolerance of the comparison of times


class AttitudeConsensusController(Component):
    """Turns a spacecraft and its neighbours to one attitude and one angular velocity.

    u_i = -w Σ_j [ks (η̄_j η̂_i - η̄_i η̂_j - η̂_j × η̂_i) + kd (ω_i - C_i C_j^T ω_j)]    (6), (7)

    over the neighbours j of i; w = 1/|N_i|, as in the paper, or 1 with `per_edge`. Before
    `switch_time`, and throughout with spring_gain = 0, the damping only acts                 (25).
    The paper's Euler parameters [η̂, η̄] are the four numbers of the attitude ports, its C turns
    inertial to body. Their sign matters: q and -q are one attitude but not one spring torque. As
    in the paper the sign is taken as it comes; with `nearer_sign` the neighbour's is chosen so
    that the spring pulls the short way round.

    Source: attitude consensus paper, eqs. (6), (7), (25).
    """

    neighbours = Structure(1, doc="number of neighbours")
    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="own attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", doc="own angular velocity")
    neighbour_attitudes = Input(("neighbours", 4), "1", lambda neighbours: [IDENTITY] * neighbours,
                                frame="neighbour_body", doc="a neighbour's attitude in each row")
    neighbour_angular_velocities = Input(("neighbours", 3), "rad/s", frame="neighbour_body",
                                         doc="a neighbour's angular velocity in each row, in its "
                                             "own body frame")
    torque = Output(3, "N.m", frame="body", doc="control torque")
    spring_gain = Parameter((), "N.m", 1.0, min=0.0, doc="ks, 1 in the paper; 0: law (25)")
    damping_gain = Parameter((), "N.m.s/rad", 1.0, min=0.0, doc="kd, 1 in the paper")
    switch_time = Parameter((), "s", 0.0, doc="t_s, before it law (25), from it on law (6)")
    per_edge = Parameter((), "1", type="boolean", doc="weight 1 per edge; else neighbour average")
    nearer_sign = Parameter((), "1", type="boolean", doc="spring acts the short way round")
    sample_period = SamplePeriod()

    def outputs(self, attitude, angular_velocity, neighbour_attitudes,
                neighbour_angular_velocities, spring_gain, damping_gain, switch_time, per_edge,
                nearer_sign, neighbours, time):
        η, ω = attitude, angular_velocity
        weight = np.where(per_edge > 0.5, 1.0, 1.0 / neighbours)
        opposite = np.logical_and(neighbour_attitudes @ η < 0.0, nearer_sign > 0.5)
        ηj = np.where(opposite, -1.0, 1.0) @ neighbour_attitudes  # (7) is linear in η_j
        spring = ηj[3] * η[:3] - η[3] * ηj[:3] - cross(ηj[:3], η[:3])                   # (7)
        others = rotate(neighbour_attitudes.T, neighbour_angular_velocities.T)
        damping = neighbours * ω - rotate_inverse(η, np.sum(others, axis=1))
        switched = np.where(time >= switch_time - INSTANT, spring_gain, 0.0)           # (25)
        return {"torque": -weight * (switched * spring + damping_gain * damping)}       # (6)

    def requirements(self, attitude, neighbour_attitudes):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            "each row of neighbour_attitudes must be a unit quaternion":
                np.min(np.stack([is_unit(row) for row in neighbour_attitudes])) > 0.5,
        }
