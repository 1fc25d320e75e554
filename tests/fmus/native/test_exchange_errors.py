"""Times, states and derivatives of inputs that are not finite: refused by name, without damage."""

from __future__ import annotations

from ctypes import c_double

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

from .conftest import Builder
from .driver import Fmi, Instance


@pytest.fixture
def exchanging(native: Builder, fmi: Fmi) -> Instance:
    fmu = native("Oscillator", fmi).instance(interface="ModelExchange")
    fmu.initialise()
    fmu.fmu.newDiscreteStates() if fmi == 2 else fmu.fmu.updateDiscreteStates()
    fmu.fmu.enterContinuousTimeMode()
    return fmu


def states(fmu: Instance, size: int) -> list[float]:
    values = (c_double * size)()
    fmu.fmu.getContinuousStates(values, size)
    return list(values)


@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf])
def test_time_that_is_not_finite_is_refused(exchanging: Instance, time: float) -> None:
    with pytest.raises(FMICallException):
        exchanging.fmu.setTime(time)
    assert f"time {time:g}: must be finite" in exchanging.messages
    exchanging.fmu.setTime(0.5)


def test_state_that_is_not_finite_is_refused_by_name(exchanging: Instance) -> None:
    size = sum(v.size for v in exchanging.model.of_kind("state"))
    before = states(exchanging, size)
    with pytest.raises(FMICallException):
        exchanging.fmu.setContinuousStates((c_double * size)(*[np.nan] * size), size)
    assert "position is not finite" in exchanging.messages
    assert states(exchanging, size) == before


def test_another_number_of_states_is_refused(exchanging: Instance) -> None:
    size = sum(v.size for v in exchanging.model.of_kind("state"))
    for call in ("getContinuousStates", "setContinuousStates"):
        with pytest.raises(FMICallException):
            getattr(exchanging.fmu, call)((c_double * (size + 1))(), size + 1)
    assert str(size + 1) in exchanging.messages


def test_start_time_that_is_not_finite_is_refused(native: Builder, fmi: Fmi) -> None:
    fmu = native("Oscillator", fmi).instance()
    with pytest.raises(FMICallException):
        fmu.enter(start=np.nan)
    assert "start time nan: must be finite" in fmu.messages


@pytest.mark.parametrize(
    ("order", "value", "message"),
    [(1, np.nan, "derivative nan: must be finite"),
     (3, 1.0, "derivative of order 3 cannot be used, only 1 and 2")],
)  # fmt: skip
def test_wrong_derivative_of_an_input_is_refused(
    native: Builder, order: int, value: float, message: str
) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.initialise()
    reference = fmu.model.by_name["push"].references[0]
    with pytest.raises(FMICallException):
        fmu.fmu.setRealInputDerivatives([reference], [order], [value])
    assert f"push: {message}" in fmu.messages
    fmu.step(0.0, 0.1)
