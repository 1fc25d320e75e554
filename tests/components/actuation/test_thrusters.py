"""Allocation and cluster are inverse to each other; the allocation is the pseudo-inverse."""

import numpy as np
import pytest

from sightline.components.actuation.thruster_allocation import ThrusterAllocation
from sightline.components.actuation.thruster_cluster import ThrusterCluster
from sightline.components.actuation.thruster_geometry import (
    control_sensitivity,
    default_directions,
    default_positions,
)

RNG = np.random.default_rng(5)
WRENCHES = list(RNG.standard_normal((5, 6)))
OFFSET = np.array([0.05, -0.03, 0.02])  # m, centre of mass


def geometry(thrusters):
    """A random geometry of that many thrusters."""
    directions = RNG.standard_normal((thrusters, 3))
    return {"positions": RNG.standard_normal((thrusters, 3)),
            "directions": directions / np.linalg.norm(directions, axis=1, keepdims=True),
            "center_of_mass": OFFSET}


LAYOUTS = [
    pytest.param({"positions": default_positions(12), "directions": default_directions(12),
                  "center_of_mass": OFFSET}, id="twelve"),
    pytest.param(geometry(6), id="random six"),
    pytest.param(geometry(20), id="random twenty"),
]


def allocate(layout, wrench):
    block = ThrusterAllocation(thrusters=len(layout["positions"]))
    values = layout | {"force": wrench[:3], "torque": wrench[3:]}
    return block.evaluate("outputs", block.start_values() | values)["command"]


def push(layout, command):
    block = ThrusterCluster(thrusters=len(layout["positions"]))
    wrench = block.evaluate("outputs", block.start_values() | layout | {"command": command})
    return np.concatenate([wrench["force"], wrench["torque"]])


def refused(block, **values):
    conditions = block.evaluate("requirements", block.start_values() | values)
    return [message for message, holds in conditions.items() if not holds]


@pytest.mark.parametrize("wrench", WRENCHES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_cluster_gives_the_wrench_that_was_allocated(layout, wrench):
    np.testing.assert_allclose(push(layout, allocate(layout, wrench)), wrench, atol=1e-13)


@pytest.mark.parametrize("wrench", WRENCHES)
@pytest.mark.parametrize("layout", LAYOUTS)
def test_the_allocation_is_the_formula_of_the_paper(layout, wrench):
    B = control_sensitivity(**layout)
    expected = B.T @ np.linalg.inv(B @ B.T) @ wrench
    np.testing.assert_allclose(allocate(layout, wrench), expected, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_no_other_command_for_the_wrench_is_smaller(layout):
    command = allocate(layout, WRENCHES[0])
    B = control_sensitivity(**layout)
    others = np.eye(len(command)) - np.linalg.pinv(B) @ B  # projects on commands without effect
    np.testing.assert_allclose(others @ command, 0.0, atol=1e-13)


def test_a_thruster_pushes_along_its_direction_with_the_lever_from_the_centre_of_mass():
    layout = {"positions": np.array([[1.0, 2.0, 3.0]]), "directions": np.array([[0.0, 0.0, 1.0]]),
              "center_of_mass": np.array([0.5, 0.0, 0.0])}
    np.testing.assert_array_equal(push(layout, np.array([2.0])), [0.0, 0.0, 2.0, 4.0, -1.0, 0.0])


def test_the_default_layout_has_two_thrusters_in_each_direction():
    directions, counts = np.unique(default_directions(12), axis=0, return_counts=True)
    assert (len(directions), set(counts)) == (6, {2})


def test_the_default_thrusters_push_towards_the_side_opposite_to_theirs():
    outwards = np.sum(default_positions(12) * default_directions(12), axis=1)
    np.testing.assert_array_equal(outwards, np.full(12, -1.0))


@pytest.mark.parametrize("block", [ThrusterAllocation, ThrusterCluster])
def test_another_number_of_thrusters_needs_a_geometry(block):
    assert refused(block(thrusters=8))[0] == (
        "directions must be unit vectors (for other than 12 thrusters, give positions and "
        "directions)"
    )


@pytest.mark.parametrize("block", [ThrusterAllocation, ThrusterCluster])
def test_another_number_of_thrusters_passes_the_check(block):
    block(thrusters=8).check()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_a_full_geometry_is_accepted_at_any_size(scale):
    assert refused(ThrusterAllocation(), positions=scale * default_positions(12)) == []


@pytest.mark.parametrize("positions", [
    pytest.param(np.zeros((12, 3)), id="no torque"),
    pytest.param(default_positions(12) * [1.0, 0.0, 1.0], id="no torque about z"),
])
def test_a_geometry_without_authority_about_an_axis_is_refused(positions):
    assert refused(ThrusterAllocation(), positions=positions) == [
        "positions and directions must give force and torque about all axes"
    ]
