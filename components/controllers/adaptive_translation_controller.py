"""Adaptive tracking of a relative trajectory under unknown, slowly varying accelerations."""

import numpy as np

from ..component import Component
from ..declarations import DiscreteState, Input, Output, Parameter, SamplePeriod, State
from ..maths import IDENTITY, is_unit, rotate_inverse, small_rotation
from .adaptive_tracking import to_inertial, to_rotating


class AdaptiveTranslationController(Component):
    """Leads a follower along a desired position from its leader, learning the environment.

    x'' = -θ1 - A_ri^T θ2 + u                                                            (5)
    u = x_d'' - Λ_T e' + Γ θ^ - K_T s,   Γ = [I, A_ri^T],   e = x - x_d,   s = e' + Λ_T e  (8)
    θ^' = -γ Γ^T s                                                                       (9)
    f = m R^T u, in the body frame                                                      (19)

    θ1 is constant inertially, θ2 in the frame A_ri that turns with the primaries. `mass` is the
    estimate: if it is wrong the plant sees σ u with σ its ratio to the true mass (11), and θ^
    still converges where x_d'' = 0.

    A held force turns with the body: with `hold_time` it is the right one in the middle of the
    time for which it is held. A sampled law learns from one tick to the next by the s of the first.

    Source: 6-DOF precision formation flying at L2 paper, eqs. (5)-(13), (19).
    """

    default_solver_step = 1.0  # s

    relative_position = Input(3, "m", frame="inertial", doc="x, from the leader")
    relative_velocity = Input(3, "m/s", frame="inertial", doc="velocity less the leader's")
    desired_position = Input(3, "m", frame="inertial", doc="x_d")
    desired_velocity = Input(3, "m/s", frame="inertial", optional=True, doc="rate of x_d")
    desired_acceleration = Input(3, "m/s2", frame="inertial", optional=True,
                                 doc="second rate of x_d")
    attitude = Input(4, "1", IDENTITY, frame="body",
                     doc="own attitude, body to inertial, scalar last")
    angular_velocity = Input(3, "rad/s", frame="body", optional=True,
                             doc="own; used with hold_time only")
    force = Output(3, "N", frame="body", doc="control force")
    acceleration = Output(3, "m/s2", frame="inertial", doc="u, wanted control acceleration")
    mass = Parameter((), "kg", 1.0, min=1e-9, doc="own mass, as estimated")
    error_gain = Parameter((), "1/s", 2e-3, min=0.0, doc="Λ_T, weighs e in s")
    metric_gain = Parameter((), "1/s", 4e-3, min=0.0, doc="K_T, damps s")
    adaptation_gain = Parameter((), "1/s2", 2e-6, min=0.0, doc="γ; 0: no learning")
    orbit_rate = Parameter((), "rad/s", 1.990986701e-7, doc="of the primaries about inertial z")
    orbit_angle = Parameter((), "rad", doc="of the rotating frame at time 0")
    hold_time = Parameter((), "s", 0.0, min=0.0, doc="for which the force is held; 0: not at all")
    sample_period = SamplePeriod()
    inertial_estimate = State(3, "m/s2", frame="inertial", output=True, doc="θ^1")
    rotating_estimate = State(3, "m/s2", frame="rotating", output=True, doc="θ^2")
    sampled_metric = DiscreteState(3, "m/s", frame="inertial", doc="s of the last tick")

    def derivatives(self, time, relative_position, relative_velocity, desired_position,
                    desired_velocity, error_gain, adaptation_gain, orbit_rate, orbit_angle,
                    sample_period, sampled_metric):
        e, e_rate = relative_position - desired_position, relative_velocity - desired_velocity
        s = np.where(sample_period > 0.0, sampled_metric, e_rate + error_gain * e)
        return {
            "inertial_estimate": -adaptation_gain * s,                                   # (9)
            "rotating_estimate":
                -adaptation_gain * to_rotating(s, orbit_angle + orbit_rate * time),      # (9)
        }

    def update(self, relative_position, relative_velocity, desired_position, desired_velocity,
               error_gain):
        e, e_rate = relative_position - desired_position, relative_velocity - desired_velocity
        return {"sampled_metric": e_rate + error_gain * e}

    def outputs(self, time, relative_position, relative_velocity, desired_position,
                desired_velocity, desired_acceleration, attitude, angular_velocity, mass,
                error_gain, metric_gain, orbit_rate, orbit_angle, hold_time, inertial_estimate,
                rotating_estimate):
        e, e_rate = relative_position - desired_position, relative_velocity - desired_velocity
        s = e_rate + error_gain * e
        learnt = inertial_estimate + to_inertial(rotating_estimate,
                                                 orbit_angle + orbit_rate * time)
        u = desired_acceleration - error_gain * e_rate + learnt - metric_gain * s        # (8)
        turned = small_rotation(-0.5 * hold_time * angular_velocity, rotate_inverse(attitude, u))
        return {"acceleration": u, "force": mass * turned}                              # (19)

    def requirements(self, attitude, error_gain, metric_gain):
        return {
            "attitude must be a unit quaternion": is_unit(attitude),
            "error_gain and metric_gain must be positive":
                np.minimum(error_gain, metric_gain) > 0.0,
        }
