"""Directional and adjoint derivatives against finite differences and each other, and the
declared dependencies against what the running FMU shows."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.fmi1 import FMICallException

from .conftest import Builder
from .driver import Fmi, Instance, Native
from .samples import random_values

KINDS = ("input", "parameter", "state", "discrete")


def real_names(native: Native, *kinds: str) -> list[str]:
    return [v.name for v in native.model.of_kind(*kinds) if v.type == "real"]


def unknown_names(native: Native) -> list[str]:
    return real_names(native, "output", "derivative")


def at_random_point(native: Native) -> tuple[Instance, dict[str, np.ndarray]]:
    fmu = native.instance()
    values = random_values(np.random.default_rng(11), native.model, *KINDS)
    fmu.set(**values)
    fmu.enter()
    return fmu, values


def jacobian(fmu: Instance, unknowns: list[str], knowns: list[str]) -> np.ndarray:
    rows, columns = (sum(fmu.model.by_name[n].size for n in names) for names in (unknowns, knowns))
    found = [fmu.forward(unknowns, knowns, column) for column in np.eye(columns)]
    return np.array(found).reshape(columns, rows).T


def differences(
    fmu: Instance, values: dict[str, np.ndarray], unknowns: list[str], knowns: list[str],
    relative: float = 1e-5,
) -> np.ndarray:  # fmt: skip
    """Central differences of the running FMU in initialisation mode."""
    columns: list[np.ndarray] = []
    rows = sum(fmu.model.by_name[u].size for u in unknowns)
    for name in knowns:
        for i in range(fmu.model.by_name[name].size):
            results = []
            point = np.array(values[name], dtype=float)
            h = relative * max(1.0, abs(point.flat[i]))
            for sign in (1.0, -1.0):
                moved = point.copy()
                moved.flat[i] += sign * h
                fmu.set(**{name: moved})
                results.append(np.concatenate([np.ravel(fmu.get(u)) for u in unknowns]))
            fmu.set(**{name: point})
            columns.append((results[0] - results[1]) / (2 * h))
    return np.array(columns).reshape(len(columns), rows).T


def inside(native: Native, values: dict[str, np.ndarray], names: list[str]) -> list[str]:
    """Names whose value may be moved both ways."""
    def free(name: str) -> bool:
        v = native.model.by_name[name]
        low = -np.inf if v.min is None else v.min
        high = np.inf if v.max is None else v.max
        return bool(np.all(values[name] > low) and np.all(values[name] < high))

    return [n for n in names if free(n)]


def offers_derivatives(native: Native) -> bool:
    return "providesDirectionalDerivative" in (native.folder / "modelDescription.xml").read_text()


def test_directional_derivatives_equal_finite_differences(block_fmu: Native) -> None:
    if not offers_derivatives(block_fmu):
        _derivatives_are_refused(block_fmu)
        return
    fmu, values = at_random_point(block_fmu)
    unknowns = unknown_names(block_fmu)
    knowns = inside(block_fmu, values, real_names(block_fmu, "input", "state", "discrete"))
    exact = jacobian(fmu, unknowns, knowns)
    found = differences(fmu, values, unknowns, knowns)
    doubt = np.abs(found - differences(fmu, values, unknowns, knowns, relative=3e-5))
    scale = np.max(np.abs(exact), axis=1, keepdims=True, initial=0.0) + np.abs(exact)
    # central differences with a step of 1e-5: truncation and cancellation near 1e-9 of the row,
    # more where two steps show it
    assert np.all(np.abs(exact - found) <= 1e-6 * scale + 1e-9 + 10.0 * doubt)


def _derivatives_are_refused(native: Native) -> None:
    fmu = native.instance()
    fmu.initialise()
    unknown, known = real_names(native, "output")[0], real_names(native, "input")[0]
    with pytest.raises(FMICallException):
        fmu.forward([unknown], [known], np.ones(native.model.by_name[known].size))
    assert "this block offers no partial derivatives" in fmu.messages


def test_short_equations_offer_derivatives_and_long_ones_do_not(
    native: Builder, fmi: Fmi
) -> None:
    assert offers_derivatives(native("FreeRigidBody", fmi))
    assert offers_derivatives(native("Iterating", fmi))
    assert not offers_derivatives(native("ThrusterAllocation", fmi))


def test_adjoint_derivatives_are_the_transpose(native: Builder, block_fmu: Native) -> None:
    if block_fmu.fmi == 2:
        assert not hasattr(block_fmu.instance().fmu, "fmi2GetAdjointDerivative")
        return
    if not offers_derivatives(block_fmu):
        return
    fmu, _ = at_random_point(block_fmu)
    unknowns = [*unknown_names(block_fmu), *(v.name for v in block_fmu.model.outputs
                if v.kind == "state")]  # fmt: skip
    knowns = real_names(block_fmu, "input", "state", "discrete")
    forward = jacobian(fmu, unknowns, knowns)
    rows = [fmu.reverse(unknowns, knowns, row) for row in np.eye(forward.shape[0])]
    np.testing.assert_allclose(np.array(rows).reshape(forward.shape), forward, rtol=1e-9,
                               atol=1e-12 * np.max(np.abs(forward), initial=0.0))  # fmt: skip


def test_an_output_that_is_a_state_depends_on_itself(oscillator: Native) -> None:
    fmu = oscillator.instance()
    fmu.initialise()
    np.testing.assert_array_equal(
        fmu.forward(["position", "energy"], ["position", "push"], [2.0, 3.0]), [2.0, 7.0]
    )


def test_held_outputs_depend_on_nothing_between_ticks(everything: Native) -> None:
    fmu = everything.instance()
    fmu.initialise()
    at_tick = fmu.forward(["pull"], ["force"], [1.0, 0.0, 0.0])
    fmu.step(0.0, 0.05)
    between = fmu.forward(["pull"], ["force"], [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(at_tick, [1.0, 0.0, 0.0])
    np.testing.assert_array_equal(between, [0.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("unknown", "known", "message"),
    [("push", "push", "push cannot be an unknown"),
     ("energy", "energy", "energy cannot be a known"),
     ("energy", "solver_step", "solver_step cannot be a known")],
)  # fmt: skip
def test_wrong_unknowns_and_knowns_are_refused(
    oscillator: Native, unknown: str, known: str, message: str
) -> None:
    fmu = oscillator.instance()
    fmu.initialise()
    with pytest.raises(FMICallException):
        fmu.forward([unknown], [known], [1.0])
    assert message in fmu.messages


def declared(native: Native) -> dict[int, set[int]]:
    """Value reference of each unknown -> references of the knowns that it is declared to have."""
    description = read_model_description(str(native.folder))
    structure = [*description.outputs, *description.derivatives]
    return {
        u.variable.valueReference: {k.valueReference for k in u.dependencies} for u in structure
    }


def test_declared_dependencies_are_those_that_the_running_fmu_shows(block_fmu: Native) -> None:
    unknowns = unknown_names(block_fmu)
    knowns = real_names(block_fmu, "input", "state", "discrete")
    model, fmi = block_fmu.model, block_fmu.fmi
    shown: dict[int, set[int]] = {}
    for seed in range(4):  # an entry that vanishes at one point shows at another
        fmu = block_fmu.instance()
        values = random_values(np.random.default_rng(seed), model, *KINDS)
        fmu.set(**values)
        fmu.enter()
        movable = inside(block_fmu, values, knowns)
        found = differences(fmu, values, unknowns, movable, relative=1e-4)
        rows = _references(model, fmi, unknowns)
        columns = _references(model, fmi, movable)
        for row, reference in zip(found, rows, strict=True):
            hit = {c for c, d in zip(columns, row, strict=True) if d != 0.0}
            shown[reference] = shown.get(reference, set()) | hit
    promised = declared(block_fmu)
    for reference, hits in shown.items():
        assert hits <= promised[reference], "an undeclared dependency"
    if block_fmu.model.block.name in ("Everything", "Oscillator", "Gain", "FreeRigidBody"):
        real = set(_references(model, fmi, knowns))
        for reference, hits in shown.items():
            assert promised[reference] & real == hits, "a dependency that does not exist"


def _references(model, fmi: Fmi, names: list[str]) -> list[int]:  # type: ignore[no-untyped-def]
    """The FMI value reference behind each scalar."""
    variables = [model.by_name[n] for n in names]
    return [r if fmi == 2 else v.reference for v in variables for r in v.references]
