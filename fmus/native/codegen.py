"""The two generated C files of a native FMU: ``model.h`` (sizes) and ``equations.c``.

CasADi writes the equations and their directional and adjoint derivatives; around them stand the
tables of the variables and functions with the signatures that ``equations.h`` declares.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import casadi as ca
import numpy as np

from ..fmi2 import fmi_role
from ..model import Kind, Model, Variable
from ..tracing import ARGUMENTS, Trace

SECTIONS: dict[str, Kind] = {
    "INPUTS": "input", "PARAMETERS": "parameter", "STATES": "state", "DISCRETE": "discrete",
    "OUTPUTS": "output", "DERIVATIVES": "derivative",
}  # fmt: skip
REFERENCES = (
    "sample_period", "solver", "solver_step", "relative_tolerance", "absolute_tolerance", "seed",
)  # fmt: skip
KNOWN_GROUPS = 5  # t, u, p, x, d: all arguments but the noise
HEADER = "/* Generated from the block {name}: do not edit. */\n"
# fmax and fmin of C hide a NaN; numpy's maximum and minimum pass it on
NAN_SAFE = """
static inline double larger(double a, double b) { return a > b || a != a ? a : b; }
static inline double smaller(double a, double b) { return a < b || a != a ? a : b; }
#define fmax larger
#define fmin smaller
"""
# name, result of the signature in equations.h, C expressions of CasADi's arguments and result
ARGS = "v + INPUTS, v + PARAMETERS"
WRAPPERS = (
    ("derivatives", "double t, const double *v, const double *x, double *result",
     f"&t, {ARGS}, x, v + DISCRETE, 0"),
    ("outputs", "const double *v, const double *w, double *result",
     f"v, {ARGS}, v + STATES, v + DISCRETE, w"),
    ("update", "const double *v, const double *w, double *result",
     f"v, {ARGS}, v + STATES, v + DISCRETE, w"),
    ("project", "double t, const double *v, const double *x, double *result",
     f"&t, {ARGS}, x, v + DISCRETE, 0"),
    ("require", "const double *v, double *result",
     f"v, {ARGS}, v + STATES, v + DISCRETE, 0"),
    *(
        (f"{equation}_{mode}", f"const double *v, {noise}const double *seed, double *result",
         f"v, {ARGS}, v + STATES, v + DISCRETE, {'w' if noise else '0'}, seed")
        for equation, noise in (("derivatives", ""), ("outputs", "const double *w, "))
        for mode in ("forward", "reverse")
    ),
)  # fmt: skip


def model_header(model: Model, token: str) -> str:
    """Sizes and sections of the array of values as C constants."""
    constants: dict[str, int] = {}
    for section, kind in SECTIONS.items():
        references = model.references(kind)
        constants["N_" + section] = len(references)
        constants[section] = references[0] if references else 0
    noises = _noise_sizes(model)
    constants |= {
        "N_VALUES": 1 + model.size, "N_NOISE": sum(noises), "N_CHANNELS": len(noises),
        "N_KNOWNS": 1 + sum(constants[f"N_{s}"] for s in list(SECTIONS)[:4]),
        "N_REQUIREMENTS": len(_trace(model).messages),
        "HAS_PROJECT": int("project" in _trace(model).functions),
    }  # fmt: skip
    for name in REFERENCES:
        variable = model.by_name.get(name)
        constants[name.upper()] = variable.reference if variable else 0
    lines = "\n".join(f"    {name} = {value}," for name, value in constants.items())
    return (
        HEADER.format(name=model.block.name) + "#ifndef SIGHTLINE_MODEL_H\n"
        f"#define SIGHTLINE_MODEL_H\n\n#define MODEL_TOKEN {quoted(token)}\n\n"
        "/* Numbers of scalars, first value references of the sections, references; 0: absent */\n"
        f"enum {{\n{lines}\n}};\n\n#endif\n"
    )


def equations_source(model: Model, fmi: Literal[2, 3]) -> str:
    """Tables and equations as C."""
    functions = _functions(_trace(model))
    generator = ca.CodeGenerator("equations.c", {"casadi_int": "int", "verbose": False})
    for function in functions.values():
        generator.add(function)
    code = generator.dump().replace("#include <math.h>", "")
    return "\n".join([
        HEADER.format(name=model.block.name),
        '#include <math.h>\n\n#include "equations.h"',
        _tables(model, fmi),
        NAN_SAFE,
        "#define CASADI_SYMBOL_EXPORT static",
        code,
        *(_wrapper(name, name in functions, *rest) for name, *rest in WRAPPERS),
    ])  # fmt: skip


def quoted(text: str) -> str:
    """A C string literal; everything beyond printable ASCII as octal escapes."""
    escaped = "".join(
        chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode()
    )
    return f'"{escaped}"'


def _trace(model: Model) -> Trace:
    assert model.trace is not None
    return model.trace


def _noise_sizes(model: Model) -> list[int]:
    from ...components.declarations import Noise

    return [noise.size for noise in model.block.of_type(Noise).values()]


def _functions(trace: Trace) -> dict[str, ca.Function]:
    """What equations.c holds, by the name that equations.h gives it without ``model_``."""
    functions: dict[str, ca.Function] = {}
    for equation, traced in trace.functions.items():
        name = "require" if equation == "requirements" else equation
        arguments = [ca.SX.sym(a, traced.size1_in(i)) for i, a in enumerate(ARGUMENTS)]
        result = traced(*arguments)
        functions[name] = _function(name, arguments, result)
        if equation in ("derivatives", "outputs"):
            functions |= _sensitivities(name, arguments, result)
    return functions


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


def _wrapper(name: str, present: bool, parameters: str, arguments: str) -> str:
    body = (
        f"    const double *arguments[] = {{{arguments}}};\n"
        "    double *results[] = {result};\n"
        f"    equations_{name}(arguments, results, 0, 0, 0);\n"
    )
    if not present:
        names = [p.split()[-1].lstrip("*") for p in parameters.split(",")]
        body = "    " + ", ".join(f"(void){n}" for n in names) + ";\n"
    return f"void model_{name}({parameters})\n{{\n{body}}}\n"


def _tables(model: Model, fmi: Literal[2, 3]) -> str:
    scalars = [(v, i) for v in model.variables for i in range(v.size)]
    starts = [_start(v, i) for v, i in scalars]
    messages = [m.replace("%", " percent") for m in _trace(model).messages]
    nominals = [v.nominal or 1.0 for v in model.of_kind("state") for _ in range(v.size)]
    names = [v.scalar_names[i] for v, i in scalars]
    return "\n".join([
        _table("Access model_access[N_VALUES]",
               ["{REAL, TIME, 0, 0, 1}", *(_access(v, i, fmi) for v, i in scalars)]),
        _table("Limits model_limits[N_VALUES]",
               ["{-INFINITY, INFINITY}", *(_limits(v) for v, _ in scalars)]),
        _table("double model_start[N_VALUES]", map(repr, [0.0, *starts])),
        _table("double model_nominal[SOME(N_STATES)]", map(repr, nominals)),
        _table("char *const model_names[N_VALUES]", map(quoted, ["time", *names])),
        _table("char *const model_requirements[SOME(N_REQUIREMENTS)]", map(quoted, messages)),
        _table("int model_noise_sizes[SOME(N_CHANNELS)]", map(str, _noise_sizes(model))),
    ])  # fmt: skip


def _table(declaration: str, rows: Iterable[str]) -> str:
    body = ",\n".join(f"    {row}" for row in rows) or "    0"
    return f"const {declaration} = {{\n{body}}};\n"


def _start(variable: Variable, element: int) -> float:
    return 0.0 if variable.start is None else float(np.ravel(variable.start)[element])


def _access(variable: Variable, element: int, fmi: Literal[2, 3]) -> str:
    kinds: dict[str, str] = {
        "input": "INPUT", "state": "STATE", "discrete": "DISCRETE_STATE", "output": "OUTPUT",
        "derivative": "DERIVATIVE",
    }  # fmt: skip
    variability = fmi_role(variable)[1]
    kind = kinds.get(variable.kind, "TUNABLE" if variability == "tunable" else "FIXED")
    extent = 1 if fmi == 2 else variable.size if element == 0 else 0
    return f"{{{variable.type.upper()}, {kind}, {int(variable.is_output)}, 0, {extent}}}"


def _limits(variable: Variable) -> str:
    low = "-INFINITY" if variable.min is None else repr(float(variable.min))
    high = "INFINITY" if variable.max is None else repr(float(variable.max))
    return f"{{{low}, {high}}}"


