"""What two-body orbits share: the planet's gravity, oblateness and atmosphere, as parameters.

Oblateness: a = -(3/2) J2 (μ/r²) (R/r)² ((1 - 5 n_z²) n + 2 n_z z),   n = r/|r|
Drag:       a = -½ ρ (C_D A/m) |w| w,   w = v - ω z × r,   ρ = ρ0 exp(-(|r| - r0)/H)

Source: D. A. Vallado, Fundamentals of Astrodynamics and Applications, 8.6, 8.7.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..component import Component
from ..declarations import Array, Parameter, Scalar
from ..maths import cross

EARTH = 3.986004418e14  # m3/s2
START_RADIUS = 6718137.0  # m, 340 km above the Earth's equator
START_SPEED = float(np.sqrt(EARTH / START_RADIUS))  # m/s, circular
AXIS = np.array([0.0, 0.0, 1.0])  # of the planet's rotation and symmetry


class Planet(NamedTuple):
    """A planet's perturbations of two-body motion: see the module's docstring."""

    gravitational_parameter: Scalar
    oblateness: Scalar
    equatorial_radius: Scalar
    density: Scalar
    density_radius: Scalar
    scale_height: Scalar
    planet_rate: Scalar

    def perturbation(self, position: Array, velocity: Array, area_to_mass: Scalar) -> Array:
        """Acceleration by oblateness and drag; ``area_to_mass`` is C_D A/m."""
        return self._oblateness(position) + self._drag(position, velocity, area_to_mass)

    def _oblateness(self, position: Array) -> Array:
        r = np.linalg.norm(position)
        n = position / r
        strength = (-1.5 * self.oblateness * self.gravitational_parameter / r**2
                    * (self.equatorial_radius / r) ** 2)
        return strength * ((1.0 - 5.0 * n[2] ** 2) * n + 2.0 * n[2] * AXIS)

    def _drag(self, position: Array, velocity: Array, area_to_mass: Scalar) -> Array:
        height = np.linalg.norm(position) - self.density_radius
        ρ = self.density * np.exp(-height / self.scale_height)
        w = velocity - self.planet_rate * cross(AXIS, position)
        return -0.5 * ρ * area_to_mass * np.linalg.norm(w) * w


class _PlanetEnvironment(Component):
    """Parameters of a planet, the Earth at default; oblateness and drag are off at default."""

    gravitational_parameter = Parameter((), "m3/s2", EARTH, min=1.0, doc="μ of the planet")
    oblateness = Parameter((), "1", 0.0, doc="J2; 0: a point mass (Earth 1.08262668e-3)")
    equatorial_radius = Parameter((), "m", 6378137.0, min=1.0, doc="radius that belongs to J2")
    density = Parameter((), "kg/m3", 0.0, min=0.0,
                        doc="atmosphere's density at density_radius; 0: no drag")
    density_radius = Parameter((), "m", START_RADIUS, min=1.0, doc="where density holds")
    scale_height = Parameter((), "m", 5e4, min=1.0, doc="in which the density falls by e")
    planet_rate = Parameter((), "rad/s", 7.292115e-5,
                            doc="rotation of the atmosphere about inertial z")
