"""Functions that an FMU has to export and has no use for, and calls without an instance."""

from __future__ import annotations

from ctypes import c_char_p, c_int, c_size_t, c_void_p
from typing import Any

import pytest

from .conftest import Builder
from .driver import Fmi, Instance, Native

OK, ERROR = 0, 3
NOTHING = [None] * 8  # for parameters that are not looked at
ABSENT = {
    "EnterConfigurationMode": "there are no structural parameters",
    "ExitConfigurationMode": "there are no structural parameters",
    "GetNumberOfVariableDependencies": "dependencies of elements are not offered",
    "GetVariableDependencies": "dependencies of elements are not offered",
    "GetIntervalDecimal": "there are no clocks",
    "GetIntervalFraction": "there are no clocks",
    "GetShiftDecimal": "there are no clocks",
    "GetShiftFraction": "there are no clocks",
    "SetIntervalDecimal": "there are no clocks",
    "SetIntervalFraction": "there are no clocks",
    "SetShiftDecimal": "there are no clocks",
    "SetShiftFraction": "there are no clocks",
    "ActivateModelPartition": "scheduled execution is not offered",
}
TYPES = ("Float32", "Int8", "UInt8", "Int16", "UInt16", "UInt32", "UInt64", "String", "Binary",
         "Clock")  # fmt: skip
WITHOUT_INSTANCE = {"GetVersion", "GetTypesPlatform", "FreeInstance"}


def function(fmu: Instance, name: str) -> Any:
    found = getattr(fmu.fmu.dll, f"fmi{fmu.fmi}{name}")
    found.restype, found.argtypes = c_int, None
    return found


@pytest.fixture
def three(native: Builder) -> Instance:
    fmu = native("Oscillator", 3).instance()
    fmu.initialise()
    return fmu


@pytest.mark.parametrize("name", ABSENT)
def test_what_is_not_offered_is_refused_and_does_no_damage(three: Instance, name: str) -> None:
    component = c_void_p(three.fmu.component)
    assert function(three, name)(component, *NOTHING) == ERROR
    assert ABSENT[name] in three.messages
    three.step(0.0, 0.1)


@pytest.mark.parametrize("access", ["Get", "Set"])
@pytest.mark.parametrize("name", TYPES)
def test_there_are_no_variables_of_other_types(three: Instance, access: str, name: str) -> None:
    call, component = function(three, access + name), c_void_p(three.fmu.component)
    assert call(component, None, c_size_t(0), *NOTHING) == OK
    assert call(component, None, c_size_t(1), *NOTHING) == ERROR
    assert f"there are no variables of type {name}" in three.messages
    three.step(0.0, 0.1)


def test_status_of_a_step_under_way_is_not_there(native: Builder) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.initialise()
    discard = 2
    for name in ("GetStatus", "GetIntegerStatus", "GetStringStatus"):
        assert function(fmu, name)(c_void_p(fmu.fmu.component), c_int(0), None) == discard
    assert "no such status: steps are complete when fmi2DoStep returns" in fmu.messages


def test_every_function_refuses_to_be_called_without_an_instance(
    everything: Native, fmi: Fmi
) -> None:
    fmu = everything.instance()
    names = {n.removeprefix(f"fmi{fmi}") for n in dir(fmu.fmu) if n.startswith(f"fmi{fmi}")}
    called = sorted(n for n in names - WITHOUT_INSTANCE if not n.startswith("Instantiate"))
    assert len(called) >= 30
    for name in called:
        assert function(fmu, name)(None, *NOTHING) == ERROR, name
    free = function(fmu, "FreeInstance")
    free.restype = None
    free(None)
    version = function(fmu, "GetVersion")
    version.restype = c_char_p
    assert version() == f"{fmi}.0".encode()
