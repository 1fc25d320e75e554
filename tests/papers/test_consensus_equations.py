"""Examples 1 to 3 of the attitude consensus paper, and what is beyond it, in plain numpy.

The blocks are wired by hand and integrated by scipy at tight tolerance. The expected figures come
from an independent integration of the same equations; example 2 has a closed form.
"""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sightline.components.controllers.attitude_consensus_controller import (
    AttitudeConsensusController,
)
from sightline.components.dynamics.free_rigid_body import FreeRigidBody
from sightline.components.maths import rotate
from sightline.components.monitors.attitude_consensus_monitor import AttitudeConsensusMonitor

BODY = FreeRigidBody()
DEFAULTS = BODY.start_values()
INERTIA = np.diag([5.0, 4.0, 1.0])
R = np.sqrt(0.5)
EXAMPLE_1 = ((0.0, 0.0, R, R, -R, 1.0, 0.0), (0.0, 0.0, 0.0, 1.0, 1.0, R, 0.0))
EXAMPLE_2 = ((0.0, 0.0, R, R, 0.5, 0.0, 0.0), (0.0, R, 0.0, R, 0.0, 0.3, 0.0))
RNG = np.random.default_rng(4)
RANDOM = np.concatenate([RNG.standard_normal((5, 4)), 0.5 * RNG.standard_normal((5, 3))], axis=1)
RANDOM[:, :4] /= np.linalg.norm(RANDOM[:, :4], axis=1, keepdims=True)
GROUP = tuple(map(tuple, RANDOM))
NEAR = RANDOM * [0.2, 0.2, 0.2, 0.0, 0.2, 0.2, 0.2] + [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]
NEAR[:, :4] /= np.linalg.norm(NEAR[:, :4], axis=1, keepdims=True)
TOGETHER = tuple(map(tuple, NEAR))
PAIR = ((1,), (0,))  # neighbours of each craft
RING = ((4, 1), (0, 2), (1, 3), (2, 4), (3, 0))
STAR = ((1, 2, 3, 4), (0,), (0,), (0,), (0,))
AVERAGE, PER_EDGE, NEARER = (), (("per_edge", 1.0),), (("nearer_sign", 1.0),)
DAMPED = (("spring_gain", 0.0),)
SWITCHED = (("switch_time", 30.0),)


def adjacency(graph):
    matrix = np.zeros((len(graph), len(graph)))
    for i, neighbours in enumerate(graph):
        matrix[i, list(neighbours)] = 1.0
    return matrix


def options(settings):
    return {name: np.array(value) for name, value in settings}


@cache
def controller(neighbours):
    block = AttitudeConsensusController(neighbours=neighbours)
    return block, block.start_values()


def torque(t, x, own, neighbours, settings):
    block, defaults = controller(len(neighbours))
    others = x[list(neighbours)]
    return block.evaluate("outputs", defaults | options(settings) | {
        "attitude": x[own, :4], "angular_velocity": x[own, 4:], "time": np.array(t),
        "neighbour_attitudes": others[:, :4], "neighbour_angular_velocities": others[:, 4:],
    })["torque"]


def rate(t, x, graph, settings):
    rates = []
    for own, neighbours in enumerate(graph):
        change = BODY.evaluate("derivatives", DEFAULTS | {
            "inertia": INERTIA, "attitude": x[own, :4], "angular_velocity": x[own, 4:],
            "torque": torque(t, x, own, neighbours, settings)})
        rates.append(np.concatenate([change["attitude"], change["angular_velocity"]]))
    return np.stack(rates)


@cache
def fly(start, graph, settings, duration, stops=()):
    """States at any time; integrated anew from each stop, where the law may switch."""
    pieces, x = [], np.array(start).ravel()
    for begin, end in zip((0.0, *stops), (*stops, duration), strict=True):
        piece = solve_ivp(lambda t, x: rate(t, x.reshape(-1, 7), graph, settings).ravel(),
                          (begin, end), x, "DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
        pieces.append((end, piece.sol))
        x = piece.y[:, -1]
    return lambda t: next(sol for end, sol in pieces if t <= end)(t).reshape(-1, 7)


def watch(x, graph=PAIR, settings=()):
    monitor = AttitudeConsensusMonitor(craft=len(graph))
    chosen = {n: v for n, v in options(settings).items() if n in monitor.quantities}
    return monitor.evaluate("outputs", monitor.start_values() | chosen | {
        "attitudes": x[:, :4], "angular_velocities": x[:, 4:], "inertia": INERTIA,
        "adjacency": adjacency(graph)})


def momentum(x):
    return sum(rotate(craft[:4], INERTIA @ craft[4:]) for craft in x)


@pytest.mark.parametrize(("time", "angle"), [
    (1.0, 2.022402), (5.0, 2.294547), (10.0, 0.4249535), (15.0, 0.2609871), (30.0, 0.0458350),
    (60.0, 1.61364e-3), (100.0, 1.790e-5),
])
def test_example_1_has_the_computed_relative_angle(time, angle):
    x = fly(EXAMPLE_1, PAIR, AVERAGE, 100.0)(time)
    assert watch(x)["relative_angle"] == pytest.approx(angle, rel=4e-4, abs=1e-9)


@pytest.mark.parametrize("time", [0.0, 10.0, 100.0])
def test_example_1_keeps_its_angular_momentum(time):
    x = fly(EXAMPLE_1, PAIR, AVERAGE, 100.0)(time)
    np.testing.assert_allclose(watch(x)["angular_momentum"], [1.0, -R, 0.0], atol=1e-10)


@pytest.mark.parametrize("time", [0.0, 1.0, 10.0, 30.0, 60.0])
def test_example_2_has_its_closed_form(time):
    x = fly(EXAMPLE_2, PAIR, DAMPED, 60.0)(time)
    decay = 0.2 * np.exp(-0.45 * time)
    expected = [[3.7 / 9.0 + 4.0 / 9.0 * decay, 0.0, 0.0],
                [0.0, 3.7 / 9.0 - 5.0 / 9.0 * decay, 0.0]]
    np.testing.assert_allclose(x[:, 4:], expected, atol=1e-7)  # round-off grows as e^(0.156 t)


@pytest.mark.parametrize(("time", "angle"), [
    (1.0, 2.004044), (5.0, 1.882201), (10.0, 1.862154), (15.0, 1.860071), (30.0, 1.859826),
    (60.0, 4.55213e-3), (100.0, 6.92e-6),
])
def test_example_3_has_the_computed_relative_angle(time, angle):
    x = fly(EXAMPLE_2, PAIR, SWITCHED, 100.0, (30.0,))(time)
    assert watch(x)["relative_angle"] == pytest.approx(angle, rel=7e-4)


def test_example_3_ends_in_tumbling_not_in_rotation_about_a_fixed_axis():
    x = fly(EXAMPLE_2, PAIR, SWITCHED, 100.0, (30.0,))
    axes = [np.abs(x(t)[0, 4:]) / np.linalg.norm(x(t)[0, 4:]) for t in (80.0, 85.0, 90.0, 100.0)]
    assert np.ptp(axes, axis=0).max() > 0.1


@pytest.mark.parametrize(("graph", "settings"), [
    (RING, AVERAGE), (RING, PER_EDGE), (RING, NEARER), (STAR, PER_EDGE),
])
def test_the_angular_momentum_stays_on_regular_graphs_and_per_edge(graph, settings):
    x = fly(GROUP, graph, settings, 20.0)
    np.testing.assert_allclose(momentum(x(20.0)), momentum(x(0.0)), atol=1e-9)


def test_on_a_star_the_neighbour_average_does_not_keep_the_plain_momentum():
    x = fly(GROUP, STAR, AVERAGE, 20.0)
    assert np.linalg.norm(momentum(x(20.0)) - momentum(x(0.0))) > 0.1


@pytest.mark.parametrize("graph", [RING, STAR])
@pytest.mark.parametrize("settings", [AVERAGE, PER_EDGE])
def test_the_weighted_momentum_stays_on_any_graph(graph, settings):
    x = fly(GROUP, graph, settings, 20.0)
    before, after = (watch(x(t), graph, settings)["weighted_momentum"] for t in (0.0, 20.0))
    np.testing.assert_allclose(after, before, atol=1e-9)


@pytest.mark.parametrize("graph", [RING, STAR])
@pytest.mark.parametrize("settings", [AVERAGE, PER_EDGE, NEARER, NEARER + PER_EDGE, DAMPED,
                                      (("spring_gain", 0.3), ("damping_gain", 0.7))])
def test_the_energy_falls_as_its_corrected_formula_says(graph, settings):
    h, x = 1e-5, np.array(GROUP)  # s; central difference, error h² H'''/6
    direction = rate(0.0, x, graph, settings)
    ahead, behind = (watch(x + s * h * direction, graph, settings)["energy"] for s in (1.0, -1.0))
    expected = watch(x, graph, settings)["energy_rate"]
    assert (ahead - behind) / (2.0 * h) == pytest.approx(expected, abs=1e-7)


def test_a_ring_of_five_reaches_consensus_from_attitudes_on_one_side():
    x = fly(TOGETHER, RING, AVERAGE, 200.0)(200.0)
    assert watch(x, RING)["relative_angle"] < 1e-3


def test_a_ring_of_five_may_stay_twisted_with_the_nearer_sign():
    x = fly(GROUP, RING, NEARER, 200.0)(200.0)  # the theorem's consensus is not global
    assert watch(x, RING)["relative_angle"] > 2.0 * np.pi / 5.0


def test_the_sign_of_a_quaternion_changes_the_motion_of_the_paper():
    other = (EXAMPLE_1[0], (0.0, 0.0, 0.0, -1.0, *EXAMPLE_1[1][4:]))
    first, second = (fly(start, PAIR, AVERAGE, 5.0)(5.0) for start in (EXAMPLE_1, other))
    assert np.abs(first[:, 4:] - second[:, 4:]).max() > 0.1


def test_with_the_nearer_sign_the_sign_of_a_quaternion_does_not_matter():
    other = (EXAMPLE_1[0], (0.0, 0.0, 0.0, -1.0, *EXAMPLE_1[1][4:]))
    first, second = (fly(start, PAIR, NEARER, 5.0)(5.0) for start in (EXAMPLE_1, other))
    np.testing.assert_allclose(first[:, 4:], second[:, 4:], atol=1e-10)


def test_before_the_switch_the_damping_only_acts():
    x = np.array(EXAMPLE_1)
    np.testing.assert_array_equal(torque(29.9, x, 0, (1,), SWITCHED),
                                  torque(0.0, x, 0, (1,), DAMPED))


def test_from_the_switch_on_the_spring_acts_too():
    x = np.array(EXAMPLE_1)
    np.testing.assert_array_equal(torque(30.0, x, 0, (1,), SWITCHED), torque(0.0, x, 0, (1,), ()))
