"""A ring of trivial FMUs in C: each puts out its ten inputs of the step before."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import fmpy

WIDTH = 10
SOURCE = """
#include <stdlib.h>
typedef struct {{ double in[{width}], out[{width}]; }} Fmu;
#define EXPORT __attribute__((visibility("default")))
typedef const unsigned *Refs;
EXPORT void *fmi2Instantiate(const char *n, int t, const char *g, const char *r, const void *f,
                             int v, int l) {{ return calloc(1, sizeof(Fmu)); }}
EXPORT void fmi2FreeInstance(void *c) {{ free(c); }}
EXPORT int fmi2SetupExperiment(void *c, int d, double t, double a, int e, double b) {{ return 0; }}
EXPORT int fmi2EnterInitializationMode(void *c) {{ return 0; }}
EXPORT int fmi2ExitInitializationMode(void *c) {{ return 0; }}
EXPORT int fmi2Terminate(void *c) {{ return 0; }}
EXPORT int fmi2SetReal(void *c, Refs r, size_t n, const double *v) {{
    Fmu *f = c; for (size_t i = 0; i < n; i++) f->in[r[i]] = v[i]; return 0; }}
EXPORT int fmi2GetReal(void *c, Refs r, size_t n, double *v) {{
    Fmu *f = c; for (size_t i = 0; i < n; i++) v[i] = ((double *)f)[r[i]]; return 0; }}
EXPORT int fmi2DoStep(void *c, double t, double h, int x) {{
    Fmu *f = c; for (int i = 0; i < {width}; i++) f->out[i] = f->in[i]; return 0; }}
"""


def build(folder: Path) -> Path:
    """The FMU."""
    source, binary = folder / "shift.c", folder / "shift.so"
    source.write_text(SOURCE.format(width=WIDTH), encoding="utf-8")
    command = ["cc", "-O2", "-shared", "-fPIC", "-fvisibility=hidden", str(source), "-o"]
    subprocess.run([*command, str(binary)], check=True)
    ports = "".join(
        f'<ScalarVariable name="{name}[{i + 1}]" valueReference="{offset + i}" '
        f'causality="{causality}"><Real {start}/></ScalarVariable>'
        for name, causality, offset, start in (
            ("u", "input", 0, 'start="0.0"'), ("y", "output", WIDTH, ""),
        )
        for i in range(WIDTH)
    )  # fmt: skip
    unknowns = "".join(f'<Unknown index="{WIDTH + i + 1}" dependencies=""/>' for i in range(WIDTH))
    xml = (
        '<fmiModelDescription fmiVersion="2.0" modelName="shift" guid="shift">'
        f'<CoSimulation modelIdentifier="shift"/><ModelVariables>{ports}</ModelVariables>'
        f"<ModelStructure><Outputs>{unknowns}</Outputs></ModelStructure></fmiModelDescription>"
    )
    path = folder / "shift.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", xml)
        archive.write(binary, f"binaries/{fmpy.platform}/shift.so")
    return path


def config(folder: Path, count: int = 4, steps: int = 1_000_000) -> Path:
    """The system of a ring; what is recorded is the last row."""
    build(folder)
    names = [f"a{i}" for i in range(count)]
    links = [f'"{a}.y -> {b}.u",' for a, b in zip(names, names[1:] + names[:1], strict=True)]
    path = folder / "ring.toml"
    path.write_text(
        f"connections = [{' '.join(links)}]\n[simulation]\nstop_time = {steps * 0.001}\n"
        f"step = 0.001\n[record]\nevery = {steps * 0.001}\n"
        + "".join(f'[instances.{n}]\nfmu = "shift.fmu"\n' for n in names),
        encoding="utf-8",
    )
    return path
