"""Line-of-sight spherical coordinates (r, ψ, θ) of a position in the LVLH frame.

x = r cos ψ cos θ,   y = r sin ψ,   z = -r cos ψ sin θ                                  (A1)

Range r, elevation ψ out of the orbit's plane, azimuth θ in it from +x towards -z.

Source: relative motion in the LVLH frame paper, appendix.
"""

from __future__ import annotations

import numpy as np

from ..declarations import Array, Scalar


def to_spherical(position: Array) -> tuple[Scalar, Scalar, Scalar]:
    """(r, ψ, θ); the azimuth is undefined on the y axis."""
    x, y, z = position[0], position[1], position[2]
    level = np.sqrt(x * x + z * z)
    return np.linalg.norm(position), np.arctan2(y, level), np.arctan2(-z, x)


def spherical_axes(elevation: Scalar, azimuth: Scalar) -> tuple[Array, Array, Array]:
    """Unit vectors of growing r, ψ and θ."""
    sψ, cψ, sθ, cθ = np.sin(elevation), np.cos(elevation), np.sin(azimuth), np.cos(azimuth)
    return (
        np.stack([cψ * cθ, sψ, -cψ * sθ]),
        np.stack([-sψ * cθ, cψ, sψ * sθ]),
        np.stack([-sθ, np.zeros(()), -cθ]),
    )


def from_spherical(coordinates: Array, rates: Array, accelerations: Array
                   ) -> tuple[Array, Array, Array]:
    """Position, velocity and acceleration from (r, ψ, θ) and their first and second rates."""
    r, ψ, θ = coordinates[0], coordinates[1], coordinates[2]
    dr, dψ, dθ = rates[0], rates[1], rates[2]
    ddr, ddψ, ddθ = accelerations[0], accelerations[1], accelerations[2]
    s, c = np.sin(ψ), np.cos(ψ)
    e_r, e_ψ, e_θ = spherical_axes(ψ, θ)
    return (
        r * e_r,
        dr * e_r + r * dψ * e_ψ + r * c * dθ * e_θ,
        (ddr - r * dψ**2 - r * c**2 * dθ**2) * e_r
        + (r * ddψ + 2.0 * dr * dψ + r * s * c * dθ**2) * e_ψ
        + (r * c * ddθ + 2.0 * c * dr * dθ - 2.0 * r * s * dψ * dθ) * e_θ,
    )
