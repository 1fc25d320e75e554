"""Cases 1 to 3 of the relative motion in the LVLH frame paper, in plain numpy.

The blocks are wired by hand and integrated by scipy at tight tolerance. The expected figures come
from an independent integration of the same equations.
"""

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components import catalogue

CHIEF, DEPUTY, TO_LVLH, TO_INERTIAL, TO_SPHERICAL, APPROACH, HOLD, MONITOR = (
    catalogue.find(name)() for name in (
        "KeplerOrbit", "RelativeOrbit", "InertialToLvlh", "LvlhToInertial", "LvlhToSpherical",
        "SphericalApproachGuidance", "HoldGuidance", "RelativeMotionMonitor",
    )
)
PERIGEE = 6718137.0  # m
ECCENTRIC = (("semi_major_axis", 11996673.214), ("eccentricity", 0.44))
DOCKING = {"start_range": 1000.0 * np.sqrt(3.0), "start_elevation": np.arctan(np.sqrt(0.5)),
           "start_azimuth": -0.25 * np.pi}
DEFAULTS = {block.name: block.start_values() for block in (
    CHIEF, DEPUTY, TO_LVLH, TO_INERTIAL, TO_SPHERICAL, APPROACH, HOLD, MONITOR)}
CONTROLLERS = {name: block() for name, block in catalogue.families()["controllers"].items()}
EVERY_TEN = np.arange(0.0, 7300.0, 10.0)  # s


def evaluate(block, **values):
    arrays = {name: np.asarray(value, float) for name, value in values.items()}
    return block.evaluate("outputs", DEFAULTS.get(block.name, {}) | arrays)


def chief_at(time, orbit):
    state = evaluate(CHIEF, time=time, **dict(orbit))
    return {"chief_position": state["position"], "chief_velocity": state["velocity"]}


def start(orbit):
    """Inertial relative state of a deputy at rest at (1, 1, 1) km in the frame of the chief."""
    r, v = chief_at(0.0, orbit).values()
    axes = [v / np.linalg.norm(v), np.array([0.0, 0.0, -1.0]), -r / np.linalg.norm(r)]
    offset = 1000.0 * np.sum(axes, axis=0)
    return np.concatenate([offset, np.cross(np.cross(r, v) / (r @ r), offset), [0.0]])


def no_guidance(_):
    return {}


def station(_):
    return evaluate(HOLD, position=[100.0, 100.0, 100.0])


def linear_docking(time):
    return evaluate(APPROACH, time=time, linear=1.0, **DOCKING)


def quintic_docking(time):
    return evaluate(APPROACH, time=time, **DOCKING)


def observe(guidance, orbit, time, x):
    """All that a controller may know."""
    state = evaluate(TO_LVLH, relative_position=x[:3], relative_velocity=x[3:6],
                     **chief_at(time, orbit))
    return state | evaluate(TO_SPHERICAL, position=state["position"],
                            velocity=state["velocity"]) | guidance(time)


def control(name, known):
    """The force in the LVLH frame."""
    block = CONTROLLERS[name]
    return block.evaluate("outputs", block.start_values() | known)["lvlh_force"]


@cache
def fly(name, guidance, orbit, duration, breaks=()):
    """Relative state and Δv as a function of time, integrated from jump to jump of the guidance."""

    def rate(time, x):
        chief = chief_at(time, orbit)
        u = control(name, observe(guidance, orbit, time, x))
        change = DEPUTY.evaluate("derivatives", DEFAULTS["RelativeOrbit"] | chief | {
            "relative_position": x[:3], "relative_velocity": x[3:6],
            **evaluate(TO_INERTIAL, lvlh_force=u, **chief)})
        return np.concatenate([change["relative_position"], change["relative_velocity"],
                               [np.linalg.norm(u)]])

    x, pieces, instants = start(orbit), [], [0.0, *breaks, duration]
    for begin, end in pairwise(instants):
        span = (begin, np.nextafter(end, begin))
        solution = solve_ivp(rate, span, x, "DOP853", rtol=1e-10, atol=1e-10, dense_output=True)
        x = solution.y[:, -1]
        pieces.append(solution.sol)
    return lambda t: pieces[min(np.searchsorted(instants[1:], t, "right"), len(pieces) - 1)](t)


def error(case, time):
    known = observe(*case[1:3], time, fly(*case)(time))
    return np.linalg.norm(known["position"] - known.get("desired_position", 0.0))


def effort(case, time):
    return np.linalg.norm(control(case[0], observe(*case[1:3], time, fly(*case)(time))))


CASE_1 = ("RendezvousController", no_guidance, (), 10800.0)
CASE_2 = ("StationKeepingController", station, ECCENTRIC, 14400.0)
LINEAR = ("RelativeTrackingController", linear_docking, ECCENTRIC, 7300.0, (3600.0, 7200.0))
QUINTIC = ("RelativeTrackingController", quintic_docking, ECCENTRIC, 7300.0, (3600.0, 7200.0))


@pytest.mark.parametrize(("case", "time", "expected", "half_digit"), [
    pytest.param(CASE_1, 600.0, 960.2, 0.05, id="1-600"),
    pytest.param(CASE_1, 3600.0, 48.25, 5e-3, id="1-3600"),
    pytest.param(CASE_1, 7200.0, 1.362, 5e-4, id="1-7200"),
    pytest.param(CASE_1, 10800.0, 0.0393, 5e-5, id="1-10800"),
    pytest.param(CASE_2, 3600.0, 41.50, 5e-3, id="2-3600"),
    pytest.param(CASE_2, 7200.0, 1.093, 5e-4, id="2-7200"),
    pytest.param(CASE_2, 14400.0, 7.2e-4, 5e-6, id="2-14400"),
    pytest.param(LINEAR, 50.0, 4.12, 5e-3, id="3-linear-50"),
    pytest.param(LINEAR, 3650.0, 6.44, 5e-3, id="3-linear-3650"),
    pytest.param(LINEAR, 7199.999999, 0.180, 5e-4, id="3-linear-7200"),
    pytest.param(QUINTIC, 7200.0, 4.4e-5, 5e-7, id="3-quintic-7200"),
])
def test_the_error_is_the_computed_one(case, time, expected, half_digit):
    assert error(case, time) == pytest.approx(expected, abs=half_digit)


@pytest.mark.parametrize(("case", "expected"), [
    pytest.param(CASE_1, 0.1732, id="1"), pytest.param(CASE_2, 0.1581, id="2"),
    pytest.param(LINEAR, 0.0677, id="3-linear"), pytest.param(QUINTIC, 4.82e-3, id="3-quintic"),
])
def test_the_peak_acceleration_is_the_computed_one(case, expected):
    peak = max(effort(case, t) for t in EVERY_TEN)
    assert peak == pytest.approx(expected, rel=2e-3)  # printed digits


@pytest.mark.parametrize(("case", "integral", "coarse"), [
    pytest.param(CASE_1, 8.389, 8.530, id="1"), pytest.param(CASE_2, 8.276, 8.404, id="2"),
    pytest.param(QUINTIC, 8.493, 8.493, id="3-quintic"),
])
def test_the_velocity_change_is_the_integral_of_the_acceleration(case, integral, coarse):
    times = np.arange(0.0, case[3] + 1.0, 10.0)
    assert fly(*case)(case[3])[6] == pytest.approx(integral, abs=5e-4)
    # what a sum of samples every 10 s makes of it
    assert np.trapezoid([effort(case, t) for t in times], times) == pytest.approx(coarse, abs=1e-3)


def test_the_quintic_docking_stays_within_millimetres():
    assert max(error(QUINTIC, t) for t in EVERY_TEN) == pytest.approx(3.7e-3, abs=5e-5)


def test_the_linear_docking_arrives_at_the_computed_speed():
    known = observe(linear_docking, ECCENTRIC, 7200.0, fly(*LINEAR)(7200.0))
    assert np.linalg.norm(known["velocity"]) == pytest.approx(0.481, abs=5e-4)


def test_the_spherical_law_flies_the_turn_as_the_rectangular_one():
    """Down to where the range is still far from 0; both errors are those of the linearisation."""
    spherical = ("SphericalTrackingController", quintic_docking, ECCENTRIC, 4800.0, (3600.0,))
    assert max(error(spherical, t) for t in np.arange(0.0, 4800.0, 50.0)) < 5e-3


def test_the_lyapunov_function_of_the_rendezvous_falls_at_its_rate():
    times = np.arange(20.0, 3600.0, 20.0)

    def watch(t):
        known = observe(no_guidance, (), t, fly(*CASE_1)(t))
        return evaluate(MONITOR, with_potential=1.0, **{
            n: known[n] for n in ("position", "velocity", "orbit_rate", "gravity_gradient")})

    slope = [(watch(t + 0.1)["lyapunov"] - watch(t - 0.1)["lyapunov"]) / 0.2 for t in times]
    rate = [watch(t)["lyapunov_rate"] for t in times]
    assert np.all(np.array(rate) < 0.0)
    # the linearisation leaves 2e-4 of the gravity difference
    np.testing.assert_allclose(slope, rate, rtol=2e-3)
