"""The CasADi functions of a native FMU: a block's equations and their derivatives."""

from __future__ import annotations

import casadi as ca
import numpy as np

from ..tracing import ARGUMENTS, Trace

KNOWN_GROUPS = 5  # t, u, p, x, d: all arguments but the noise
LONGEST = 2000  # lines of C of the equations, beyond which their derivatives are left out


def functions_of(trace: Trace) -> dict[str, ca.Function]:
    """What equations.c holds, by the name that equations.h gives it without ``model_``.

    The directional and adjoint derivatives of very long equations (allocators that iterate) are
    left out: they are three times as long again.
    """
    functions: dict[str, ca.Function] = {}
    derived: list[tuple[str, list[ca.SX], ca.SX]] = []
    for equation, traced in trace.functions.items():
        name = "require" if equation == "requirements" else equation
        arguments = [ca.SX.sym(a, traced.size1_in(i)) for i, a in enumerate(ARGUMENTS)]
        result = traced(*arguments)
        functions[name] = _function(name, arguments, result)
        if equation in ("derivatives", "outputs"):
            derived.append((name, arguments, result))
    if sum(code(functions[name]).count("\n") for name, *_ in derived) <= LONGEST:
        for name, arguments, result in derived:
            functions |= _sensitivities(name, arguments, result)
    return functions


def code(*functions: ca.Function) -> str:
    """The functions as C, static, one after the other."""
    generator = ca.CodeGenerator("equations.c", {"casadi_int": "int", "verbose": False})
    for function in functions:
        generator.add(function)
    text: str = generator.dump()
    return text.replace("#include <math.h>", "")


def _sensitivities(name: str, arguments: list[ca.SX], result: ca.SX) -> dict[str, ca.Function]:
    """Forward and reverse mode with respect to time, inputs and states; zero for parameters."""
    knowns = arguments[:KNOWN_GROUPS]
    seeds = [ca.SX.sym(f"seed_{a}", k.numel()) for a, k in zip(ARGUMENTS, knowns, strict=False)]
    bar = ca.SX.sym("bar", result.numel())
    active = [i for i, a in enumerate(ARGUMENTS[:KNOWN_GROUPS]) if a != "p"]
    varied = ca.vertcat(*(knowns[i] for i in active))
    forward = ca.jtimes(result, varied, ca.vertcat(*(seeds[i] for i in active)))
    parts = ca.vertsplit(ca.jtimes(result, varied, bar, True),
                         np.cumsum([0, *(knowns[i].numel() for i in active)]).tolist())
    found = dict(zip(active, parts, strict=True))
    reverse = ca.vertcat(*(found.get(i, ca.SX.zeros(k.numel(), 1)) for i, k in enumerate(knowns)))
    return {
        f"{name}_forward": _function(f"{name}_forward", [*arguments, ca.vertcat(*seeds)], forward),
        f"{name}_reverse": _function(f"{name}_reverse", [*arguments, bar], reverse),
    }


def _function(name: str, arguments: list[ca.SX], result: ca.SX) -> ca.Function:
    return ca.Function(f"equations_{name}", arguments, [ca.cse(ca.densify(result))])
