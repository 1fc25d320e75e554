"""What controllers and estimators demand of lines of sight."""

import numpy as np
import pytest

from sightline.components import catalogue

BLOCKS = ["LineOfSightAttitudeController", "RelativeAttitudeController",
          "RelativeAttitudeDetermination"]


def refused(name, **values):
    block = catalogue.find(name)()
    numbers = {n: np.asarray(v, float) for n, v in values.items()}
    conditions = block.evaluate("requirements", block.start_values() | numbers)
    return [message for message, holds in conditions.items() if not holds]


@pytest.mark.parametrize("port", ["line_of_sight", "target_line_of_sight", "object_line_of_sight",
                                  "target_object_line_of_sight"])
@pytest.mark.parametrize("block", BLOCKS)
def test_a_line_of_sight_must_be_a_unit_vector(block, port):
    assert f"{port} must be a unit vector" in refused(block, **{port: [1.0, 1.0, 0.0]})


@pytest.mark.parametrize("block", BLOCKS)
def test_the_common_object_must_be_off_the_line_through_the_craft(block):
    assert refused(block, object_line_of_sight=[1.0, 0.0, 0.0]) == [
        "object_line_of_sight must not be parallel to line_of_sight"]


def test_equal_gains_are_refused():
    assert refused("RelativeAttitudeController", alignment_gain=0.5, normal_gain=0.5) == [
        "alignment_gain and normal_gain must differ"]


def test_a_neighbour_of_another_norm_is_refused():
    assert refused("AttitudeConsensusController", neighbour_attitudes=[[0.0, 0.0, 0.0, 2.0]]) == [
        "each row of neighbour_attitudes must be a unit quaternion"]


def test_a_directed_graph_is_refused():
    assert refused("AttitudeConsensusMonitor", adjacency=[[0.0, 1.0], [0.0, 0.0]]) == [
        "adjacency must be symmetric"]
