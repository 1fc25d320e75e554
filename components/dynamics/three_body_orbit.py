"""Circular restricted three-body problem with light pressure: one craft by its absolute state."""

from ..declarations import Input, Output, Parameter, State
from .three_body_environment import L2, MEAN_MOTION, Primaries, _ThreeBodyEnvironment


class ThreeBodyOrbit(_ThreeBodyEnvironment):
    """Point mass under the gravity of two primaries on circular orbits, and the first one's light.

    r'' = -μ1 d1/|d1|³ - μ2 d2/|d2|³ + P0 (a/|d1|)² (C_r A/m) d1/|d1| + f/m              (1)

    with d1, d2 from the primaries to the craft, r from their barycentre; the second primary is on
    inertial x at time 0. The default start rests, but for light, at L2 of Sun and Earth with Moon.

    Source: 6-DOF precision formation flying at L2 paper, eq. (1).
    """

    default_solver_step = 60.0  # s: orbits last months

    force = Input(3, "N", frame="inertial", doc="control force")
    control_acceleration = Output(3, "m/s2", frame="inertial", doc="force by mass")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    light_area = Parameter((), "m2", 0.0, min=0.0, doc="C_r A, reflectivity times area")
    position = State(3, "m", (L2, 0.0, 0.0), frame="inertial", output=True,
                     doc="centre of mass from the barycentre")
    velocity = State(3, "m/s", (0.0, L2 * MEAN_MOTION, 0.0), frame="inertial", output=True,
                     doc="velocity")

    def derivatives(self, time, position, velocity, force, mass, light_area,
                    first_gravitational_parameter, second_gravitational_parameter, separation,
                    light_pressure):
        primaries = Primaries(first_gravitational_parameter, second_gravitational_parameter,
                              separation, light_pressure)
        natural = primaries.acceleration(time, position, light_area / mass)
        return {"position": velocity, "velocity": natural + force / mass}               # (1)

    def outputs(self, force, mass):
        return {"control_acceleration": force / mass}

    def requirements(self, time, position, first_gravitational_parameter,
                     second_gravitational_parameter, separation, light_pressure):
        primaries = Primaries(first_gravitational_parameter, second_gravitational_parameter,
                              separation, light_pressure)
        return {"position must differ from those of the primaries":
                primaries.least_distance(time, position) > 0.0}
