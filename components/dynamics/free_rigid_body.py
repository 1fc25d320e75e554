"""Free rigid body in six degrees of freedom: Euler's equations and a double integrator."""

import numpy as np

from ..component import Component
from ..declarations import Input, Parameter, State
from ..maths import IDENTITY, is_unit, quaternion_rate, rotate, unit
from .rigid_rotation import angular_acceleration, inertia_requirements


class FreeRigidBody(Component):
    """Spacecraft far from any mass, pushed and turned by a wrench about its centre of mass.

    R' = R S(Ω)                                                                          (3)
    J Ω' = J Ω × Ω + τ + τ_d                                                             (4)
    r' = v                                                                               (5)
    m v' = R f + f_d                                                                     (6)

    Force f and torque τ are given in the body frame, as thrusters produce them; the disturbance
    force f_d in the inertial frame, the disturbance torque τ_d in the body frame.

    Source: coupled LOS attitude and position control paper, eqs. (3)-(6).
    """

    force = Input(3, "N", frame="body", doc="control force")
    torque = Input(3, "N.m", frame="body", doc="control torque about the centre of mass")
    disturbance_force = Input(3, "N", frame="inertial", optional=True, doc="disturbance force")
    disturbance_torque = Input(3, "N.m", frame="body", optional=True, doc="disturbance torque")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="inertia matrix")
    position = State(3, "m", frame="inertial", output=True, doc="centre of mass")
    velocity = State(3, "m/s", frame="inertial", output=True, doc="velocity")
    attitude = State(4, "1", IDENTITY, frame="body", output=True,
                     doc="attitude, body to inertial, scalar last")
    angular_velocity = State(3, "rad/s", frame="body", output=True, doc="angular velocity")

    def derivatives(self, velocity, attitude, angular_velocity, force, torque,
                    disturbance_force, disturbance_torque, mass, inertia):
        moment = torque + disturbance_torque
        return {
            "position": velocity,                                                      # (5)
            "velocity": (rotate(attitude, force) + disturbance_force) / mass,          # (6)
            "attitude": quaternion_rate(attitude, angular_velocity),                   # (3)
            "angular_velocity": angular_acceleration(inertia, angular_velocity, moment),  # (4)
        }

    def project(self, attitude):
        return {"attitude": unit(attitude)}

    def requirements(self, attitude, inertia):
        return {
            **inertia_requirements(inertia),
            "attitude must be a unit quaternion": is_unit(attitude),
        }
