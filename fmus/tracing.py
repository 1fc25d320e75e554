"""A block's equations as CasADi graphs, and what depends on what.

The block's own methods are called with symbols of the declared shapes (CasADi's numpy mode), so
that a block has one implementation only. Groups of arguments, each one flat vector in order of
declaration (row-major): time t, inputs u, parameters p, states x, discrete states d, noise w.
"""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
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
from ..components.loops import LOOP
from .loops import traced_loop

GROUPS: dict[str, type] = {
    "u": Input, "p": Parameter, "x": State, "d": DiscreteState, "w": Noise,
}  # fmt: skip
ARGUMENTS = ("t", *GROUPS)
RESULTS: dict[str, type] = {
    "derivatives": State, "outputs": Output, "update": DiscreteState, "project": State,
}  # fmt: skip

_mode_lock = threading.Lock()


class TracingError(Exception):
    """An equation cannot be traced: it uses more than array operations with a fixed path."""

    def __init__(self, component: str, equation: str, reason: str) -> None:
        super().__init__(
            f"{component}.{equation} cannot become native code: {reason}; use numpy operations "
            "without branches on values (np.where instead of if), or build with --target python"
        )


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
    """Trace every equation of a block. Raises TracingError where it is not traceable."""
    values, groups = _symbols(block)
    functions: dict[str, ca.Function] = {}
    messages: tuple[str, ...] = ()
    for equation in (*RESULTS, "requirements"):
        if not block.has(equation):
            continue
        with numpy_mode():
            try:
                result = block.evaluate(equation, values)
                flat = {n: _flat(v) for n, v in result.items()}
            except Exception as error:
                reason = str(error).strip().splitlines() or [type(error).__name__]
                raise TracingError(block.name, equation, reason[-1]) from error
        if equation == "requirements":
            messages, parts = tuple(flat), list(flat.values())
        else:
            kept = {n: _flat(values[n]) for n in block.expected(equation) if n not in flat}
            parts = [(flat | kept)[n] for n in block.expected(equation)]
        functions[equation] = ca.Function(equation, groups, [ca.vertcat(*parts)])
    return Trace(block, functions, messages)


@contextmanager
def numpy_mode() -> Iterator[None]:
    """CasADi's numpy mode, which is global to the process, for the length of a block."""
    with _mode_lock:
        before = ca.GlobalOptions.getNumpyMode()
        ca.GlobalOptions.setNumpyMode(1)
        loop = LOOP.set(traced_loop)
        try:
            yield
        finally:
            LOOP.reset(loop)
            ca.GlobalOptions.setNumpyMode(before)


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
