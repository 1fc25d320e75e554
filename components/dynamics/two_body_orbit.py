"""Orbit about a planet, integrated: one spacecraft by its absolute state."""

from ..declarations import Input, Output, Parameter, State
from .gravity import gravity
from .planet_environment import START_RADIUS, START_SPEED, Planet, _PlanetEnvironment


class TwoBodyOrbit(_PlanetEnvironment):
    """Point mass in orbit about a planet, by its position and velocity.

    r'' = -μ r/|r|³ + a_J2 + a_drag + f/m

    The default is a circular orbit 340 km above the Earth's equator. Oblateness and drag are off
    unless `oblateness` and `density` are given. `KeplerOrbit` gives the motion of a point mass
    without force in closed form.

    Source: relative motion in the LVLH frame paper, section IV; Vallado, Fundamentals of
    Astrodynamics and Applications, 8.6, 8.7.
    """

    default_solver_step = 1.0  # s: RK4 errs by 1e-8 m a step in low orbit

    force = Input(3, "N", frame="inertial", doc="control force")
    control_acceleration = Output(3, "m/s2", frame="inertial", doc="force by mass")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="mass")
    drag_area = Parameter((), "m2", 0.0, min=0.0, doc="drag coefficient times area")
    position = State(3, "m", (START_RADIUS, 0.0, 0.0), frame="inertial", output=True,
                     doc="centre of mass from the planet's centre")
    velocity = State(3, "m/s", (0.0, START_SPEED, 0.0), frame="inertial", output=True,
                     doc="velocity")

    def derivatives(self, position, velocity, force, mass, drag_area, gravitational_parameter,
                    oblateness, equatorial_radius, density, density_radius, scale_height,
                    planet_rate):
        planet = Planet(gravitational_parameter, oblateness, equatorial_radius, density,
                        density_radius, scale_height, planet_rate)
        return {
            "position": velocity,
            "velocity": gravity(gravitational_parameter, position)
                        + planet.perturbation(position, velocity, drag_area / mass)
                        + force / mass,
        }

    def outputs(self, force, mass):
        return {"control_acceleration": force / mass}

    def requirements(self, position):
        return {"position must differ from the planet's centre": position @ position > 0.0}
