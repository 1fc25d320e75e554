"""Spacecraft in six degrees of freedom in the three-body problem, relative to a leader."""

import numpy as np

from ..declarations import Input, Output, Parameter, State
from ..maths import IDENTITY, is_unit, quaternion_rate, rotate, unit
from .rigid_rotation import angular_acceleration, inertia_requirements
from .three_body_environment import L2, MEAN_MOTION, Primaries, _ThreeBodyEnvironment


class RelativeThreeBodyCraft(_ThreeBodyEnvironment):
    """Follower by its position and velocity relative to a leader, and its attitude.

    x'' = Σ (μ_j/|d_j + x|³) (f(q_j) d_j - x) + Δf_srp + R f/m - a_L                     (3)
    f(q) = q (3 + 3 q + q²)/(1 + (1 + q)^(3/2)),   q_j = x·(2 d_j + x)/|d_j|²
    H ω' = H ω × ω + τ,   R' = R S(ω)                                               (6), (7)

    with d_j from primary j to the leader and the leader's control acceleration a_L. One ulp of an
    absolute position is 31 µm here: the relative state is integrated, and gravity differences
    are formed without cancellation, so that micrometres are kept.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (2)-(7).
    """

    default_solver_step = 1.0  # s

    leader_position = Input(3, "m", (L2, 0.0, 0.0), frame="inertial", doc="from the barycentre")
    leader_velocity = Input(3, "m/s", (0.0, L2 * MEAN_MOTION, 0.0), frame="inertial",
                            doc="leader's velocity")
    leader_control_acceleration = Input(3, "m/s2", frame="inertial", optional=True,
                                        doc="leader's acceleration by its own thrust")
    force = Input(3, "N", frame="body", doc="control force")
    torque = Input(3, "N.m", frame="body", doc="control torque about the centre of mass")
    position = Output(3, "m", frame="inertial", doc="centre of mass from the barycentre")
    velocity = Output(3, "m/s", frame="inertial", doc="velocity")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    light_area = Parameter((), "m2", 0.0, min=0.0, doc="C_r A, reflectivity times area")
    leader_mass = Parameter((), "kg", 1.0, min=1e-9, doc="leader's mass")
    leader_light_area = Parameter((), "m2", 0.0, min=0.0, doc="leader's C_r A")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="H, inertia matrix")
    relative_position = State(3, "m", frame="inertial", output=True, doc="x, from the leader")
    relative_velocity = State(3, "m/s", frame="inertial", output=True,
                              doc="velocity less the leader's")
    attitude = State(4, "1", IDENTITY, frame="body", output=True,
                     doc="attitude, body to inertial, scalar last")
    angular_velocity = State(3, "rad/s", frame="body", output=True, doc="angular velocity")

    def derivatives(self, time, leader_position, leader_control_acceleration, force, torque,
                    relative_position, relative_velocity, attitude, angular_velocity, mass,
                    light_area, leader_mass, leader_light_area, inertia,
                    first_gravitational_parameter, second_gravitational_parameter, separation,
                    light_pressure):
        primaries = Primaries(first_gravitational_parameter, second_gravitational_parameter,
                              separation, light_pressure)
        natural = primaries.difference(time, leader_position, leader_light_area / leader_mass,
                                       relative_position, light_area / mass)
        control = rotate(attitude, force) / mass - leader_control_acceleration
        return {
            "relative_position": relative_velocity,
            "relative_velocity": natural + control,                                      # (3)
            "attitude": quaternion_rate(attitude, angular_velocity),                     # (7)
            "angular_velocity": angular_acceleration(inertia, angular_velocity, torque),  # (6)
        }

    def outputs(self, leader_position, leader_velocity, relative_position, relative_velocity):
        return {
            "position": leader_position + relative_position,
            "velocity": leader_velocity + relative_velocity,
        }

    def project(self, attitude):
        return {"attitude": unit(attitude)}

    def requirements(self, attitude, inertia):
        return {
            **inertia_requirements(inertia),
            "attitude must be a unit quaternion": is_unit(attitude),
        }
