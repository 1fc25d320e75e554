"""Thruster cluster with what real thrusters do: limits, lag, misalignment, faults, consumption."""

import numpy as np

from ..component import Component
from ..declarations import Array, Input, Output, Parameter, Scalar, State, Structure
from ..maths import small_rotation
from .thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
    directions_requirement,
)

STANDARD_GRAVITY = 9.80665  # m/s2
NEVER = 1e12  # s
INSTANT = 1e-9  # s, tolerance of the comparison of times


class OneSidedThrusterCluster(Component):
    """Force, torque and mass flow of thrusters that only push, lag, may fail and consume.

    level  = clip(command, 0, F_max);   F_max when stuck on, 0 when stuck off
    F'     = (level - F) / t_rise   or / t_fall;   F = level where that time is 0
    force  = Σ F_k e_k,   torque = Σ F_k (p_k - c) × e_k,   e_k turned by its misalignment (19)
    flow   = Σ F_k / (g0 Isp_k)

    ``healthy`` is what perfect fault detection says; wire it to an allocator.

    Source: 6-DOF precision formation flying at L2 paper, eq. (19), with the usual imperfections.
    """

    thrusters = Structure(12, doc="number of thrusters")
    command = Input("thrusters", "N", doc="wanted thrust of each thruster")
    lagged = State("thrusters", "N", doc="thrust behind the valve's lag")
    propellant_used = State((), "kg", output=True, doc="propellant used since the start")
    force = Output(3, "N", frame="body", doc="total force")
    torque = Output(3, "N.m", frame="body", doc="total torque about the centre of mass")
    thrust = Output("thrusters", "N", doc="true thrust of each thruster")
    mass_flow = Output((), "kg/s", doc="propellant used per second")
    healthy = Output("thrusters", "1", 1.0, type="boolean", doc="thrusters without fault")
    positions = Parameter(("thrusters", 3), "m", default_positions, frame="body",
                          doc="where each thruster pushes")
    directions = Parameter(("thrusters", 3), "1", default_directions, frame="body",
                           doc="nominal direction of the force on the spacecraft, unit vectors")
    center_of_mass = Parameter(3, "m", frame="body", doc="centre of mass")
    misalignment = Parameter(("thrusters", 3), "rad", frame="body",
                             doc="small rotation of each direction")
    max_thrust = Parameter("thrusters", "N", 1.0, min=1e-9, doc="thrust of an open valve")
    rise_time = Parameter((), "s", min=0.0, doc="time constant of a rising thrust")
    fall_time = Parameter((), "s", min=0.0, doc="time constant of a falling thrust")
    specific_impulse = Parameter("thrusters", "s", 220.0, min=1.0, doc="Isp")
    stuck_on_time = Parameter("thrusters", "s", NEVER, doc="when a valve stays open")
    stuck_off_time = Parameter("thrusters", "s", NEVER, doc="when a valve stays shut")

    def derivatives(self, command, lagged, max_thrust, rise_time, fall_time, specific_impulse,
                    stuck_on_time, stuck_off_time, time):
        level = valve_level(command, max_thrust, stuck_on_time, stuck_off_time, time)
        lag = np.where(level > lagged, rise_time, fall_time)
        thrust = np.where(lag > 0.0, lagged, level)
        return {
            "lagged": np.where(lag > 0.0, (level - lagged) / np.where(lag > 0.0, lag, 1.0), 0.0),
            "propellant_used": np.sum(thrust / (STANDARD_GRAVITY * specific_impulse)),
        }

    def outputs(self, command, lagged, positions, directions, center_of_mass, misalignment,
                max_thrust, rise_time, fall_time, specific_impulse, stuck_on_time, stuck_off_time,
                time):
        level = valve_level(command, max_thrust, stuck_on_time, stuck_off_time, time)
        lag = np.where(level > lagged, rise_time, fall_time)
        F = np.where(lag > 0.0, lagged, level)
        turned = np.stack([small_rotation(misalignment[k], directions[k])
                           for k in range(len(F))])
        U = control_sensitivity(positions, turned, center_of_mass) @ F                 # (19)
        works = np.logical_and(time < stuck_on_time - INSTANT, time < stuck_off_time - INSTANT)
        return {
            "force": U[:3], "torque": U[3:], "thrust": F,
            "mass_flow": np.sum(F / (STANDARD_GRAVITY * specific_impulse)),
            "healthy": np.where(works, 1.0, 0.0),
        }

    def requirements(self, directions):
        return directions_requirement(directions)


def valve_level(command: Array, max_thrust: Array, stuck_on_time: Array, stuck_off_time: Array,
                time: Scalar) -> Array:
    """The thrust that the valves call for, faults and limits considered."""
    level = np.where(time >= stuck_on_time - INSTANT, max_thrust, command)
    level = np.where(time >= stuck_off_time - INSTANT, 0.0, level)
    return np.clip(level, 0.0, max_thrust)
