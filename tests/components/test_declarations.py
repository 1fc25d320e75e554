"""Every mistake in a declaration is an error that names the component and the port."""

import numpy as np
import pytest

from sightline.components import (
    Component,
    DeclarationError,
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    SamplePeriod,
    State,
    Structure,
)


def duplicate():
    class Twice(Component):
        force = Input(3, "N")
        force = Output(3, "N")


def quantity_named_as_equation():
    class Shadow(Component):
        outputs = Input(3, "N")


def reserved_name():
    class Clock(Component):
        time = Input((), "s")


def name_of_the_base_class():
    class Shadow(Component):
        name = Parameter((), "1")


def missing_unit():
    class Scale(Component):
        mass = Parameter(())


def undeclared_size():
    class Cluster(Component):
        thruster = Structure(12)
        command = Input("thrusters", "N")


def unknown_argument():
    class Spring(Component):
        stiffness = Parameter((), "N/m")
        force = Output((), "N")

        def outputs(self, stifness):
            return {"force": stifness}


def noise_in_derivatives():
    class Walk(Component):
        sample_period = SamplePeriod()
        white = Noise()
        angle = State((), "rad")

        def derivatives(self, white):
            return {"angle": white}


def output_without_method():
    class Silent(Component):
        force = Output(3, "N")


def state_without_method():
    class Still(Component):
        position = State(3, "m")


def discrete_state_without_period():
    class Counter(Component):
        count = DiscreteState((), "1")

        def update(self, count):
            return {"count": count + 1}


def noise_without_period():
    class Noisy(Component):
        white = Noise()


def period_of_another_name():
    class Sampled(Component):
        period = SamplePeriod()


@pytest.mark.parametrize(("declare", "message"), [
    (duplicate, "Twice.force: declared twice; give each quantity a name of its own"),
    (quantity_named_as_equation,
     "Shadow.outputs: is the name of an equation method; rename the quantity"),
    (reserved_name, "Clock.time: this name is reserved; choose another"),
    (name_of_the_base_class, "Shadow.name: this name is reserved; choose another"),
    (missing_unit, 'Scale.mass: unit is missing; give an SI unit, or "1" for none'),
    (undeclared_size,
     "Cluster.command: size 'thrusters' is not a declared structure; did you mean 'thruster'?"),
    (unknown_argument,
     "Spring.outputs: asks for 'stifness', which it cannot receive; did you mean 'stiffness'?"),
    (noise_in_derivatives, "Walk.derivatives: asks for 'white', which it cannot receive; "
                           "valid are angle, sample_period, time"),
    (output_without_method,
     "Silent.force: the block has no method outputs; write outputs(self, ...)"),
    (state_without_method,
     "Still.position: the block has no method derivatives; write derivatives(self, ...)"),
    (discrete_state_without_period,
     "Counter.count: changes at ticks, but the block has no sample period; "
     "declare sample_period = SamplePeriod()"),
    (noise_without_period, "Noisy.white: changes at ticks, but the block has no sample period; "
                           "declare sample_period = SamplePeriod()"),
    (period_of_another_name, "Sampled.period: a SamplePeriod must be named sample_period"),
])
def test_a_mistake_in_the_class_body_is_an_error_at_class_creation(declare, message):
    with pytest.raises(DeclarationError) as caught:
        declare()
    assert str(caught.value) == message


def block(outputs=lambda _: {"force": np.zeros(3)}, **declarations):
    """A block with the output force of shape 3."""
    body = {"force": Output(3, "N"), "outputs": outputs, **declarations}
    return type(Component)("Block", (Component,), body)


@pytest.mark.parametrize(("outputs", "message"), [
    (lambda _: {"force": np.zeros(2)},
     "Block.force: outputs returns shape (2,), declared is (3,)"),
    (lambda _: {}, "Block.force: not returned by outputs; "
                      "add it to the dict that outputs returns"),
    (lambda _: {"force": np.zeros(3), "forse": 1.0},
     "Block.forse: returned by outputs but not declared as such; did you mean 'force'?"),
    (lambda _: np.zeros(3), "Block.outputs: returns ndarray; return a dict by name"),
])
def test_a_wrong_result_is_an_error_at_the_first_check(outputs, message):
    with pytest.raises(DeclarationError) as caught:
        block(outputs)().check()
    assert str(caught.value) == message


def test_a_requirement_must_be_a_single_condition():
    vague = block(requirements=lambda _: {"force must be finite": np.ones(3) > 0.0})
    with pytest.raises(DeclarationError, match=r"^Block.requirements: 'force must be finite' is "
                                               "not a single condition; reduce it"):
        vague().check()


@pytest.mark.parametrize(("declaration", "message"), [
    (Parameter(3, "m", (1.0, 2.0)), "Block.size: start value has shape (2,), declared is (3,)"),
    (Parameter((), "m", -1.0, min=0.0), "Block.size: start value is below min = 0"),
    (Parameter((), "m", 2.0, max=1.0), "Block.size: start value is above max = 1"),
    (Parameter((), "m", lambda thruster: thruster),
     "Block.size: start asks for 'thruster'; did you mean 'thrusters'?"),
])
def test_a_start_value_must_fit_its_declaration(declaration, message):
    with pytest.raises(DeclarationError) as caught:
        block(thrusters=Structure(12), size=declaration)()
    assert str(caught.value) == message


@pytest.mark.parametrize(("structure", "message"), [
    ({"thruster": 4}, "Block.thruster: no such structure; did you mean 'thrusters'?"),
    ({"thrusters": 0}, "Block.thrusters: 0 is not an integer >= 1"),
    ({"thrusters": 2.5}, "Block.thrusters: 2.5 is not an integer >= 1"),
])
def test_a_wrong_structure_is_an_error_when_it_is_bound(structure, message):
    with pytest.raises(DeclarationError) as caught:
        block(thrusters=Structure(12))(**structure)
    assert str(caught.value) == message
