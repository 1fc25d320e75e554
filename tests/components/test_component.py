"""What a declared block offers."""

import numpy as np
import pytest

from sightline.components import (
    Component,
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    SamplePeriod,
    State,
    Structure,
)


class Everything(Component):
    """One of each."""

    axes = Structure(2)
    command = Input("axes", "N", 0.5)
    gain = Parameter((), "1", 3.0)
    offsets = Parameter(("axes", 2), "N", lambda axes: np.arange(2 * axes).reshape(axes, 2))
    speed = State("axes", "m/s", output=True)
    memory = DiscreteState("axes", "N")
    white = Noise("axes")
    thrust = Output("axes", "N")
    sample_period = SamplePeriod(start=0.1)

    def derivatives(self, command):
        return {"speed": command}

    def outputs(self, command, gain, memory, white, time):
        return {"thrust": gain * command + memory + white + time}

    def update(self, command, axes):
        return {"memory": command * axes}


def test_the_structure_sets_the_shapes():
    assert Everything(axes=4).quantities["offsets"].dimensions == (4, 2)


def test_one_binding_of_the_structure_leaves_another_alone():
    Everything(axes=4)
    assert Everything().quantities["command"].dimensions == (2,)


def test_a_number_as_start_value_fills_the_shape():
    np.testing.assert_array_equal(Everything(axes=3).start_values()["command"], [0.5, 0.5, 0.5])


def test_a_start_value_may_be_computed_from_the_structure():
    np.testing.assert_array_equal(Everything().start_values()["offsets"], [[0, 1], [2, 3]])


def test_outputs_are_states_marked_as_such_then_outputs():
    assert list(Everything().outputs_) == ["speed", "thrust"]


def test_an_equation_receives_what_it_names():
    assert Everything().arguments("outputs") == ("command", "gain", "memory", "white", "time")


def test_an_equation_may_use_the_structure():
    block = Everything()
    np.testing.assert_array_equal(block.evaluate("update", block.start_values())["memory"], [1, 1])


def test_a_block_with_a_sample_period_is_sampled():
    assert Everything().sampled


def test_a_right_block_passes_its_check():
    Everything().check()


def test_a_subclass_inherits_declarations_and_equations():
    class More(Everything):
        extra = Input((), "1")

    assert list(More().inputs_) == ["command", "extra"]


@pytest.mark.parametrize("equation", ["derivatives", "outputs", "update"])
def test_a_block_has_the_equations_it_defines(equation):
    assert Everything().has(equation)


def test_a_block_lacks_the_equations_it_does_not_define():
    assert not Everything().has("project")
