"""Orbit about a point mass in closed form."""

import numpy as np

from ..component import Component
from ..declarations import Array, Output, Parameter, Scalar
from .planet_environment import EARTH, START_RADIUS

NEWTON_STEPS = 8  # from the start below, to rounding for e <= 0.99


class KeplerOrbit(Component):
    """Point mass on an elliptic orbit: position and velocity as functions of time.

    M = M0 + √(μ/a³) t,   E - e sin E = M
    r = a (cos E - e) P + a √(1-e²) sin E Q
    v = √(μ/a)/(1 - e cos E) (-sin E P + √(1-e²) cos E Q)

    P points to the perigee, Q from it along the motion; at default both orbit and perigee are at
    inertial x, y. Eight Newton steps solve Kepler's equation.

    Source: D. A. Vallado, Fundamentals of Astrodynamics and Applications, 2.2, 2.6.
    """

    position = Output(3, "m", frame="inertial", doc="centre of mass from the planet's centre")
    velocity = Output(3, "m/s", frame="inertial", doc="velocity")
    gravitational_parameter = Parameter((), "m3/s2", EARTH, min=1.0, doc="μ of the planet")
    semi_major_axis = Parameter((), "m", START_RADIUS, min=1.0, doc="a")
    eccentricity = Parameter((), "1", 0.0, min=0.0, max=0.99, doc="e")
    inclination = Parameter((), "rad", doc="of the orbit's plane to inertial x, y")
    ascending_node = Parameter((), "rad", doc="from inertial x to the ascending node")
    argument_of_perigee = Parameter((), "rad", doc="from the ascending node to the perigee")
    mean_anomaly = Parameter((), "rad", doc="M0, at time 0")

    def outputs(self, time, gravitational_parameter, semi_major_axis, eccentricity, inclination,
                ascending_node, argument_of_perigee, mean_anomaly):
        a, e = semi_major_axis, eccentricity
        E = eccentric_anomaly(mean_anomaly + np.sqrt(gravitational_parameter / a**3) * time, e)
        P, Q = orbit_axes(inclination, ascending_node, argument_of_perigee)
        shape = np.sqrt((1.0 - e) * (1.0 + e))
        speed = np.sqrt(gravitational_parameter / a) / (1.0 - e * np.cos(E))
        return {
            "position": a * (np.cos(E) - e) * P + a * shape * np.sin(E) * Q,
            "velocity": speed * (shape * np.cos(E) * Q - np.sin(E) * P),
        }

    def requirements(self, semi_major_axis):
        return {"semi_major_axis must be positive": semi_major_axis > 0.0}


def eccentric_anomaly(mean_anomaly: Scalar, eccentricity: Scalar) -> Scalar:
    """E of Kepler's equation, in [-π, π]."""
    e = eccentricity
    M = np.mod(mean_anomaly + np.pi, 2.0 * np.pi) - np.pi
    E = M + 0.85 * e * np.where(M < 0.0, -1.0, 1.0)  # Danby's start
    for _ in range(NEWTON_STEPS):
        E = E - (E - e * np.sin(E) - M) / (1.0 - e * np.cos(E))
    return E


def orbit_axes(inclination: Scalar, ascending_node: Scalar,
               argument_of_perigee: Scalar) -> tuple[Array, Array]:
    """P and Q: the directions to the perigee and, a quarter turn on, of the motion there."""
    ci, si = np.cos(inclination), np.sin(inclination)
    cΩ, sΩ = np.cos(ascending_node), np.sin(ascending_node)
    cω, sω = np.cos(argument_of_perigee), np.sin(argument_of_perigee)
    P = np.stack([cΩ * cω - sΩ * sω * ci, sΩ * cω + cΩ * sω * ci, sω * si])
    Q = np.stack([-cΩ * sω - sΩ * cω * ci, -sΩ * sω + cΩ * cω * ci, cω * si])
    return P, Q
