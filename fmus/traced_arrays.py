"""The arrays that stand for values while equations are traced: CasADi's, where they lack something.

They have no number yet. CasADi makes NaN of one that is asked for its number (``math.sin(u)``,
``float(u)``), and selects elements otherwise than numpy; the first is an error here, the second
mended.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import casadi as ca
import numpy as np

from ..components.loops import LOOP
from .loops import traced_loop

SYMBOLIC = ca.casadi.ArrayInterfaceSX

_lock = threading.Lock()


class NeedsNumberError(Exception):
    """Python asks an array that is traced for its number, or whether it is true."""


@contextmanager
def numpy_mode() -> Iterator[None]:
    """CasADi's numpy mode, which is global to the process, for the length of a block."""
    with _lock:
        before = ca.GlobalOptions.getNumpyMode()
        ca.GlobalOptions.setNumpyMode(1)
        for name, method in METHODS.items():
            setattr(SYMBOLIC, name, method)
        loop = LOOP.set(traced_loop)
        try:
            yield
        finally:
            LOOP.reset(loop)
            for name in METHODS:
                delattr(SYMBOLIC, name)
            ca.GlobalOptions.setNumpyMode(before)


def _number(name: str, does: str = "takes the number of") -> Callable[..., Any]:
    """The method ``name`` for constants; an error for all else."""
    plain = getattr(SYMBOLIC, name)

    def method(array: Any, *options: Any, **more: Any) -> Any:
        if not ca.SX(np.reshape(array, (-1,))).is_constant():
            raise NeedsNumberError(f"{does} a value that is known only when the FMU runs")
        return plain(array, *options, **more)

    return method


_plain_item: Any = SYMBOLIC.__getitem__


def _item(array: Any, key: Any) -> Any:
    """What ``key`` selects, as numpy has it."""
    keys = key if isinstance(key, tuple) else (key,)
    if keys and all(type(k) in (int, slice) for k in keys):
        return _plain_item(array, key)
    chosen: Any = np.arange(array.size).reshape(array.shape)[key]
    return np.reshape(_plain_item(np.reshape(array, (-1,)), chosen.ravel()), chosen.shape)


METHODS: dict[str, Callable[..., Any]] = {
    "__array__": _number("__array__"),
    "__float__": _number("__float__"),
    "__int__": _number("__int__"),
    "__bool__": _number("__bool__", "branches on"),
    "__getitem__": _item,
}
