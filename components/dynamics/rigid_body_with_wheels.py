"""Rigid body that turns itself with reaction wheels."""

import numpy as np

from ..component import Component
from ..declarations import Array, Condition, Input, Output, Parameter, State, Structure
from ..maths import IDENTITY, cross, is_unit, quaternion_rate, rotate, unit
from .rigid_rotation import inertia_requirements

UNIT = 1e-6  # allowed error of an axis's length


def default_axes(wheels: int) -> Array:
    """Three along x, y, z; four in a pyramid about z; all along z otherwise."""
    pyramid = np.array([[1.0, 1.0, 1.0], [-1.0, 1.0, 1.0], [-1.0, -1.0, 1.0], [1.0, -1.0, 1.0]])
    layouts = {3: np.eye(3), 4: pyramid / np.sqrt(3.0)}
    return layouts.get(wheels, np.tile([0.0, 0.0, 1.0], (wheels, 1)))


def axes_requirement(wheel_axes: Array) -> dict[str, Condition]:
    """The requirement that each axis has length 1."""
    lengths = np.sqrt(np.sum(wheel_axes * wheel_axes, axis=1))
    return {"each row of wheel_axes must be a unit vector": np.max(np.abs(lengths - 1.0)) <= UNIT}


class RigidBodyWithWheels(Component):
    """Spacecraft with reaction wheels: what a motor gives a wheel it takes from the body.

    J Ω' = (J Ω + A^T h) × Ω - A^T u + τ + τ_d,    h_k = I_k (w_k + a_k·Ω)
    h_k' = u_k,   so that   w_k' = u_k / I_k - a_k·Ω'
    u    = wheel_torque cut to the motor's limit, 0 where it would exceed the speed limit

    J is the inertia without the wheels' own about their axes a_k (rows of A), I_k; h_k is a wheel's
    momentum about its axis, w_k its speed against the body. External force and torque as for the
    free rigid body. R (J Ω + A^T h) is conserved without external torque.

    Source: P. Hughes, Spacecraft Attitude Dynamics, ch. 3 (gyrostats); translation and kinematics
    as in the coupled LOS attitude and position control paper, eqs. (3), (5), (6).
    """

    wheels = Structure(3, doc="number of wheels")
    wheel_torque = Input("wheels", "N.m", doc="wanted motor torque on each wheel")
    force = Input(3, "N", frame="body", doc="control force")
    torque = Input(3, "N.m", frame="body", optional=True, doc="external control torque")
    disturbance_force = Input(3, "N", frame="inertial", optional=True, doc="disturbance force")
    disturbance_torque = Input(3, "N.m", frame="body", optional=True, doc="disturbance torque")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    inertia = Parameter((3, 3), "kg.m2", np.eye(3), frame="body", doc="J")
    wheel_axes = Parameter(("wheels", 3), "1", default_axes, frame="body", doc="a_k in each row")
    wheel_inertia = Parameter("wheels", "kg.m2", 1e-3, min=1e-12, doc="I_k about its axis")
    torque_limit = Parameter("wheels", "N.m", 1e6, min=0.0, doc="largest motor torque")
    speed_limit = Parameter("wheels", "rad/s", 1e6, min=0.0, doc="largest wheel speed")
    position = State(3, "m", frame="inertial", output=True, doc="centre of mass")
    velocity = State(3, "m/s", frame="inertial", output=True, doc="velocity")
    attitude = State(4, "1", IDENTITY, frame="body", output=True,
                     doc="body to inertial, scalar last")
    angular_velocity = State(3, "rad/s", frame="body", output=True, doc="angular velocity")
    wheel_speed = State("wheels", "rad/s", output=True, doc="w_k against the body")
    wheel_momentum = Output(3, "N.m.s", frame="body", doc="A^T h")

    def derivatives(self, wheel_torque, force, torque, disturbance_force, disturbance_torque, mass,
                    inertia, wheel_axes, wheel_inertia, torque_limit, speed_limit, velocity,
                    attitude, angular_velocity, wheel_speed):
        J, A, Ω, w = inertia, wheel_axes, angular_velocity, wheel_speed
        u = np.clip(wheel_torque, -torque_limit, torque_limit)
        u = np.where(np.logical_and(np.abs(w) >= speed_limit, u * w > 0.0), 0.0, u)
        stored = J @ Ω + A.T @ (wheel_inertia * (w + A @ Ω))
        turning = np.linalg.solve(J, cross(stored, Ω) - A.T @ u + torque + disturbance_torque)
        return {
            "position": velocity,
            "velocity": (rotate(attitude, force) + disturbance_force) / mass,
            "attitude": quaternion_rate(attitude, Ω),
            "angular_velocity": turning,
            "wheel_speed": u / wheel_inertia - A @ turning,
        }

    def outputs(self, wheel_axes, wheel_inertia, angular_velocity, wheel_speed):
        h = wheel_inertia * (wheel_speed + wheel_axes @ angular_velocity)
        return {"wheel_momentum": wheel_axes.T @ h}

    def project(self, attitude):
        return {"attitude": unit(attitude)}

    def requirements(self, attitude, inertia, wheel_axes):
        return {
            **inertia_requirements(inertia),
            **axes_requirement(wheel_axes),
            "attitude must be a unit quaternion": is_unit(attitude),
        }
