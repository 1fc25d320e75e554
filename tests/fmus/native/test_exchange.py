"""Model exchange, and co-simulation with event mode, against co-simulation without."""

from __future__ import annotations

from ctypes import c_double
from typing import Any

import fmpy
import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from .driver import Instance, Native

CVODE = 1e-11  # relative tolerance


def simulate(native: Native, interface: str, **more: Any) -> np.ndarray:
    return fmpy.simulate_fmu(
        str(native.folder), fmi_type=interface, stop_time=1.93, output_interval=1.93,
        relative_tolerance=CVODE if interface == "ModelExchange" else None, **more,
    )  # fmt: skip


def test_fmpy_finds_nothing_to_criticise(every_fmu: Native) -> None:
    assert validate_fmu(str(every_fmu.path)) == []


def test_both_interfaces_follow_the_same_trajectory(every_fmu: Native) -> None:
    sampled = {"sample_period": 0.05} if "sample_period" in every_fmu.model.by_name else {}
    step, exchange = (
        simulate(every_fmu, i, start_values=sampled) for i in ("CoSimulation", "ModelExchange")
    )
    for name in step.dtype.names:
        scale = np.max(np.abs(step[name])) + 1e-3
        # RK4 at the block's step against CVode
        np.testing.assert_allclose(exchange[name][-1], step[name][-1], atol=1e-7 * scale, rtol=0)


class Exchange:
    """Model exchange by hand, Euler steps."""

    def __init__(self, native: Native) -> None:
        self.instance = native.instance(interface="ModelExchange")
        self.fmu, self.fmi = self.instance.fmu, native.fmi
        self.size = sum(v.size for v in native.model.of_kind("state"))

    def update(self) -> tuple[bool, bool, float | None]:
        """More updates needed, states changed, next event."""
        if self.fmi == 2:
            again, _, _, changed, defined, time = self.fmu.newDiscreteStates()
        else:
            again, _, _, changed, defined, time = self.fmu.updateDiscreteStates()
        return bool(again), bool(changed), time if defined else None

    def states(self) -> np.ndarray:
        x = (c_double * self.size)()
        self.fmu.getContinuousStates(x, self.size)
        return np.array(x)

    def rates(self) -> np.ndarray:
        dx = (c_double * self.size)()
        f = self.fmu.getDerivatives if self.fmi == 2 else self.fmu.getContinuousStateDerivatives
        f(dx, self.size)
        return np.array(dx)

    def move(self, x: np.ndarray) -> None:
        self.fmu.setContinuousStates((c_double * self.size)(*x), self.size)


def test_ticks_are_time_events(everything: Native) -> None:
    exchange = Exchange(everything)
    exchange.instance.set(sample_period=0.25, force=[1.0, 0.0, 0.0])
    exchange.instance.initialise(start=2.0)
    again, _, event = exchange.update()
    assert (again, event) == (False, 2.25)
    assert exchange.instance.get("ticks") == 1
    for tick in range(1, 4):
        exchange.fmu.enterContinuousTimeMode()
        held = exchange.instance.get("pull")
        exchange.fmu.setTime(2.0 + 0.25 * tick)
        np.testing.assert_array_equal(exchange.instance.get("pull"), held)
        exchange.fmu.enterEventMode()
        _, _, event = exchange.update()
        assert event == 2.0 + 0.25 * (tick + 1)
        assert exchange.instance.get("ticks") == tick + 1
        assert np.all(exchange.instance.get("pull") != held)


def test_drift_from_the_manifold_is_corrected_at_an_event(everything: Native) -> None:
    exchange = Exchange(everything)
    exchange.instance.initialise()
    exchange.update()
    exchange.fmu.enterContinuousTimeMode()
    assert exchange.fmu.completedIntegratorStep() == (False, False)
    x = exchange.states()
    exchange.move([*x[:3], 1.0, 1e-3])
    assert bool(exchange.fmu.completedIntegratorStep()[0])
    exchange.fmu.enterEventMode()
    _, changed, _ = exchange.update()
    assert changed
    assert np.linalg.norm(exchange.states()[3:]) == pytest.approx(1.0, abs=1e-15)


def test_rates_are_those_of_the_equations(oscillator: Native) -> None:
    exchange = Exchange(oscillator)
    exchange.instance.initialise()
    exchange.update()
    exchange.fmu.enterContinuousTimeMode()
    exchange.move(np.array([2.0, 3.0]))
    exchange.instance.set(push=0.5)
    np.testing.assert_array_equal(exchange.rates(), [3.0, 0.5 - 2.0 - 8.0])
    with pytest.raises(FMICallException):
        exchange.move(np.array([np.nan, 0.0]))
    assert "position is not finite" in exchange.instance.messages


def with_event_mode(native: Native, early: bool) -> Instance:
    fmu = native.instance(eventModeUsed=True, earlyReturnAllowed=early)
    fmu.set(sample_period=0.25)
    fmu.initialise()
    fmu.fmu.updateDiscreteStates()
    fmu.fmu.enterStepMode()
    return fmu


def test_with_event_mode_a_step_returns_early_at_ticks(native) -> None:  # type: ignore[no-untyped-def]
    plain = native("Everything", 3).instance()
    plain.set(sample_period=0.25)
    plain.initialise()
    fmu = with_event_mode(native("Everything", 3), early=True)
    time, returns = 0.0, []
    while time < 1.0:
        event, early, reached = fmu.step(time, 1.0 - time) or (False, False, 0.0)
        returns.append((event, early, reached))
        time = reached
        if event:
            fmu.fmu.enterEventMode()
            again, *_ = fmu.fmu.updateDiscreteStates()
            assert not again
            fmu.fmu.enterStepMode()
    assert returns == [(True, True, 0.25), (True, True, 0.5), (True, True, 0.75),
                       (True, False, 1.0)]  # fmt: skip
    plain.step(0.0, 1.0)
    for name in ("speed", "phase", "pull"):
        np.testing.assert_allclose(fmu.get(name), plain.get(name), rtol=1e-13)


def test_without_early_return_ticks_inside_a_step_are_taken(native) -> None:  # type: ignore[no-untyped-def]
    fmu = with_event_mode(native("Everything", 3), early=False)
    assert fmu.step(0.0, 0.6) == (False, False, 0.6)
    assert fmu.get("ticks") == 3
