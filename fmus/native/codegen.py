"""The two generated C files of a native FMU: ``model.h`` (sizes) and ``equations.c``.

CasADi writes the equations and their directional and adjoint derivatives; around them stand the
tables of the variables and functions with the signatures that ``equations.h`` declares.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import casadi as ca

from ..model import Kind, Model
from .equations import code, functions_of
from .tables import noise_sizes, quoted, tables

SECTIONS: dict[str, Kind] = {
    "INPUTS": "input", "PARAMETERS": "parameter", "STATES": "state", "DISCRETE": "discrete",
    "OUTPUTS": "output", "DERIVATIVES": "derivative",
}  # fmt: skip
REFERENCES = (
    "sample_period", "solver", "solver_step", "relative_tolerance", "absolute_tolerance", "seed",
)  # fmt: skip
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


@dataclass(frozen=True)
class Code:
    """Generated C: ``equations.c``, the constants of ``model.h``, and whether derivatives exist."""

    equations: str
    constants: dict[str, int]
    differentiable: bool

    def header(self, name: str, token: str) -> str:
        """model.h: sizes and sections of the array of values as C constants."""
        lines = "\n".join(f"    {name} = {value}," for name, value in self.constants.items())
        return (
            HEADER.format(name=name) + "#ifndef SIGHTLINE_MODEL_H\n"
            f"#define SIGHTLINE_MODEL_H\n\n#define MODEL_TOKEN {quoted(token)}\n\n"
            "/* Numbers of scalars, first value references of the sections, references of single\n"
            "   variables (0: absent), what the block has */\n"
            f"enum {{\n{lines}\n}};\n\n#endif\n"
        )


def generate(model: Model, fmi: Literal[2, 3]) -> Code:
    """The C of a block that could be traced."""
    assert model.trace is not None
    functions = functions_of(model.trace)
    differentiable = any(n.endswith("_forward") for n in functions)
    if not {"outputs", "derivatives"} & functions.keys():
        differentiable = True  # trivially
    equations = "\n".join([
        HEADER.format(name=model.block.name),
        '#include <float.h>\n#include <math.h>\n\n#include "equations.h"',
        tables(model, model.trace.messages, fmi),
        NAN_SAFE,
        "#define CASADI_SYMBOL_EXPORT static",
        code(*functions.values()),
        *(_wrapper(name, functions.get(name), *rest) for name, *rest in WRAPPERS),
    ])  # fmt: skip
    return Code(equations, _constants(model, differentiable), differentiable)


def _constants(model: Model, differentiable: bool) -> dict[str, int]:
    constants: dict[str, int] = {}
    for section, kind in SECTIONS.items():
        references = model.references(kind)
        constants["N_" + section] = len(references)
        constants[section] = references[0] if references else 0
    noises, trace = noise_sizes(model), model.trace
    assert trace is not None
    constants |= {
        "N_VALUES": 1 + model.size, "N_NOISE": sum(noises), "N_CHANNELS": len(noises),
        "N_KNOWNS": 1 + sum(constants[f"N_{s}"] for s in list(SECTIONS)[:4]),
        "N_REQUIREMENTS": len(trace.messages),
        "CHECKED_AT_STEPS": int(_requirements_watch_inputs(model)),
        "HAS_PROJECT": int("project" in trace.functions),
        "HAS_SENSITIVITIES": int(differentiable),
    }  # fmt: skip
    for name in REFERENCES:
        variable = model.by_name.get(name)
        constants[name.upper()] = variable.reference if variable else 0
    return constants


def _requirements_watch_inputs(model: Model) -> bool:
    """Whether a step can break a requirement: those on states and parameters hold throughout."""
    block = model.block
    return block.has("requirements") and not set(block.inputs_).isdisjoint(
        block.arguments("requirements")
    )


def _wrapper(name: str, function: ca.Function | None, parameters: str, arguments: str) -> str:
    if function is None:
        names = [p.split()[-1].lstrip("*") for p in parameters.split(",")]
        body = "    " + ", ".join(f"(void){n}" for n in names) + ";\n"
    else:
        work, given = ("work", function.sz_w()) if _calls(function) else ("0", 0)
        body = (
            f"    const double *arguments[{function.sz_arg()}] = {{{arguments}}};\n"
            f"    double *results[{function.sz_res()}] = {{result}};\n"
            + (f"    double work[{given}];\n" if given else "")
            + f"    equations_{name}(arguments, results, 0, {work}, 0);\n"
        )
    return f"void model_{name}({parameters})\n{{\n{body}}}\n"


def _calls(function: ca.Function) -> bool:
    """Whether the function calls others; only then it uses its work array."""
    return any(function.instruction_id(k) == ca.OP_CALL for k in range(function.n_instructions()))
