"""Why an equation cannot be traced: the place in the block's file, the reason and the remedy."""

from __future__ import annotations

import ast
import builtins
import linecache
import sysconfig
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from textwrap import shorten
from types import CodeType, TracebackType
from typing import Any

from ..components.component import Component
from ..components.loops import repeat
from .traced_arrays import NeedsNumberError

COMPONENTS = Component.__module__.rpartition(".")[0]
CALLERS = (Component.__module__, repeat.__module__)  # they call equations and have none
INSTALLED = tuple(sysconfig.get_path(p) for p in ("stdlib", "platstdlib", "purelib", "platlib"))
LONGEST = 100  # characters of a reason or an expression

SAME_IN_NUMPY = frozenset((  # functions of math whose namesake in numpy can be traced
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign",
    "cos", "cosh", "degrees", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "hypot", "log",
    "log10", "log1p", "log2", "pow", "radians", "sin", "sinh", "sqrt", "tan", "tanh", "trunc",
))  # fmt: skip
STACK = "put elements together by np.stack or np.concatenate"
REMEDIES = {
    "builtins.float": "leave float out, numpy takes the value as it is",
    "builtins.int": "write np.trunc instead of int",
    "builtins.bool": "compare with a number instead of bool",
    "builtins.max": "write np.maximum or np.max instead of max",
    "builtins.min": "write np.minimum or np.min instead of min",
    "builtins.round": "write np.round instead of round",
    "builtins.any": "write np.any instead of any",
    "builtins.all": "write np.all instead of all",
    "numpy.array": "leave np.array out, the value is an array already",
    "numpy.asarray": "leave np.asarray out, the value is an array already",
    "numpy.full": "multiply np.ones by the value",
    "numpy.expand_dims": "write x[None, :] or x[:, None]",
}
OTHERWISE = ("use numpy operations without branches on values (np.where instead of if, "
             "np.logical_and instead of and)")  # fmt: skip
FROZEN = ("draw random numbers from a Noise, take the clock from the argument time, keep memory "
          "in a DiscreteState")  # fmt: skip


class TracingError(Exception):
    """An equation cannot be traced. ``reason``: the equation, what is wrong and the remedy."""

    def __init__(self, block: Component, equation: str, problem: str, remedy: str) -> None:
        self.reason = f"{equation}: {problem}; {remedy}"
        super().__init__(
            f"{block.name}.{equation} cannot become native code: {problem}; {remedy}, "
            "or build a Python FMU (FMI 2.0) with --target python"
        )


def untraceable(block: Component, equation: str, error: Exception) -> TracingError:
    """What stopped the equation, from the error that its call raised."""
    place = _place(type(block), error.__traceback__)
    number = next((e for e in (error, error.__cause__) if isinstance(e, NeedsNumberError)), None)
    if number is not None:
        problem = f"{place or 'it'} {number}"
    elif "__array_" in str(error):  # numpy tells all that the array does not have
        problem = f"{place or 'it'} is not among the operations of numpy that can be traced"
    else:
        lines = str(error).strip().splitlines() or [type(error).__name__]
        problem = (f"{place}: " if place else "") + _short(lines[-1])
    return TracingError(block, equation, problem, place.remedy() if place else OTHERWISE)


def changing(block: Component, equation: str, names: Sequence[str]) -> TracingError:
    """What to say of an equation that gives another result when it is called again."""
    problem = ("called twice with the same values it returns different values of "
               f"{', '.join(names)}, and native code would keep those of the build for ever")
    return TracingError(block, equation, problem, FROZEN)


@dataclass(frozen=True)
class _Place:
    """Where in the block's file: the expression, as it stands there, and what its names mean."""

    file: str
    line: int
    expression: str
    names: Mapping[str, Any]

    def __str__(self) -> str:
        where = f"{Path(self.file).name}, line {self.line}"
        return f"{_short(self.expression)} ({where})" if self.expression else where

    def remedy(self) -> str:
        """What to write instead of the expression."""
        try:
            statement = ast.parse(self.expression).body[0]
        except (SyntaxError, IndexError):
            return OTHERWISE
        if isinstance(statement, ast.AugAssign):
            return "write a = a + b instead of a += b"
        if not isinstance(statement, ast.Expr):
            return OTHERWISE
        if isinstance(statement.value, ast.Subscript):
            return STACK
        if not isinstance(statement.value, ast.Call):
            return OTHERWISE
        if any(isinstance(a, ast.List) for a in statement.value.args):
            return STACK
        called = self._meaning(statement.value.func)
        module, name = getattr(called, "__module__", ""), getattr(called, "__name__", "")
        if module == "math" and name in SAME_IN_NUMPY:
            return f"write np.{name} instead of math.{name}"
        return REMEDIES.get(f"{module}.{name}", OTHERWISE)

    def _meaning(self, function: ast.expr) -> Any:
        if isinstance(function, ast.Attribute):
            return getattr(self._meaning(function.value), function.attr, None)
        if isinstance(function, ast.Name):
            return self.names.get(function.id, getattr(builtins, function.id, None))
        return None


def _place(cls: type, trace: TracebackType | None) -> _Place | None:
    """The innermost place of an error in files that are the block's or another of the user's."""
    own = [t for t in _walk(trace) if _is_own(t.tb_frame.f_globals.get("__name__", ""),
                                              t.tb_frame.f_code.co_filename, cls)]
    if not own:
        return None
    frame, code = own[-1].tb_frame, own[-1].tb_frame.f_code
    return _Place(code.co_filename, own[-1].tb_lineno, _expression(code, own[-1].tb_lasti),
                  {**frame.f_globals, **frame.f_locals})


def _walk(trace: TracebackType | None) -> list[TracebackType]:
    found = []
    while trace is not None:
        found.append(trace)
        trace = trace.tb_next
    return found


def _is_own(module: str, file: str, cls: type) -> bool:
    package = __package__.rpartition(".")[0]
    if module.startswith(f"{package}."):
        return module.startswith(f"{COMPONENTS}.") and module not in CALLERS
    return module == cls.__module__ or not file.startswith(("<", *INSTALLED))


def _expression(code: CodeType, instruction: int) -> str:
    """The source of the instruction, on one line; empty where Python does not know it."""
    line, last, start, end = list(code.co_positions())[instruction // 2]
    if line is None or last is None or start is None or end is None:
        return ""
    lines = [linecache.getline(code.co_filename, n).encode() for n in range(line, last + 1)]
    lines[-1] = lines[-1][:end]
    lines[0] = lines[0][start:]
    return " ".join(b" ".join(lines).decode(errors="replace").split())


def _short(text: str) -> str:
    return shorten(text, LONGEST, placeholder=" ...")
