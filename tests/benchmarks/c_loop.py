"""A loop in C over the FMUs of a plan, written out call by call as one would by hand."""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Iterator
from pathlib import Path

from sightline.orchestrator.fmi.slave import Slave
from sightline.orchestrator.schedule.plan import Block, Plan, Unit
from sightline.orchestrator.stepping.stepper import Stepper

HEAD = """
#include <stddef.h>
typedef int (*Move)(void *, const unsigned *, size_t, void *);
typedef int (*Step)(void *, double, double, int);
typedef struct {{
    void *c;
    Move set_real, get_real, set_int, get_int, set_bool, get_bool;
    Step step;
}} Fmu;

int run(const Fmu *f, double *v, double start, double h, long steps, long stride, double *rows)
{{
    int whole[1000];
{references}
    for (long n = 0; n < steps; n++) {{
        const double t = start + n * h;
{calls}
        if ((n + 1) % stride == 0) {{
{record}
        }}
    }}
    return 0;
}}
"""
SHORT = {"Real": "real", "Integer": "int", "Boolean": "bool"}
MOVES = [f"fmi2{verb}{type_}" for type_ in SHORT for verb in ("Set", "Get")]


class _Fmu(ctypes.Structure):
    _fields_ = tuple((name, ctypes.c_void_p) for name in ("component", *MOVES, "step"))


class CLoop:
    """Runs the steps of an initialised stepper: Gauss-Seidel, FMI 2.0, one rate."""

    def __init__(self, stepper: Stepper, folder: Path) -> None:
        self.stepper = stepper
        source = folder / f"loop_{len(stepper.plan.units)}.c"
        binary = source.with_suffix(".so")
        if not binary.exists():  # once loaded it must not be written again
            source.write_text(_source(stepper.plan), encoding="utf-8")
            command = ["cc", "-O2", "-ffp-contract=off", "-shared", "-fPIC", str(source), "-o"]
            subprocess.run([*command, str(binary)], check=True)
        self._library = ctypes.CDLL(str(binary))
        slaves = [stepper.slaves[u.node] for u in stepper.plan.units]
        self._fmus = (_Fmu * len(slaves))(*(_fmu(s) for s in slaves))

    def run(self, steps: int, stride: int, rows: ctypes.Array[ctypes.c_double]) -> None:
        """Take all steps."""
        stepper = self.stepper
        values = ctypes.c_void_p(stepper.values.ctypes.data)
        status = self._library.run(
            self._fmus, values, ctypes.c_double(stepper.start), ctypes.c_double(stepper.step),
            ctypes.c_long(steps), ctypes.c_long(stride), rows,
        )  # fmt: skip
        assert status == 0


def _fmu(slave: Slave) -> _Fmu:
    return _Fmu(slave.component, *(slave.library.address(n) for n in (*MOVES, "fmi2DoStep")))


def _source(plan: Plan) -> str:
    references = "\n".join(
        f"    static const unsigned r{block.first}[] = {{{', '.join(map(str, block.references))}}};"
        for unit in plan.units
        for block in (*unit.inputs.blocks, *unit.outputs.blocks)
    )
    calls = "\n".join(f"        {line}" for i, u in enumerate(plan.units) for line in _unit(i, u))
    lines = [f"*rows++ = v[{position}];" for position in plan.recorded]
    record = "\n".join(f"            {line}" for line in lines)
    return HEAD.format(references=references, calls=calls, record=record)


def _unit(number: int, unit: Unit) -> Iterator[str]:
    f = f"f[{number}]"
    for k, source in enumerate(unit.sources):
        yield f"v[{unit.inputs.first + k}] = v[{source}];"
    for block in unit.inputs.blocks:
        yield from _move(f, "set", block)
    yield f"if ({f}.step({f}.c, t, h, 0) > 1) return 1;"
    for block in unit.outputs.blocks:
        yield from _move(f, "get", block)


def _move(f: str, verb: str, block: Block) -> Iterator[str]:
    places = list(range(block.first, block.last))
    data = f"v + {block.first}" if block.type == "Real" else "whole"
    if verb == "set" and data == "whole":
        yield " ".join(f"whole[{i}] = v[{p}];" for i, p in enumerate(places))
    call = f"{f}.{verb}_{SHORT[block.type]}({f}.c, r{block.first}, {len(places)}, {data})"
    yield f"if ({call} > 1) return 1;"
    if verb == "get" and data == "whole":
        yield " ".join(f"v[{p}] = whole[{i}];" for i, p in enumerate(places))
