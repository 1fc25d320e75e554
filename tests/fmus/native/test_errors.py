"""Wrong values, wrong calls, broken requirements: an error that names the variable, no damage."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import byref, c_size_t

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from .conftest import Builder
from .driver import Fmi, Instance, Native


@pytest.mark.parametrize(
    ("value", "message"),
    [(np.nan, "level = nan: must be finite"), (np.inf, "level = inf: must be finite"),
     (11.0, "level = 11: must be at most 10"), (-10.5, "level = -10.5: must be at least -10")],
)  # fmt: skip
def test_a_value_out_of_range_is_refused(
    everything: Native, value: float, message: str
) -> None:
    fmu = everything.instance()
    fmu.initialise()
    fmu.set(level=2.0)
    with pytest.raises(FMICallException):
        fmu.set(level=value)
    assert ("logStatusError", message) in fmu.log
    assert fmu.get("level") == 2.0
    fmu.step(0.0, 0.1)


def test_an_element_of_a_vector_is_named(everything: Native) -> None:
    fmu = everything.instance()
    with pytest.raises(FMICallException):
        fmu.set(force=[0.0, np.nan, 0.0])
    assert "force[2] = nan" in fmu.messages


def test_a_broken_requirement_at_initialisation_is_an_error(everything: Native) -> None:
    fmu = everything.instance()
    fmu.set(level=7.0)
    fmu.enter()
    with pytest.raises(FMICallException):
        fmu.fmu.exitInitializationMode()
    assert "level must not be 7" in fmu.messages
    fmu.set(level=6.0)
    fmu.fmu.exitInitializationMode()


def test_a_period_that_would_tick_for_ever_is_refused(everything: Native) -> None:
    fmu = everything.instance()
    fmu.set(sample_period=5e-324)
    fmu.enter()
    with pytest.raises(FMICallException):
        fmu.fmu.exitInitializationMode()
    assert "must be 0 or at least 1e-06" in fmu.messages


def test_a_broken_requirement_after_a_step_is_an_error(everything: Native) -> None:
    fmu = everything.instance()
    fmu.set(speed=[999.0, 0.0, 0.0])
    fmu.initialise()
    fmu.set(force=[1e6, 0.0, 0.0])
    with pytest.raises(FMICallException):
        fmu.step(0.0, 1e-3)
    assert "speed must stay below 1000 m/s: 100 % of the limit (time 0.001 s)" in fmu.messages
    with pytest.raises(FMICallException):
        fmu.step(1e-3, 1e-3)
    assert "DoStep is not allowed here (the instance is in state: failed)" in fmu.messages


def test_an_output_that_is_not_finite_is_an_error_that_names_it(everything: Native) -> None:
    fmu = everything.instance()
    fmu.initialise()
    fmu.set(level=-1.0)  # its square root is an output
    with pytest.raises(FMICallException):
        fmu.get("pull")
    assert "pull[1] is not finite at time 0 s" in fmu.messages
    fmu.set(level=1.0)
    assert np.all(np.isfinite(fmu.get("pull")))


def test_a_rate_that_is_not_finite_is_an_error_that_names_it(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.set(position=1e150)
    fmu.initialise()
    with pytest.raises(FMICallException):
        fmu.step(0.0, 1.0)
    assert "is not finite" in fmu.messages
    assert "der(velocity)" in fmu.messages
    assert np.all(np.isfinite(fmu.all("state")))


def test_a_nan_is_not_hidden_by_the_largest_of_several_values(native: Builder) -> None:
    source = (native("Everything", 2).folder / "sources" / "equations.c").read_text()
    assert "#define fmax larger" in source


@pytest.mark.parametrize(
    ("time", "h"), [(0.1, 0.1), (-0.1, 0.1), (0.0, -0.1), (np.nan, 0.1), (0.0, np.nan),
                    (0.0, np.inf)],
)  # fmt: skip
def test_a_step_from_elsewhere_or_backwards_is_refused(
    oscillator: Native, time: float, h: float
) -> None:
    fmu = oscillator.instance()
    fmu.initialise()
    before = fmu.all("state")
    with pytest.raises(FMICallException):
        fmu.step(time, h)
    assert "internal time is 0 s" in fmu.messages
    np.testing.assert_array_equal(fmu.all("state"), before)


def test_a_step_past_the_stop_time_is_refused(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.initialise(stop=1.0)
    fmu.step(0.0, 1.0)
    with pytest.raises(FMICallException):
        fmu.step(1.0, 0.1)
    assert "goes past the stop time 1 s" in fmu.messages


WRONG_CALLS: dict[str, tuple[Callable[[Instance], object], Callable[[Instance], object], str]] = {
    "step before initialisation": (
        lambda f: None, lambda f: f.step(0.0, 0.1), "instantiated"),
    "step in initialisation": (
        lambda f: f.enter(), lambda f: f.step(0.0, 0.1), "initialization mode"),
    "exit without enter": (
        lambda f: None, lambda f: f.fmu.exitInitializationMode(), "instantiated"),
    "enter twice": (
        lambda f: f.enter(), lambda f: f.fmu.enterInitializationMode(), "initialization mode"),
    "read before initialisation": (
        lambda f: None, lambda f: f.get("energy"), "instantiated"),
    "terminate before initialisation": (
        lambda f: None, lambda f: f.fmu.terminate(), "instantiated"),
    "step after terminate": (
        lambda f: (f.initialise(), f.fmu.terminate()), lambda f: f.step(0.0, 0.1), "terminated"),
    "set after terminate": (
        lambda f: (f.initialise(), f.fmu.terminate()), lambda f: f.set(push=1.0), "terminated"),
    "set a parameter in step mode": (
        lambda f: f.initialise(), lambda f: f.set(solver_step=0.1), "cannot be set in this mode"),
    "set a state in step mode": (
        lambda f: f.initialise(), lambda f: f.set(position=0.1), "cannot be set in this mode"),
    "set an output": (
        lambda f: f.initialise(), lambda f: f.set(energy=0.1), "calculated and cannot be set"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG_CALLS)
def test_a_wrong_call_is_refused_and_does_no_damage(oscillator: Native, case: str) -> None:
    prepare, wrong, message = WRONG_CALLS[case]
    fmu = oscillator.instance()
    prepare(fmu)
    with pytest.raises(FMICallException):
        wrong(fmu)
    assert message in fmu.messages
    fmu.fmu.reset()
    fmu.initialise()
    fmu.step(0.0, 0.1)


def test_unknown_references_and_wrong_types_are_refused(everything: Native) -> None:
    fmu = everything.instance()
    fmu.initialise()
    real = fmu.fmu.getReal if everything.fmi == 2 else fmu.fmu.getFloat64
    with pytest.raises(FMICallException):
        real([4_000_000])
    assert "there is no variable with value reference 4000000" in fmu.messages
    with pytest.raises(FMICallException):
        real([fmu.model.by_name["order"].reference])
    assert "order is of type integer, not real" in fmu.messages


def test_the_wrong_number_of_values_is_refused(native: Builder) -> None:
    fmu = native("Everything", 3).instance()
    fmu.initialise()
    reference = fmu.model.by_name["force"].reference
    for count in (2, 4):
        with pytest.raises(FMICallException):
            fmu.fmu.getFloat64([reference], count)
        with pytest.raises(FMICallException):
            fmu.fmu.setFloat64([reference], [0.0] * count)
    assert "2 values given for variables of 3 elements" in fmu.messages
    assert "4 values given for variables of 3 elements" in fmu.messages
    with pytest.raises(FMICallException):
        fmu.fmu.getFloat64([reference + 1], 1)


def test_nothing_is_logged_unless_asked(everything: Native) -> None:
    fmu = everything.instance(logging=False)
    with pytest.raises(FMICallException):
        fmu.set(level=np.nan)
    assert fmu.log == []
    fmu.fmu.setDebugLogging(True, ["logStatusWarning"])
    with pytest.raises(FMICallException):
        fmu.set(level=np.nan)
    assert fmu.log == []
    fmu.fmu.setDebugLogging(True, ["logStatusError"])
    with pytest.raises(FMICallException):
        fmu.set(level=np.nan)
    assert len(fmu.log) == 1
    with pytest.raises(FMICallException):
        fmu.fmu.setDebugLogging(True, ["logNonsense"])
    fmu.fmu.setDebugLogging(False, [])
    with pytest.raises(FMICallException):
        fmu.set(level=np.nan)
    assert len(fmu.log) == 2


def test_a_foreign_token_or_an_empty_name_makes_no_instance(
    everything: Native, fmi: Fmi, capfd: pytest.CaptureFixture[str]
) -> None:
    for token, name in (("{other}", "one"), (None, "")):
        fmu = everything.instance().fmu
        fmu.freeInstance()
        other = type(fmu)(guid=token or fmu.guid, unzipDirectory=str(everything.folder),
                          instanceName=name, modelIdentifier="Everything")  # fmt: skip
        with pytest.raises(Exception, match=r"[Ff]ailed to instantiate"):
            other.instantiate()


def test_unsupported_functions_answer_as_the_standard_says(native: Builder) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.initialise()
    for call in (
        lambda: fmu.fmu.cancelStep(), lambda: fmu.fmu.getRealOutputDerivatives([1], [1]),
        lambda: fmu.fmu.getString([1]), lambda: fmu.fmu.setString([1], [""]),
    ):  # fmt: skip
        with pytest.raises(FMICallException):
            call()
    fmu.step(0.0, 0.5)
    assert fmu.fmu.getRealStatus(fmpy.fmi2.fmi2LastSuccessfulTime) == 0.5
    assert fmu.fmu.getBooleanStatus(fmpy.fmi2.fmi2Terminated) == 0
    three = native("Oscillator", 3).instance()
    three.initialise()
    for call in (
        lambda: three.fmu.getFloat32([1]), lambda: three.fmu.getUInt64([1]),
        lambda: three.fmu.getClock([1]), lambda: three.fmu.getBinary([1]),
        lambda: three.fmu.getString([1]), lambda: three.fmu.enterConfigurationMode(),
        lambda: three.fmu.fmi3GetNumberOfVariableDependencies(
            three.fmu.component, 1, byref(c_size_t())),
        lambda: three.fmu.getOutputDerivatives([1], [1]), lambda: three.fmu.enterEventMode(),
    ):  # fmt: skip
        with pytest.raises(FMICallException):
            call()
    three.step(0.0, 0.5)
