"""Directional and adjoint derivatives against finite differences of the FMU's own outputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..driver import Driver, good
from ..fmi3_driver import Driver3
from ..lab import Lab
from ..registry import NotApplicable, Notes, check
from ..session import Session
from ..subject import Array, Variable, names_of

TOLERANCE = 1e-5  # of the largest entry of the column: central differences
STEPS = (1e-5, 1e-3, 0.1, 10.0)  # of central differences: large values need larger ones
ROUNDING = 8.0 * np.finfo(float).eps
Point = Callable[[Array], tuple[int, Array]]


DIRECTIONAL = ("providesDirectionalDerivative", "providesDirectionalDerivatives")  # FMI 2.0, 3.0


def _setting(lab: Lab) -> tuple[Session, list[Variable], list[Variable]]:
    """A running instance, unknowns and knowns; states are knowns where they can be set."""
    declared = [i for i in lab.subject.interfaces if lab.subject.says(i, *DIRECTIONAL)]
    if not declared:
        raise NotApplicable("not declared (providesDirectionalDerivative)")
    interface = "me" if "me" in declared else "cs"
    session = lab.begun(interface=interface)
    session.step(lab.subject.step)
    session.put(lab.excitation.at(1))
    unknowns = [v for v in lab.subject.outputs if v.real and v not in lab.subject.states
                and v.variability == "continuous"]
    knowns = [v for v in lab.subject.inputs if v.real and v.variability == "continuous"]
    if interface == "me":
        session.leave_event_mode()
        unknowns += [rate for _, rate in lab.subject.derivatives]
        knowns += lab.subject.states
    if not unknowns or not knowns:
        raise NotApplicable("no real unknown depends on a real known")
    return session, unknowns, knowns


def _point(session: Session, unknowns: Sequence[Variable], knowns: Sequence[Variable]) -> Point:
    """Unknowns as a function of the knowns."""
    driver: Driver = session.driver
    states = session.subject.states
    inputs = [v for v in knowns if v not in states]
    cut = sum(v.size for v in inputs)

    def evaluate(values: Array) -> tuple[int, Array]:
        status = driver.set(inputs, values[:cut]) if inputs else 0
        if good(status) and len(values) > cut:
            status = driver.set_states(values[cut:])
        return driver.get(unknowns) if good(status) else (status, values)

    return evaluate


def _difference(
    evaluate: Point, at: Array, direction: Array, step: float
) -> tuple[Array, Array] | None:
    """Central difference and its rounding error; None if the FMU refuses the values."""
    sides = [evaluate(at + sign * step * direction) for sign in (1.0, -1.0)]
    evaluate(at)
    if not all(good(s) for s, _ in sides):
        return None
    (_, above), (_, below) = sides
    rounding = ROUNDING * np.maximum(np.abs(above), np.abs(below)) / step
    return (above - below) / (2.0 * step), rounding


@check("derivatives.directional", "directional derivatives are those of finite differences")
def directional(lab: Lab, notes: Notes) -> None:
    session, unknowns, knowns = _setting(lab)
    at = session.read(knowns)
    evaluate = _point(session, unknowns, knowns)
    rows, columns = names_of(unknowns), names_of(knowns)
    total = np.zeros(sum(v.size for v in unknowns))
    for j, name in enumerate(columns):
        direction = np.eye(len(at))[j]
        status, found = session.driver.directional(unknowns, knowns, direction)
        session.must(status, f"the derivative by {name}")
        notes.tried["directions"] += 1
        total += found
        size = max(abs(float(at[j])), 1.0)
        if wrong := _against_differences(evaluate, at, direction, size, rows, found):
            notes.wrong(f"by {name}", wrong, "as finite differences say")
    status, found = session.driver.directional(unknowns, knowns, np.ones(len(at)))
    session.must(status, "the derivative in all directions together")
    if wrong := _disagreement(rows, found, total):
        notes.wrong("by all together", wrong, "the sum of all directions")


def _against_differences(
    evaluate: Point, at: Array, direction: Array, size: float, rows: list[str], found: Array
) -> str:
    """How a derivative differs from central differences of every step; empty if one agrees."""
    first = ""
    for step in STEPS:
        difference = _difference(evaluate, at, direction, step * size)
        if difference is None:
            break
        wrong = _disagreement(rows, found, *difference)
        if not wrong:
            return ""
        first = first or wrong
    return first


def _disagreement(
    rows: list[str], found: Array, expected: Array, rounding: Array | float = 0.0
) -> str:
    """Where a column differs by more than the difference can err; empty if nowhere."""
    size = max(float(np.max(np.abs(expected))), 1e-3)
    error = np.abs(found - expected)
    if np.all(np.isfinite(error)) and np.all(error <= TOLERANCE * size + rounding):
        return ""
    i = int(np.argmax(np.where(np.isnan(error), np.inf, error)))
    return f"d {rows[i]} is {found[i]:.9g}, not {expected[i]:.9g}"


@check("derivatives.adjoint", "adjoint derivatives are the transpose of the directional ones")
def adjoint(lab: Lab, notes: Notes) -> None:
    if not any(lab.subject.says(i, "providesAdjointDerivatives") for i in lab.subject.interfaces):
        raise NotApplicable("not declared (providesAdjointDerivatives)")
    session, unknowns, knowns = _setting(lab)
    driver = session.driver
    assert isinstance(driver, Driver3)
    n_rows, n_columns = (sum(v.size for v in group) for group in (unknowns, knowns))
    jacobian = np.zeros((n_rows, n_columns))
    for j in range(n_columns):
        status, jacobian[:, j] = driver.directional(unknowns, knowns, np.eye(n_columns)[j])
        session.must(status, "a directional derivative")
    names = names_of(knowns)
    for i in range(n_rows):
        status, found = driver.adjoint(unknowns, knowns, np.eye(n_rows)[i])
        session.must(status, "an adjoint derivative")
        notes.tried["rows"] += 1
        if wrong := _disagreement(names, found, jacobian[i]):
            notes.wrong(f"of {names_of(unknowns)[i]}", f"by {wrong}", "the directional ones")
