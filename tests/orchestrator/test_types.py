"""All numeric types of FMI 3.0 pass between FMUs, to the bit, in both steppers."""

from __future__ import annotations

import shutil
from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

from .foreign import archive, library

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="writes an FMU in C")
STARTS = {
    "Float64": "0.1 -2.5", "Float32": "0.25 -1.5", "Int8": "-128 127", "UInt8": "0 255",
    "Int16": "-32768 32767", "UInt16": "0 65535", "Int32": "-2147483648 2147483647",
    "UInt32": "0 4294967295", "Int64": "-9007199254740992 9007199254740992",
    "UInt64": "0 9007199254740992", "Boolean": "true false",
}  # fmt: skip
SOURCE = r"""
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
typedef const uint32_t *Refs;
typedef struct { char in[16][16], out[16][16]; } Fmu; /* two values of each type */
void *fmi3InstantiateCoSimulation(const char *n, const char *t, const char *r, bool v, bool l,
    bool e, bool y, Refs q, size_t nq, void *env, void *log, void *update)
{ return e || y ? NULL : calloc(1, sizeof(Fmu)); }
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool d, double t, double a, bool e, double b) { return 0; }
int fmi3ExitInitializationMode(void *c) { return 0; }
int fmi3Terminate(void *c) { return 0; }
int fmi3DoStep(void *c, double t, double h, bool n, bool *event, bool *end, bool *early, double *at)
{
    Fmu *f = c;
    memcpy(f->out, f->in, sizeof f->out);
    *event = *end = *early = false;
    *at = t + h;
    return 0;
}
#define TYPE(name, type)                                                                     \
    int fmi3Set##name(void *c, Refs r, size_t n, const type *v, size_t count)                \
    { memcpy(((Fmu *)c)->in[r[0]], v, 2 * sizeof(type)); return n != 1 || count != 2; }      \
    int fmi3Get##name(void *c, Refs r, size_t n, type *v, size_t count)                      \
    {                                                                                        \
        Fmu *f = c;                                                                          \
        memcpy(v, r[0] < 16 ? f->in[r[0]] : f->out[r[0] - 16], 2 * sizeof(type));            \
        return n != 1 || count != 2;                                                         \
    }
TYPE(Float64, double) TYPE(Float32, float) TYPE(Int8, int8_t) TYPE(UInt8, uint8_t)
TYPE(Int16, int16_t) TYPE(UInt16, uint16_t) TYPE(Int32, int32_t) TYPE(UInt32, uint32_t)
TYPE(Int64, int64_t) TYPE(UInt64, uint64_t) TYPE(Boolean, bool)
"""


@pytest.fixture
def shift(tmp_path: Path) -> Path:
    """An FMU that puts out its inputs of the step before; references 16 and up are outputs."""
    binary = library(tmp_path, "shift", SOURCE)
    ports = "".join(
        f'<{type_} name="{name}_{type_}" valueReference="{first + i}" causality="{causality}" '
        f'variability="{"continuous" if type_.startswith("Float") else "discrete"}" {extra}>'
        f'<Dimension start="2"/></{type_}>'
        for i, (type_, start) in enumerate(STARTS.items())
        for name, first, causality, extra in (
            ("u", 0, "input", f'start="{start}"'), ("y", 16, "output", ""),
        )
    )  # fmt: skip
    outputs = "".join(
        f'<Output valueReference="{16 + i}" dependencies=""/>' for i in range(len(STARTS))
    )
    xml = (
        '<fmiModelDescription fmiVersion="3.0" modelName="shift" instantiationToken="x">'
        f'<CoSimulation modelIdentifier="shift"/><ModelVariables>{ports}</ModelVariables>'
        f"<ModelStructure>{outputs}</ModelStructure></fmiModelDescription>"
    )
    return archive(tmp_path / "shift.fmu", xml, binary, fmpy.platform_tuple)


def values(type_: str) -> np.ndarray:
    """The start values of a type."""
    words = STARTS[type_].split()
    if type_ == "Boolean":
        return np.array([w == "true" for w in words], dtype="u1")
    return np.array([float(w) for w in words])


@pytest.mark.parametrize("stepper", ["python", "compiled"])
def test_extreme_values_of_all_types_pass(write, shift, tmp_path, monkeypatch, stepper) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    starts = ", ".join(
        f"u_{t} = [{', '.join(s.split())}]" for t, s in STARTS.items()
    )
    links = [f"a.y_{t} -> b.u_{t}" for t in STARTS]
    table = 'fmu = "shift.fmu"\n'
    path = write(links, a=f"{table}start = {{ {starts} }}", b=table)
    results = System.from_toml(path).simulate(tmp_path / "out")
    for type_ in STARTS:
        # a puts out its inputs from the second row on, b one step later
        np.testing.assert_array_equal(results[f"b.y_{type_}"][-1], values(type_), err_msg=type_)


def test_types_of_eight_bytes_are_recorded_whole(write, shift, tmp_path) -> None:
    path = write(a=f'fmu = "shift.fmu"\nstart = {{ u_Int64 = [{2**40}, 0] }}')
    results = System.from_toml(path).simulate(tmp_path / "out")
    assert results["a.y_Int64"].dtype == np.int64
    assert results["a.y_Int64"][-1].tolist() == [2**40, 0]
