"""Loops of fixed length that native code keeps as loops.

A ``for`` in an equation is unrolled when native code is made of it: a long one makes a large and
slow build. :func:`repeat` does the same and stays one function, called again and again.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, TypeVar

Given = TypeVar("Given")
Values = TypeVar("Values")
Loop = Callable[[Callable[[Any, Any], Any], int, Any, Any], Any]


def _plain(step: Callable[[Any, Any], Any], count: int, given: Any, values: Any) -> Any:
    for _ in range(count):
        values = step(given, values)
    return values


LOOP: ContextVar[Loop] = ContextVar("loop", default=_plain)  # code generation puts its own here


def repeat(
    step: Callable[[Given, Values], Values], count: int, given: Given, values: Values
) -> Values:
    """``values`` after ``count`` times ``values = step(given, values)``.

    ``given`` and ``values`` are tuples or named tuples of arrays (None allowed); ``step`` uses
    nothing else that depends on inputs, parameters or states, and keeps all shapes.
    """
    result: Values = LOOP.get()(step, count, given, values)
    return result
