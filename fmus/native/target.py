"""The native target: an archive with model description, binaries, C sources, documentation."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal

import fmpy

from .. import fmi2
from ..archive import write_archive
from ..documentation import documentation
from ..errors import BuildError
from ..model import Model
from .codegen import equations_source, model_header
from .platforms import choose, compile_library, own_platform, system_compiler, zig_available

UNIT = "fmu.c"
HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
CORE = ("access.c", "evaluate.c", "events.c", "instance.c", "integrate.c", "noise.c",
        "sensitivity.c", "snapshot.c", "step.c")  # fmt: skip
INTERFACE: dict[int, tuple[str, ...]] = {2: ("fmi2.c", "fmi2_run.c")}
LOCAL_HEADERS = ("access.h", "equations.h", "instance.h")
FMI_HEADERS: dict[int, tuple[str, ...]] = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
}
CAPABILITIES = {
    "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}  # fmt: skip
INTERFACES_2: dict[str, dict[str, str]] = {
    "ModelExchange": CAPABILITIES,
    "CoSimulation": CAPABILITIES | {
        "canHandleVariableCommunicationStepSize": "true", "canInterpolateInputs": "true",
        "maxOutputDerivativeOrder": "0",
    },
}  # fmt: skip


def compiler_available() -> bool:
    """Whether native FMUs for this machine can be built on it."""
    return own_platform() is not None and (system_compiler() is not None or zig_available())


def build_native(
    model: Model, *, fmi: Literal[2, 3], platforms: Sequence[str] | None = None, out: Path
) -> None:
    """Write the FMU of a block that could be traced. Raises BuildError.

    ``platforms``: names as in :data:`~.platforms.PLATFORMS`; None: this machine's.
    """
    name = model.block.name
    if model.trace is None:
        raise BuildError(name, ["its equations cannot be traced; build it with --target python"])
    targets = choose(name, platforms)
    sources = source_files(model, fmi)
    members = {f"sources/{n}": text for n, text in sources.items()}
    members["modelDescription.xml"] = description(model, fmi)
    members |= documentation(model)
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_bytes(text)
        for target in targets:
            library = Path(folder) / f"library{target.extension}"
            compile_library(name, target, Path(folder) / UNIT, library)
            members[target.binary(fmi, name)] = library.read_bytes()
    write_archive(out, members)


def _unit(fmi: Literal[2, 3]) -> bytes:
    """The one C file to compile: all others in it, which is faster to compile and to run."""
    files = ("equations.c", *CORE, *INTERFACE[fmi])
    return "".join(f'#include "{f}"\n' for f in files).encode()


def source_files(model: Model, fmi: Literal[2, 3]) -> dict[str, bytes]:
    """All files of the FMU's folder ``sources``."""
    files = {n: (HEADERS / n).read_bytes() for n in FMI_HEADERS[fmi]}
    local = (*CORE, *INTERFACE[fmi], *LOCAL_HEADERS, f"fmi{fmi}.h")
    files |= {n: (HERE / n).read_bytes() for n in local}
    files["equations.c"] = equations_source(model, fmi).encode()
    files[UNIT] = _unit(fmi)
    files["model.h"] = model_header(model, token(model, fmi)).encode()
    return files


def description(model: Model, fmi: Literal[2, 3]) -> bytes:
    """The model description."""
    return fmi2.render(model, token(model, fmi), INTERFACES_2, (UNIT,))


def token(model: Model, fmi: Literal[2, 3]) -> str:
    """The FMU's identity: a hash of interface, equations and runtime."""
    digest = hashlib.sha256(_runtime_digest())
    digest.update(equations_source(model, fmi).encode())
    digest.update(repr([(v.name, v.kind, v.unit, v.frame, v.tunable) for v in model.variables])
                  .encode())
    return "{" + digest.hexdigest()[:32] + "}"


@cache
def _runtime_digest() -> bytes:
    digest = hashlib.sha256()
    for path in sorted([*HERE.glob("*.c"), *HERE.glob("*.h")]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.digest()
