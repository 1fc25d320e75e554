"""Gravity and light of two primaries that circle their barycentre.

The primaries turn about inertial z at n = √((μ1 + μ2)/a³); the second is on inertial x at time 0.
The light of the first exerts P0 (a/d)² on a craft at the distance d from it. It falls off as
gravity does, so it takes part of the first primary's: μ1 - P0 a² C_r A/m.

Source: 6-DOF precision formation flying at L2 paper, eqs. (1)-(3).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..component import Component
from ..declarations import Array, Parameter, Scalar
from .gravity import gravity, gravity_difference

SUN, EARTH_AND_MOON = 1.32712440018e20, 4.035032355e14  # m3/s2
ASTRONOMICAL_UNIT = 1.495978707e11  # m
SOLAR_PRESSURE = 1361.0 / 299792458.0  # N/m2
L2 = 151105099170.1327  # m from the barycentre of Sun and Earth/Moon
MEAN_MOTION = float(np.sqrt((SUN + EARTH_AND_MOON) / ASTRONOMICAL_UNIT**3))  # rad/s


class Primaries(NamedTuple):
    """The two primaries: see the module's docstring. ``lightness`` is C_r A/m of a craft."""

    first_gravitational_parameter: Scalar
    second_gravitational_parameter: Scalar
    separation: Scalar
    light_pressure: Scalar

    def acceleration(self, time: Scalar, position: Array, lightness: Scalar) -> Array:
        """Of a craft at a barycentric position (1), (2)."""
        from_first, from_second = self._from_primaries(time, position)
        return (gravity(self._first(lightness), from_first)
                + gravity(self.second_gravitational_parameter, from_second))

    def difference(self, time: Scalar, position: Array, lightness: Scalar, offset: Array,
                   offset_lightness: Scalar) -> Array:
        """Of a craft at position + offset less that of one at position, without cancellation (3).
        """
        from_first, from_second = self._from_primaries(time, position)
        push = self.light_pressure * self.separation**2 * (offset_lightness - lightness)
        return (gravity_difference(self._first(offset_lightness), from_first, offset)
                + gravity_difference(self.second_gravitational_parameter, from_second, offset)
                - gravity(push, from_first))

    def least_distance(self, time: Scalar, position: Array) -> Scalar:
        """From a barycentric position to the nearer primary."""
        from_first, from_second = self._from_primaries(time, position)
        return np.minimum(np.linalg.norm(from_first), np.linalg.norm(from_second))

    def _first(self, lightness: Scalar) -> Scalar:
        light = self.light_pressure * self.separation**2 * lightness
        return self.first_gravitational_parameter - light

    def _from_primaries(self, time: Scalar, position: Array) -> tuple[Array, Array]:
        total = self.first_gravitational_parameter + self.second_gravitational_parameter
        angle = np.sqrt(total / self.separation**3) * time
        axis = self.separation * np.stack([np.cos(angle), np.sin(angle), np.zeros(())])
        first = -self.second_gravitational_parameter / total * axis
        return position - first, position - first - axis


class _ThreeBodyEnvironment(Component):
    """Parameters of the primaries: Sun and Earth with Moon at default."""

    first_gravitational_parameter = Parameter((), "m3/s2", SUN, min=1.0,
                                              doc="μ1, of the primary that shines")
    second_gravitational_parameter = Parameter((), "m3/s2", EARTH_AND_MOON, min=0.0, doc="μ2")
    separation = Parameter((), "m", ASTRONOMICAL_UNIT, min=1.0, doc="a, between the primaries")
    light_pressure = Parameter((), "N/m2", SOLAR_PRESSURE, min=0.0,
                               doc="P0, of light absorbed at the distance a; 0: none")
