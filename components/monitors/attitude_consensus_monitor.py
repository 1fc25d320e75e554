"""Energy, angular momentum and disagreement of spacecraft in attitude consensus."""

import numpy as np

from ..component import Component
from ..declarations import Array, Input, Output, Parameter, Structure
from ..maths import IDENTITY, rotate

SMOOTH = 1e-200  # gives the angle a derivative at 0


def complete_graph(craft: int) -> Array:
    """Adjacency of the graph in which each is a neighbour of all others."""
    return 1.0 - np.eye(craft)


class AttitudeConsensusMonitor(Component):
    """Lyapunov function, conserved momentum and largest relative angle on any undirected graph.

    H  = Σ_i (1/w_i) ½ ω_i·I_bω_i + ks Σ_edges |η_i - η_j|²                     (15) corrected
    H' = -kd Σ_edges |C_i^Tω_i - C_j^Tω_j|²                                      (16) corrected
    L  = Σ_i (1/w_i) C_i^T I_b ω_i

    with 1/w_i = |N_i|, or 1 with `per_edge`. L stays; the plain sum (14) stays on regular graphs
    and with `per_edge` only. With `nearer_sign`, |η_i - η_j| is that of the nearer sign.

    Source: attitude consensus paper, eqs. (14)-(16); the printed (15), (16) miss factors.
    """

    craft = Structure(2, min=2, doc="number of spacecraft")
    attitudes = Input(("craft", 4), "1", lambda craft: [IDENTITY] * craft, frame="body",
                      doc="a craft's attitude in each row, body to inertial, scalar last")
    angular_velocities = Input(("craft", 3), "rad/s", frame="body",
                               doc="a craft's angular velocity in each row, in its body frame")
    energy = Output((), "J", doc="H")
    energy_rate = Output((), "W", doc="H' by its formula under law (6)")
    angular_momentum = Output(3, "N.m.s", frame="inertial", doc="Σ C_i^T I_b ω_i (14)")
    weighted_momentum = Output(3, "N.m.s", frame="inertial", doc="L, conserved on any graph")
    relative_angle = Output((), "rad", doc="largest angle between neighbours")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="I_b, of every craft")
    adjacency = Parameter(("craft", "craft"), "1", complete_graph, min=0.0, max=1.0,
                          doc="1 where two craft are neighbours, symmetric")
    spring_gain = Parameter((), "N.m", 1.0, min=0.0, doc="ks")
    damping_gain = Parameter((), "N.m.s/rad", 1.0, min=0.0, doc="kd")
    per_edge = Parameter((), "1", type="boolean", doc="weight 1 per edge; else neighbour average")
    nearer_sign = Parameter((), "1", type="boolean", doc="spring acts the short way round")

    def outputs(self, attitudes, angular_velocities, inertia, adjacency, spring_gain,
                damping_gain, per_edge, nearer_sign, craft):
        ω = rotate(attitudes.T, angular_velocities.T).T  # C_i^T ω_i
        momenta = rotate(attitudes.T, inertia @ angular_velocities.T)
        share = np.where(per_edge > 0.5, 1.0, np.sum(adjacency, axis=1))
        kinetic = 0.5 * np.sum(angular_velocities * (angular_velocities @ inertia), axis=1)
        spring, damping, chord = np.zeros(()), np.zeros(()), np.zeros(())
        for i in range(1, craft):  # each edge once
            edge, others = adjacency[i, :i], attitudes[:i]
            sign = np.where(others @ attitudes[i] < 0.0, -1.0, 1.0)
            as_paper = np.sum((others - attitudes[i]) ** 2, axis=1)
            nearer = np.sum((others - np.outer(sign, attitudes[i])) ** 2, axis=1)
            spring = spring + edge @ np.where(nearer_sign > 0.5, nearer, as_paper)
            damping = damping + edge @ np.sum((ω[:i] - ω[i]) ** 2, axis=1)
            chord = np.maximum(chord, np.max(edge * nearer))
        return {
            "energy": share @ kinetic + spring_gain * spring,                           # (15)
            "energy_rate": -damping_gain * damping,                                     # (16)
            "angular_momentum": np.sum(momenta, axis=1),                                # (14)
            "weighted_momentum": momenta @ share,
            "relative_angle": 4.0 * np.arcsin(np.minimum(0.5 * np.sqrt(chord + SMOOTH), 1.0)),
        }

    def requirements(self, adjacency):
        return {"adjacency must be symmetric": np.max(np.abs(adjacency - adjacency.T)) <= 0.0}
