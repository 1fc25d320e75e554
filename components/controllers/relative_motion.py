"""Terms of the relative motion of a deputy in the LVLH frame of its chief.

q'' + C q' + g(q) = u                                                                    (2)
H_s q_s'' + C_s q_s' + g_s(q_s) = u_s,   q_s = (r, ψ, θ)                                (A3)

ω and ω' are the chief's orbit rate and its rate, k = μ/r_c³. The equations hold for a deputy near
its chief. In u_s = (a_x2, r a_y2, -r a_z2 cos ψ) the line-of-sight axis z2 points along -θ.

Source: relative motion in the LVLH frame paper, section II and appendix.
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Scalar

ZERO = np.zeros(())


def coriolis(velocity: Array, orbit_rate: Scalar) -> Array:
    """C q' (5)."""
    return 2.0 * orbit_rate * np.stack([-velocity[2], ZERO, velocity[0]])


def gravity_terms(position: Array, orbit_rate: Scalar, orbit_acceleration: Scalar,
                  gravity_gradient: Scalar) -> Array:
    """g(q) (6)."""
    x, y, z = position[0], position[1], position[2]
    ω2, k = orbit_rate**2, gravity_gradient
    return np.stack([
        -z * orbit_acceleration - x * (ω2 - k),
        k * y,
        -z * (ω2 + 2.0 * k) + x * orbit_acceleration,
    ])


def potential(position: Array, orbit_rate: Scalar, gravity_gradient: Scalar) -> Scalar:
    """U (8), whose gradient is g(q) in a circular orbit."""
    x, y, z = position[0], position[1], position[2]
    tide = 0.5 * gravity_gradient * (x * x + y * y - 2.0 * z * z)
    return tide - 0.5 * orbit_rate**2 * (x * x + z * z)


def spherical_inertia(coordinates: Array) -> Array:
    """Diagonal of H_s (A4)."""
    r, c = coordinates[0], np.cos(coordinates[1])
    return np.stack([np.ones(()), r**2, r**2 * c**2])


def spherical_coriolis(coordinates: Array, rates: Array, orbit_rate: Scalar) -> Array:
    """Matrix C_s (A5)."""
    r, s, c = coordinates[0], np.sin(coordinates[1]), np.cos(coordinates[1])
    dr, dψ, dθ, ω = rates[0], rates[1], rates[2], orbit_rate
    swing = r * c**2 * (dθ - 2.0 * ω)
    lift = r**2 * s * c * (dθ - 2.0 * ω)
    return np.stack([
        np.stack([ZERO, -r * dψ, -swing]),
        np.stack([r * dψ, r * dr, lift]),
        np.stack([swing, -lift, r * dr * c**2 - r**2 * dψ * s * c]),
    ])


def spherical_gravity(coordinates: Array, orbit_rate: Scalar, orbit_acceleration: Scalar,
                      gravity_gradient: Scalar) -> Array:
    """g_s,c + g_s,nc (A6), (A7)."""
    r, s, c = coordinates[0], np.sin(coordinates[1]), np.cos(coordinates[1])
    sθ, cθ = np.sin(coordinates[2]), np.cos(coordinates[2])
    ω2, k = orbit_rate**2, gravity_gradient
    return np.stack([
        -r * (ω2 * c**2 - k * (1.0 - 3.0 * sθ**2 * c**2)),
        r**2 * (ω2 * c * s + 3.0 * k * sθ**2 * c * s),
        -3.0 * k * r**2 * sθ * cθ * c**2 - r**2 * orbit_acceleration * c**2,
    ])


def spherical_potential(coordinates: Array, orbit_rate: Scalar,
                        gravity_gradient: Scalar) -> Scalar:
    """U_s (A8), equal to U."""
    r, c, sθ = coordinates[0], np.cos(coordinates[1]), np.sin(coordinates[2])
    return -0.5 * r**2 * (orbit_rate**2 * c**2
                          - gravity_gradient * (1.0 - 3.0 * sθ**2 * c**2))
