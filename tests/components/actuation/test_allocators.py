"""Allocators against scipy: the wrench where it can be reached, optimal commands, reports."""

import numpy as np
import pytest
from scipy.optimize import linprog, lsq_linear, minimize, nnls

from sightline.components import catalogue
from sightline.components.actuation.thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
    row_lengths,
)

CENTER = np.array([0.05, -0.03, 0.02])  # m
B = control_sensitivity(default_positions(12), default_directions(12), CENTER)
S = 1.0 / row_lengths(B)
RNG = np.random.default_rng(7)
WRENCHES = list(RNG.standard_normal((50, 6)))
AXES = [sign * axis for axis in np.eye(6) for sign in (1.0, -1.0)]
SCALES = [1e-6, 1e3]
ONE_SIDED = ["ShiftedThrusterAllocation", "NonNegativeThrusterAllocation",
             "BoundedThrusterAllocation", "LeastPropellantThrusterAllocation"]
LIMITED = ONE_SIDED[2:]
ALL = ["ThrusterAllocation", *ONE_SIDED]
LOST = np.where(np.arange(12) == 0, 0.0, 1.0)  # the first +x thruster does not work
EVERY = np.ones(12)
REACH = 1e-9  # what every one-sided allocator promises


def allocate(name, wrench, **values):
    block = catalogue.find(name)()
    ports = {"force": wrench[:3], "torque": wrench[3:], "center_of_mass": CENTER}
    return block.evaluate("outputs", block.start_values() | ports | values)


def cheapest(wrench, limit=None, healthy=EVERY, cost=EVERY):
    """scipy's linear programme."""
    return linprog(cost, A_eq=B * healthy, b_eq=wrench, bounds=(0.0, limit), method="highs")


@pytest.mark.parametrize("wrench", [*WRENCHES, *AXES])
@pytest.mark.parametrize("name", ONE_SIDED)
def test_a_one_sided_allocator_reaches_the_wrench(name, wrench):
    command = allocate(name, wrench)["command"]
    np.testing.assert_allclose(B @ command, wrench, atol=REACH)


@pytest.mark.parametrize("wrench", [*WRENCHES, *AXES])
@pytest.mark.parametrize("name", ONE_SIDED)
def test_a_one_sided_allocator_only_pushes(name, wrench):
    assert allocate(name, wrench)["command"].min() >= 0.0


@pytest.mark.parametrize("scale", SCALES)
@pytest.mark.parametrize("name", ONE_SIDED)
def test_the_size_of_the_wrench_does_not_matter(name, scale):
    command = allocate(name, scale * WRENCHES[0])["command"]
    np.testing.assert_allclose(command / scale, allocate(name, WRENCHES[0])["command"], atol=1e-8)


@pytest.mark.parametrize("name", ALL)
def test_no_wrench_asks_for_no_thrust(name):
    np.testing.assert_allclose(allocate(name, np.zeros(6))["command"], 0.0, atol=1e-12)


@pytest.mark.parametrize("wrench", [*WRENCHES, *AXES])
def test_least_propellant_uses_no_more_than_a_linear_programme(wrench):
    used = allocate("LeastPropellantThrusterAllocation", wrench)["command"].sum()
    assert used <= cheapest(wrench).fun + 1e-6


def canted(angle):
    """The default layout with each thruster of a pair turned to either side."""
    directions = default_directions(12)
    sideways = np.roll(directions, -1, axis=1) * np.tile([1.0, -1.0], 6)[:, None]
    return np.cos(angle) * directions + np.sin(angle) * sideways


@pytest.mark.parametrize("name", LIMITED)
def test_wrenches_of_many_sizes_are_reached_by_a_canted_layout_with_a_thruster_lost(name):
    rng, directions = np.random.default_rng(4), canted(np.pi / 6.0)
    sensitivity = control_sensitivity(default_positions(12), directions, CENTER)
    reached = 0
    for k in range(60):  # some have an optimum close to which the programme is singular
        wrench = 0.3 * rng.standard_normal(6) * 10.0 ** rng.uniform(-5.0, 0.0, 6)
        healthy = np.where(np.arange(12) == k % 12, 0.0, 1.0)
        best = linprog(EVERY, A_eq=sensitivity * healthy, b_eq=wrench, bounds=(0.0, 1.0))
        if best.status == 0:
            command = allocate(name, wrench, healthy=healthy, directions=directions,
                               max_thrust=EVERY)["command"]
            missing = np.linalg.norm((wrench - sensitivity @ command) / row_lengths(sensitivity))
            assert missing <= 1e-10 * np.linalg.norm(wrench / row_lengths(sensitivity))
            reached += 1
    assert reached > 30


@pytest.mark.parametrize("wrench", WRENCHES[:10])
def test_least_propellant_weighs_by_specific_impulse(wrench):
    impulse = np.linspace(60.0, 300.0, 12)  # s
    command = allocate("LeastPropellantThrusterAllocation", wrench,
                       specific_impulse=impulse)["command"]
    assert command @ (60.0 / impulse) <= cheapest(wrench, cost=60.0 / impulse).fun + 1e-6


@pytest.mark.parametrize("wrench", WRENCHES)
@pytest.mark.parametrize("name", LIMITED)
def test_limits_are_kept_and_the_wrench_reached_if_it_can_be(name, wrench):
    limit = 1.02 * least_limit(wrench)
    command = allocate(name, wrench, max_thrust=np.full(12, limit))["command"]
    np.testing.assert_allclose(B @ command, wrench, atol=REACH)
    assert command.max() <= limit


def least_limit(wrench):
    """The smallest limit, the same for all thrusters, with which the wrench can be reached."""
    above = np.hstack([np.eye(12), -np.ones((12, 1))])
    return linprog(np.eye(13)[12], A_ub=above, b_ub=np.zeros(12), b_eq=wrench,
                   A_eq=np.hstack([B, np.zeros((6, 1))]), bounds=(0.0, None)).fun


@pytest.mark.parametrize("wrench", WRENCHES[:20])
def test_least_propellant_with_limits_is_the_linear_programme(wrench):
    limit = 1.1 * least_limit(wrench)
    command = allocate("LeastPropellantThrusterAllocation", wrench,
                       max_thrust=np.full(12, limit))["command"]
    assert command.sum() <= cheapest(wrench, limit).fun + 1e-6


@pytest.mark.parametrize("wrench", WRENCHES[:10])
def test_the_bounded_allocation_has_the_least_weighted_squares(wrench):
    weights, limit = np.linspace(0.2, 1.0, 12), 1.1 * least_limit(wrench)
    command = allocate("BoundedThrusterAllocation", wrench, thrust_weights=weights,
                       max_thrust=np.full(12, limit))["command"]
    best = minimize(lambda F: F @ (weights * F), np.full(12, 0.5 * limit), method="SLSQP",
                    jac=lambda F: 2.0 * weights * F, bounds=[(0.0, limit)] * 12,
                    constraints={"type": "eq", "fun": lambda F: B @ F - wrench,
                                 "jac": lambda F: B}, options={"ftol": 1e-12, "maxiter": 500})
    assert command @ (weights * command) <= best.fun + 1e-6


@pytest.mark.parametrize("wrench", WRENCHES)
def test_the_non_negative_residual_is_that_of_scipy_when_a_thruster_is_lost(wrench):
    allocated = allocate("NonNegativeThrusterAllocation", wrench, healthy=LOST)
    missing = np.concatenate([allocated["residual_force"], allocated["residual_torque"]])
    _, expected = nnls((B * LOST) * S[:, None], wrench * S)
    assert np.linalg.norm(missing * S) == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("wrench", WRENCHES)
@pytest.mark.parametrize("name", LIMITED)
def test_out_of_reach_the_residual_is_the_least_sum_of_components(name, wrench):
    limit = 0.5 * least_limit(wrench)
    allocated = allocate(name, wrench, max_thrust=np.full(12, limit))
    missing = np.concatenate([allocated["residual_force"], allocated["residual_torque"]])
    both = np.hstack([B * S[:, None], np.eye(6), -np.eye(6)])
    cost = np.concatenate([np.zeros(12), np.ones(12)])
    bounds = [(0.0, limit)] * 12 + [(0.0, None)] * 12
    expected = linprog(cost, A_eq=both, b_eq=wrench * S, bounds=bounds).fun
    slack = {"BoundedThrusterAllocation": 0.02, "LeastPropellantThrusterAllocation": 0.02}[name]
    assert np.abs(missing * S).sum() <= expected + slack * limit  # the thrust's cost counts a bit


@pytest.mark.parametrize("name", ALL)
def test_without_a_thruster_that_works_nothing_is_given(name):
    allocated = allocate(name, WRENCHES[0], healthy=np.zeros(12))
    np.testing.assert_array_equal(allocated["command"], 0.0)
    np.testing.assert_array_equal(allocated["residual_force"], WRENCHES[0][:3])
    assert allocated["lost_authority"] == pytest.approx(1.0)


@pytest.mark.parametrize("wrench", WRENCHES[:20])
@pytest.mark.parametrize("name", ALL)
def test_a_lost_thruster_is_not_commanded(name, wrench):
    assert allocate(name, wrench, healthy=LOST)["command"][0] == 0.0


@pytest.mark.parametrize("wrench", WRENCHES[:20])
@pytest.mark.parametrize("name", ["NonNegativeThrusterAllocation", *LIMITED])
def test_the_wrench_is_still_reached_where_the_other_thrusters_can(name, wrench):
    reachable = cheapest(wrench, healthy=LOST).status == 0
    lost = allocate(name, wrench, healthy=LOST)["lost_authority"]
    assert (lost < REACH) == reachable


@pytest.mark.parametrize("name", ["ThrusterAllocation", "ShiftedThrusterAllocation"])
def test_an_axis_that_is_lost_leaves_the_others(name):
    healthy = np.concatenate([np.zeros(4), np.ones(8)])  # no thruster along x, no torque about z
    allocated = allocate(name, np.array([1.0, 1.0, 0.0, 0.0, 0.0, 0.0]), healthy=healthy,
                         center_of_mass=np.zeros(3))
    np.testing.assert_allclose(allocated["residual_force"], [1.0, 0.0, 0.0], atol=1e-6)


@pytest.mark.parametrize("name", ALL)
def test_the_report_is_what_the_command_leaves(name):
    allocated = allocate(name, WRENCHES[3], max_thrust=np.full(12, 0.3), healthy=LOST)
    missing = WRENCHES[3] - B @ allocated["command"]
    reported = np.concatenate([allocated["residual_force"], allocated["residual_torque"]])
    np.testing.assert_allclose(reported, missing, atol=1e-8)  # less is reported as none
    expected = np.linalg.norm(missing * S) / np.linalg.norm(WRENCHES[3] * S)
    assert allocated["lost_authority"] == pytest.approx(expected)


@pytest.mark.parametrize("name", ALL)
def test_a_wrench_that_is_reached_leaves_no_residual(name):
    allocated = allocate(name, WRENCHES[3])
    np.testing.assert_array_equal(allocated["residual_force"], 0.0)
    np.testing.assert_array_equal(allocated["residual_torque"], 0.0)


@pytest.mark.parametrize("name", ALL)
def test_a_thruster_at_its_limit_is_reported(name):
    allocated = allocate(name, WRENCHES[3], max_thrust=np.full(12, 0.2))
    np.testing.assert_array_equal(allocated["saturated"],
                                  np.abs(allocated["command"]) >= 0.2 * (1.0 - 1e-6))
    assert allocated["saturated"].any()


def test_of_all_shifts_the_smallest_is_taken():
    command = allocate("ShiftedThrusterAllocation", WRENCHES[0])["command"]
    assert [group.min() for group in np.split(command, 3)] == pytest.approx([0.0] * 3, abs=1e-15)


def test_shifts_that_give_a_wrench_are_refused():
    block = catalogue.find("ShiftedThrusterAllocation")()
    conditions = block.evaluate("requirements", block.start_values() | {"shifts": np.eye(3, 12)})
    assert [m for m, holds in conditions.items() if not holds] == [
        "each row of shifts must give no wrench"]


def test_a_component_of_small_weight_is_given_up_first():
    wrench = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.5])
    allocated = allocate("BoundedThrusterAllocation", wrench, max_thrust=np.full(12, 0.3),
                         torque_weights=np.full(3, 0.05))
    best = lsq_linear(B[:1], wrench[:1], bounds=(0.0, 0.3)).x
    assert (B @ allocated["command"])[0] == pytest.approx((B @ best)[0], abs=1e-6)
