"""A block's equations as CasADi graphs, and what depends on what.

The block's own methods are called with symbols of the declared shapes (CasADi's numpy mode), so
that a block has one implementation only. Groups of arguments, each one flat vector in order of
declaration (row-major): time t, inputs u, parameters p, states x, discrete states d, noise w.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from ..components.component import TIME, Component
from ..components.declarations import (
    DiscreteState,
    Input,
    Noise,
    Output,
    Parameter,
    State,
)
from .traced_arrays import numpy_mode
from .untraceable import changing, untraceable

GROUPS: dict[str, type] = {
    "u": Input, "p": Parameter, "x": State, "d": DiscreteState, "w": Noise,
}  # fmt: skip
ARGUMENTS = ("t", *GROUPS)
RESULTS: dict[str, type] = {
    "derivatives": State, "outputs": Output, "update": DiscreteState, "project": State,
}  # fmt: skip


@dataclass(frozen=True)
class Trace:
    """The traced equations of one block.

    ``functions``: one CasADi function per equation of the block, from the groups of ARGUMENTS to
    one flat vector. ``messages``: those of the conditions that ``requirements`` returns, in order.
    """

    block: Component
    functions: dict[str, ca.Function]
    messages: tuple[str, ...]

    def depends(self, equation: str, group: str) -> np.ndarray[Any, np.dtype[np.bool_]]:
        """Which scalar of the equation's result depends on which scalar of an argument group."""
        function = self.functions[equation]
        sparsity = function.jac_sparsity(0, ARGUMENTS.index(group))
        pattern = np.zeros(sparsity.shape, dtype=bool)
        rows, columns = sparsity.get_triplet()
        pattern[rows, columns] = True
        return pattern


def trace(block: Component) -> Trace:
    """Trace every equation of a block. Raises TracingError where it is not traceable.

    All equations are traced twice: what differs comes from elsewhere than their arguments.
    """
    values, groups = _symbols(block)
    first, second = _round(block, values, groups), _round(block, values, groups)
    for equation, results in first.items():
        if results.function.serialize() != second[equation].function.serialize():
            raise changing(block, equation, _differing(groups, results, second[equation]))
    functions = {n: r.function for n, r in first.items()}
    messages = tuple(first["requirements"].parts) if "requirements" in first else ()
    return Trace(block, functions, messages)


@dataclass(frozen=True)
class _Results:
    """Results of one equation: flat by name, and all in one function of the groups."""

    parts: dict[str, ca.SX]
    function: ca.Function


def _round(
    block: Component, values: Mapping[str, Any], groups: list[ca.SX]
) -> dict[str, _Results]:
    """Every equation traced once."""
    found = {}
    with numpy_mode():
        for equation in (e for e in (*RESULTS, "requirements") if block.has(e)):
            try:
                parts = _parts(block, equation, values)
                function = ca.Function(equation, groups, [ca.vertcat(*parts.values())])
            except Exception as error:
                raise untraceable(block, equation, error) from error
            found[equation] = _Results(parts, function)
    return found


def _parts(block: Component, equation: str, values: Mapping[str, Any]) -> dict[str, ca.SX]:
    """An equation's results by name; the states that it leaves alone as they are."""
    result = {n: _flat(v) for n, v in block.evaluate(equation, values).items()}
    if equation == "requirements":
        return result
    expected = block.expected(equation)
    for name, part in result.items():
        if part.numel() != expected[name].size:
            raise ValueError(f"{name} has {part.numel()} elements, not {expected[name].size}")
    return {n: result[n] if n in result else _flat(values[n]) for n in expected}


def _differing(groups: list[ca.SX], first: _Results, second: _Results) -> list[str]:
    """Names of the results of which two traces differ."""

    def content(results: _Results, name: str) -> object:
        part = results.parts.get(name)
        return part if part is None else ca.Function("part", groups, [part]).serialize()

    names = first.parts | second.parts
    return [n for n in names if content(first, n) != content(second, n)]


def _symbols(block: Component) -> tuple[dict[str, Any], list[ca.SX]]:
    t = ca.SX.sym("t")
    values: dict[str, Any] = {}
    groups = [t]
    with numpy_mode():
        values[TIME] = np.reshape(t, ())
        for kind in GROUPS.values():
            symbols = []
            for name, quantity in block.of_type(kind).items():
                symbol = ca.SX.sym(name, quantity.size)
                values[name] = np.reshape(symbol, quantity.dimensions)
                symbols.append(symbol)
            groups.append(ca.vertcat(*symbols) if symbols else ca.SX(0, 1))
    return values, groups


def _flat(value: Any) -> ca.SX:
    """Row-major elements as a dense column."""
    return ca.densify(ca.SX(np.reshape(value, (-1,))))
