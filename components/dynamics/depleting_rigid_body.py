"""Rigid body that gets lighter as its thrusters use propellant."""

import numpy as np

from ..component import Component
from ..declarations import Input, Output, Parameter, State
from ..maths import IDENTITY, is_unit, quaternion_rate, rotate, unit
from .rigid_rotation import angular_acceleration, inertia_requirements


class DepletingRigidBody(Component):
    """Free rigid body whose mass and inertia fall with the propellant left.

    m' = -flow while there is propellant,   m = dry_mass + propellant
    J  = dry_inertia + (J_full - J_dry) propellant / propellant_full
    J Ω' = J Ω × Ω + τ + τ_d,   m v' = R f + f_d

    The propellant leaves without turning the body: jet damping is neglected, and the centre of
    mass stays. ``empty`` says that thrusters should no longer push: cutting them is up to the
    system.

    Source: coupled LOS attitude and position control paper, eqs. (3)-(6), with variable mass.
    """

    force = Input(3, "N", frame="body", doc="control force")
    torque = Input(3, "N.m", frame="body", doc="control torque about the centre of mass")
    disturbance_force = Input(3, "N", frame="inertial", optional=True, doc="disturbance force")
    disturbance_torque = Input(3, "N.m", frame="body", optional=True, doc="disturbance torque")
    mass_flow = Input((), "kg/s", doc="propellant used per second")
    dry_mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass without propellant")
    full_propellant = Parameter((), "kg", 1.0, min=1e-9, doc="propellant at which J is J_full")
    dry_inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="J_dry")
    full_inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="J_full")
    position = State(3, "m", frame="inertial", output=True, doc="centre of mass")
    velocity = State(3, "m/s", frame="inertial", output=True, doc="velocity")
    attitude = State(4, "1", IDENTITY, frame="body", output=True,
                     doc="body to inertial, scalar last")
    angular_velocity = State(3, "rad/s", frame="body", output=True, doc="angular velocity")
    propellant = State((), "kg", 1.0, output=True, doc="propellant left")
    mass = Output((), "kg", doc="m")
    empty = Output((), "1", type="boolean", doc="whether the propellant is used up")

    def derivatives(self, force, torque, disturbance_force, disturbance_torque, mass_flow,
                    dry_mass, full_propellant, dry_inertia, full_inertia, velocity, attitude,
                    angular_velocity, propellant):
        left = np.maximum(propellant, 0.0)
        J = dry_inertia + (full_inertia - dry_inertia) * (left / full_propellant)
        push = rotate(attitude, force) + disturbance_force
        return {
            "position": velocity,
            "velocity": push / (dry_mass + left),
            "attitude": quaternion_rate(attitude, angular_velocity),
            "angular_velocity":
                angular_acceleration(J, angular_velocity, torque + disturbance_torque),
            "propellant": np.where(propellant > 0.0, -mass_flow, 0.0),
        }

    def outputs(self, dry_mass, propellant):
        return {"mass": dry_mass + np.maximum(propellant, 0.0),
                "empty": np.where(propellant > 0.0, 0.0, 1.0)}

    def project(self, attitude, propellant):
        return {"attitude": unit(attitude), "propellant": np.maximum(propellant, 0.0)}

    def requirements(self, attitude, dry_inertia, full_inertia, propellant):
        full = {f"full_{message}": holds
                for message, holds in inertia_requirements(full_inertia).items()}
        dry = {f"dry_{message}": holds
               for message, holds in inertia_requirements(dry_inertia).items()}
        return {
            **dry, **full,
            "attitude must be a unit quaternion": is_unit(attitude),
            "propellant must not be negative": propellant >= 0.0,
        }
