"""Loops in traced equations: one CasADi function, called as often as the loop turns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np


def traced_loop(step: Callable[[Any, Any], Any], count: int, given: Any, values: Any) -> Any:
    """What :func:`~..components.loops.repeat` does while equations are traced."""
    if not any(_is_symbolic(leaf) for leaf in [*_leaves(given), *_leaves(values)]):
        for _ in range(count):
            values = step(given, values)
        return values
    known = ca.SX.sym("given", _pack(given, symbolic_only=True).numel())
    state = ca.SX.sym("values", _pack(values).numel())
    after = _pack(step(_unpack(known, given, symbolic_only=True), _unpack(state, values)))
    if foreign := _names(after) - _names(known) - _names(state):
        raise ValueError(f"its step uses {', '.join(sorted(foreign))}, which it is not given")
    body = ca.Function("loop", [known, state], [after], {"never_inline": True})
    known, state = _pack(given, symbolic_only=True), _pack(values)
    for _ in range(count):
        state = body(known, state)
    return _unpack(state, values)


def _names(expression: ca.SX) -> set[str]:
    return {symbol.name() for symbol in ca.symvar(expression)}


def _is_symbolic(leaf: Any) -> bool:
    return not isinstance(leaf, np.ndarray | np.generic | float | int)


def _leaves(tree: Any) -> list[Any]:
    if tree is None:
        return []
    if isinstance(tree, tuple):
        return [leaf for branch in tree for leaf in _leaves(branch)]
    return [tree]


def _pack(tree: Any, symbolic_only: bool = False) -> ca.SX:
    """The elements of all leaves, row-major, as one dense column."""
    leaves = [v for v in _leaves(tree) if not symbolic_only or _is_symbolic(v)]
    return ca.vertcat(*(ca.densify(ca.SX(np.reshape(v, (-1,)))) for v in leaves))


def _unpack(column: ca.SX, like: Any, symbolic_only: bool = False) -> Any:
    """A tree of the shape of ``like`` with the column's elements for leaves."""
    position = 0

    def rebuild(tree: Any) -> Any:
        nonlocal position
        if tree is None or (symbolic_only and not isinstance(tree, tuple)
                            and not _is_symbolic(tree)):
            return tree
        if isinstance(tree, tuple):
            branches = [rebuild(branch) for branch in tree]
            return type(tree)(*branches) if hasattr(tree, "_fields") else tuple(branches)
        shape = getattr(tree, "shape", ())  # np.shape sees CasADi's two dimensions
        size = int(np.prod(shape, dtype=int))
        position += size
        return np.reshape(column[position - size : position], shape)

    return rebuild(like)
