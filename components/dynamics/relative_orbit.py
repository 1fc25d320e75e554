"""Orbit of a deputy about a planet, integrated as its difference from the chief's."""

from ..declarations import Input, Output, Parameter, State
from .gravity import gravity_difference
from .planet_environment import START_RADIUS, START_SPEED, Planet, _PlanetEnvironment


class RelativeOrbit(_PlanetEnvironment):
    """Deputy in orbit about a planet, by its position and velocity relative to a chief.

    ρ'' = -(μ/|r + ρ|³) (ρ - f(q) r) + Δa_J2 + Δa_drag + f/m - a_c
    f(q) = q (3 + 3 q + q²) / (1 + (1 + q)^(3/2)),   q = ρ·(2 r + ρ)/|r|²

    with the chief's position r and control acceleration a_c. This is Newton's law for both,
    without the digits that the difference of two absolute positions loses; differences of the
    perturbations, small themselves, are formed directly.

    Source: relative motion in the LVLH frame paper, section IV; Battin, An Introduction to the
    Mathematics and Methods of Astrodynamics, 8.4.
    """

    default_solver_step = 1.0  # s: RK4 errs by 1e-8 m a step in low orbit

    chief_position = Input(3, "m", (START_RADIUS, 0.0, 0.0), frame="inertial",
                           doc="chief's centre of mass from the planet's centre")
    chief_velocity = Input(3, "m/s", (0.0, START_SPEED, 0.0), frame="inertial",
                           doc="chief's velocity")
    chief_control_acceleration = Input(3, "m/s2", frame="inertial",
                                       optional=True, doc="chief's acceleration by its own thrust")
    force = Input(3, "N", frame="inertial", doc="control force")
    position = Output(3, "m", frame="inertial", doc="centre of mass from the planet's centre")
    velocity = Output(3, "m/s", frame="inertial", doc="velocity")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    drag_area = Parameter((), "m2", 0.0, min=0.0, doc="drag coefficient times area")
    chief_mass = Parameter((), "kg", 1.0, min=1e-9, doc="chief's mass")
    chief_drag_area = Parameter((), "m2", 0.0, min=0.0, doc="chief's drag coefficient times area")
    relative_position = State(3, "m", frame="inertial", output=True, doc="from the chief")
    relative_velocity = State(3, "m/s", frame="inertial", output=True,
                              doc="velocity less the chief's")

    def derivatives(self, chief_position, chief_velocity, chief_control_acceleration, force,
                    relative_position, relative_velocity, mass, drag_area, chief_mass,
                    chief_drag_area, gravitational_parameter, oblateness, equatorial_radius,
                    density, density_radius, scale_height, planet_rate):
        planet = Planet(gravitational_parameter, oblateness, equatorial_radius, density,
                        density_radius, scale_height, planet_rate)
        r, v, ρ, ρ_rate = chief_position, chief_velocity, relative_position, relative_velocity
        return {
            "relative_position": ρ_rate,
            "relative_velocity": gravity_difference(gravitational_parameter, r, ρ)
                                 + planet.perturbation(r + ρ, v + ρ_rate, drag_area / mass)
                                 - planet.perturbation(r, v, chief_drag_area / chief_mass)
                                 + force / mass - chief_control_acceleration,
        }

    def outputs(self, chief_position, chief_velocity, relative_position, relative_velocity):
        return {
            "position": chief_position + relative_position,
            "velocity": chief_velocity + relative_velocity,
        }

    def requirements(self, chief_position):
        return {
            "chief_position must differ from the planet's centre":
                chief_position @ chief_position > 0.0,
        }
