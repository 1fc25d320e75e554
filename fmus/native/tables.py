"""The tables of a native FMU's scalars, as C: access, limits, start values, names."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Literal

import numpy as np

from ...components.declarations import Noise
from ..fmi2 import fmi_role
from ..model import Model, Variable


def tables(model: Model, messages: Iterable[str], fmi: Literal[2, 3]) -> str:
    """Definitions of what equations.h declares as data."""
    scalars = [(v, i) for v in model.variables for i in range(v.size)]
    starts = [_start(v, i) for v, i in scalars]
    nominals = [v.nominal or 1.0 for v in model.of_kind("state") for _ in range(v.size)]
    names = [v.scalar_names[i] for v, i in scalars]
    return "\n".join([
        _table("Access model_access[N_VALUES]",
               ["{REAL, TIME, 0, 0, 1, 1}", *_accesses(model, fmi)]),
        _table("Limits model_limits[N_VALUES]",
               ["{-DBL_MAX, DBL_MAX}", *(_limits(v) for v, _ in scalars)]),
        _table("double model_start[N_VALUES]", map(repr, [0.0, *starts])),
        _table("double model_nominal[SOME(N_STATES)]", map(repr, nominals)),
        _table("char *const model_names[N_VALUES]", map(quoted, ["time", *names])),
        _table("char *const model_requirements[SOME(N_REQUIREMENTS)]", map(quoted, messages)),
        _table("int model_noise_sizes[SOME(N_CHANNELS)]", map(str, noise_sizes(model))),
    ])  # fmt: skip


def _table(declaration: str, rows: Iterable[str]) -> str:
    body = ",\n".join(f"    {row}" for row in rows) or "    0"
    return f"const {declaration} = {{\n{body}}};\n"


def _start(variable: Variable, element: int) -> float:
    return 0.0 if variable.start is None else float(np.ravel(variable.start)[element])


def _accesses(model: Model, fmi: Literal[2, 3]) -> list[str]:
    kinds: dict[str, str] = {
        "input": "INPUT", "state": "STATE", "discrete": "DISCRETE_STATE", "output": "OUTPUT",
        "derivative": "DERIVATIVE",
    }  # fmt: skip
    rows: list[str] = []
    run, last = 0, ""
    for variable in reversed(model.variables):
        variability = fmi_role(variable)[1]
        kind = kinds.get(variable.kind, "TUNABLE" if variability == "tunable" else "FIXED")
        common = f"{variable.type.upper()}, {kind}, {int(variable.is_output)}, 0"
        for element in reversed(range(variable.size)):
            extent = 1 if fmi == 2 else variable.size if element == 0 else 0
            run = run + 1 if common == last and fmi == 2 else 1
            last = common
            rows.append(f"{{{common}, {extent}, {run}}}")
    return rows[::-1]


def _limits(variable: Variable) -> str:
    low = "-DBL_MAX" if variable.min is None else repr(float(variable.min))
    high = "DBL_MAX" if variable.max is None else repr(float(variable.max))
    return f"{{{low}, {high}}}"


def noise_sizes(model: Model) -> list[int]:
    """Number of draws of each noise."""
    return [noise.size for noise in model.block.of_type(Noise).values()]


def quoted(text: str) -> str:
    """A C string literal; everything beyond printable ASCII as octal escapes."""
    escaped = "".join(
        chr(b) if 32 <= b < 127 and chr(b) not in '"\\?' else f"\\{b:03o}" for b in text.encode()
    )
    return f'"{escaped}"'
