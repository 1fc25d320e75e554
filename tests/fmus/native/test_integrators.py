"""Integration inside doStep: RK4, Dormand-Prince, and inputs that vary within the step."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from scipy.integrate import solve_ivp

from sightline.fmus.python import solvers

from .conftest import Builder
from .driver import Native

DORMAND_PRINCE = 2


def rate(t: float, x: np.ndarray, push: float = 0.0) -> np.ndarray:
    return np.array([x[1], push - x[0] - x[0] ** 3])


def unchanged(t: float, x: np.ndarray) -> np.ndarray:
    return x


def test_rk4_equals_the_reference_to_the_bit(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.set(solver_step=0.03)
    fmu.initialise()
    x = np.array([1.0, 0.0])
    for k in range(50):
        fmu.step(k * 0.1, 0.1)
        x = solvers.rk4(rate, unchanged, k * 0.1, x, (k * 0.1 + 0.1) - k * 0.1, 0.03)
    np.testing.assert_allclose(fmu.all("state"), x, rtol=1e-14)


def test_dormand_prince_equals_the_reference_and_remembers_its_step(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.set(solver=DORMAND_PRINCE, relative_tolerance=1e-8, absolute_tolerance=1e-10)
    fmu.initialise()
    x, proposal, h = np.array([1.0, 0.0]), 0.01, 0.5
    for k in range(20):
        fmu.step(k * h, h)
        x, proposal = solvers.dormand_prince(rate, unchanged, k * h, x, h, proposal, 1e-8, 1e-10)
    np.testing.assert_allclose(fmu.all("state"), x, rtol=1e-12)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_dormand_prince_meets_its_tolerance(oscillator: Native, tolerance: float) -> None:
    fmu = oscillator.instance()
    fmu.set(solver=DORMAND_PRINCE, relative_tolerance=tolerance, absolute_tolerance=tolerance)
    fmu.initialise()
    fmu.step(0.0, 10.0)
    truth = solve_ivp(rate, (0, 10), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    # local errors add up over about 100 steps
    np.testing.assert_allclose(fmu.all("state"), truth, atol=300 * tolerance)


def test_rk4_converges_with_order_four(native: Builder) -> None:
    truth = solve_ivp(rate, (0, 2), [1.0, 0.0], method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
    errors = []
    for step in (0.1, 0.05):
        fmu = native("Oscillator", 2).instance()
        fmu.set(solver_step=step)
        fmu.initialise()
        fmu.step(0.0, 2.0)
        errors.append(np.linalg.norm(fmu.all("state") - truth))
    assert errors[0] / errors[1] == pytest.approx(16.0, rel=0.15)  # 2^4, next order not yet gone


def test_the_communication_step_does_not_change_the_substeps(oscillator: Native) -> None:
    results = []
    for h in (0.01, 0.05, 1.0):
        fmu = oscillator.instance()
        fmu.initialise()
        for k in range(round(1.0 / h)):
            fmu.step(k * h, h)
        results.append(fmu.all("state"))
    np.testing.assert_allclose(results[1], results[0], rtol=1e-13)
    np.testing.assert_allclose(results[2], results[0], rtol=1e-13)


@pytest.mark.parametrize("solver", [1, 2])
def test_input_derivatives_are_used_inside_the_step(native: Builder, solver: int) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.set(solver=solver, solver_step=0.001, relative_tolerance=1e-12)
    fmu.initialise()
    reference = fmu.model.by_name["push"].reference
    fmu.set(push=0.5)
    fmu.fmu.setRealInputDerivatives([reference, reference], [1, 2], [2.0, -3.0])
    fmu.step(0.0, 1.0)

    def push(t: float) -> float:
        return 0.5 + 2.0 * t - 1.5 * t * t

    truth = solve_ivp(lambda t, x: rate(t, x, push(t)), (0, 1), [1.0, 0.0], method="DOP853",
                      rtol=1e-13, atol=1e-14).y[:, -1]
    np.testing.assert_allclose(fmu.all("state"), truth, atol=1e-10)
    x, v = fmu.all("state")
    at_end = 0.5 * v**2 + 0.5 * x**2 + 0.25 * x**4 + push(1.0)
    assert fmu.get("energy") == pytest.approx(at_end, rel=1e-14)
    fmu.step(1.0, 1.0)  # the derivatives were for one step: the input holds from here
    assert fmu.get("push") == pytest.approx(push(1.0), rel=1e-15)


def test_input_derivatives_of_other_orders_are_refused(native: Builder) -> None:
    fmu = native("Oscillator", 2).instance()
    fmu.initialise()
    reference = fmu.model.by_name["push"].reference
    with pytest.raises(FMICallException):
        fmu.fmu.setRealInputDerivatives([reference], [3], [1.0])
    assert "push: derivative of order 3 cannot be used" in fmu.messages
    with pytest.raises(FMICallException):
        fmu.fmu.setRealInputDerivatives([fmu.model.by_name["energy"].reference], [1], [1.0])
    fmu.step(0.0, 0.1)


def test_tolerances_that_cannot_be_met_are_an_error(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.set(solver=DORMAND_PRINCE, relative_tolerance=1e-15, absolute_tolerance=1e-300,
            position=1e80)  # fmt: skip
    fmu.initialise()
    with pytest.raises(FMICallException):
        fmu.step(0.0, 1e3)
    assert "tolerances cannot be met" in fmu.messages or "not finite" in fmu.messages
