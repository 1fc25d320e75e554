"""Tracking of a trajectory in line-of-sight spherical coordinates: computed torque."""

import numpy as np

from ..component import Component
from ..declarations import Array, Input, Output, Parameter, SamplePeriod
from ..transforms.spherical import spherical_axes
from .relative_motion import spherical_coriolis, spherical_gravity, spherical_inertia


class SphericalTrackingController(Component):
    """Leads a deputy along desired range, elevation and azimuth, as a radar measures them.

    u_s = H_s (q_d'' - Kd e' - Kp e) + C_s q_s' + g_s(q_s),   e = q_s - q_d             (19)
    u_s = (a_x2, r a_y2, -r a_z2 cos ψ),   f = m (a_x2 e_r + a_y2 e_ψ - a_z2 e_θ)

    Range must not come to 0 nor elevation to ±90 degrees: use it down to a hold point.

    Source: relative motion in the LVLH frame paper, section III.C and appendix.
    """

    range = Input((), "m", 1.0, doc="r")
    elevation = Input((), "rad", doc="ψ")
    azimuth = Input((), "rad", doc="θ")
    range_rate = Input((), "m/s", doc="rate of r")
    elevation_rate = Input((), "rad/s", doc="rate of ψ")
    azimuth_rate = Input((), "rad/s", doc="rate of θ")
    desired_range = Input((), "m", 1.0, doc="desired r")
    desired_elevation = Input((), "rad", doc="desired ψ")
    desired_azimuth = Input((), "rad", doc="desired θ")
    desired_range_rate = Input((), "m/s", optional=True, doc="its rate")
    desired_elevation_rate = Input((), "rad/s", optional=True, doc="its rate")
    desired_azimuth_rate = Input((), "rad/s", optional=True, doc="its rate")
    desired_range_acceleration = Input((), "m/s2", optional=True, doc="its second rate")
    desired_elevation_acceleration = Input((), "rad/s2", optional=True, doc="its second rate")
    desired_azimuth_acceleration = Input((), "rad/s2", optional=True, doc="its second rate")
    orbit_rate = Input((), "rad/s", doc="ω, chief's orbit rate")
    orbit_acceleration = Input((), "rad/s2", doc="rate of ω")
    gravity_gradient = Input((), "1/s2", doc="k, the planet's μ by the cube of chief's radius")
    lvlh_force = Output(3, "N", frame="lvlh", doc="control force")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="deputy's mass")
    position_gain = Parameter(3, "1/s2", 1e-4, min=0.0, frame="spherical", doc="Kp of r, ψ, θ")
    velocity_gain = Parameter(3, "1/s", 0.1, min=0.0, frame="spherical", doc="Kd of r, ψ, θ")
    sample_period = SamplePeriod()

    def outputs(self, range, elevation, azimuth, range_rate, elevation_rate, azimuth_rate,
                desired_range, desired_elevation, desired_azimuth, desired_range_rate,
                desired_elevation_rate, desired_azimuth_rate, desired_range_acceleration,
                desired_elevation_acceleration, desired_azimuth_acceleration, orbit_rate,
                orbit_acceleration, gravity_gradient, mass, position_gain, velocity_gain):
        q = np.stack([range, elevation, azimuth])
        dq = np.stack([range_rate, elevation_rate, azimuth_rate])
        q_d = np.stack([desired_range, desired_elevation, desired_azimuth])
        dq_d = np.stack([desired_range_rate, desired_elevation_rate, desired_azimuth_rate])
        ddq_d = np.stack([desired_range_acceleration, desired_elevation_acceleration,
                          desired_azimuth_acceleration])
        wanted = ddq_d - velocity_gain * (dq - dq_d) - position_gain * nearest_angles(q - q_d)
        u = (spherical_inertia(q) * wanted + spherical_coriolis(q, dq, orbit_rate) @ dq
             + spherical_gravity(q, orbit_rate, orbit_acceleration, gravity_gradient))  # (19)
        e_r, e_ψ, e_θ = spherical_axes(elevation, azimuth)
        across = u[1] / range * e_ψ + u[2] / (range * np.cos(elevation)) * e_θ
        return {"lvlh_force": mass * (u[0] * e_r + across)}

    def requirements(self, range, elevation):
        return {
            "range must be positive": range > 0.0,
            "elevation must be less than 90 degrees": np.abs(elevation) < 0.5 * np.pi,
        }


def nearest_angles(error: Array) -> Array:
    """The error of (r, ψ, θ) with that of the azimuth between -π and π."""
    azimuth = np.mod(error[2] + np.pi, 2.0 * np.pi) - np.pi
    return np.stack([error[0], error[1], azimuth])
