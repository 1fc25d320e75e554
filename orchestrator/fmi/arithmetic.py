"""Keeps floating-point arithmetic as it is while foreign code is loaded and set up.

A library may switch on traps, so that a division by zero anywhere ends the whole process, or have
tiny numbers flushed to zero, so that results depend on who else is loaded. Without traps such a
division gives an infinity or NaN, which :mod:`..stepping.finite` finds. What traps in a step all
the same ends the run with a message: see ``stepping/_traps.pxd``.
"""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any

SIZE = 256  # bytes, more than fenv_t has anywhere


@contextmanager
def kept() -> Iterator[None]:
    """Traps, rounding and the like afterwards as before, where the platform can do it."""
    library, environment = _library(), ctypes.create_string_buffer(SIZE)
    if library is None or library.fegetenv(environment):
        yield
        return
    try:
        yield
    finally:
        library.fesetenv(environment)


@cache
def _library() -> Any:
    try:
        library = ctypes.CDLL(None)
        return library if library.fegetenv and library.fesetenv else None
    except (AttributeError, OSError, TypeError):
        return None
