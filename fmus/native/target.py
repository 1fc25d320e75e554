"""The native target: an archive with model description, binaries, C sources, documentation."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Literal

import fmpy

from .. import fmi2, fmi3
from ..archive import write_archive
from ..documentation import documentation
from ..errors import BuildError
from ..model import Model
from .codegen import Code, generate
from .platforms import (
    PLATFORMS,
    choose,
    compile_library,
    own_platform,
    system_compiler,
    universal,
    zig_available,
)

UNIT = "fmu.c"
HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
CORE = ("access.c", "evaluate.c", "events.c", "exchange.c", "instance.c", "integrate.c", "noise.c",
        "sensitivity.c", "snapshot.c", "step.c")  # fmt: skip
INTERFACE: dict[int, tuple[str, ...]] = {
    2: ("fmi2.c", "fmi2_run.c"),
    3: ("fmi3.c", "fmi3_absent.c", "fmi3_run.c", "fmi3_values.c"),
}
LOCAL_HEADERS = ("access.h", "equations.h", "instance.h")
FMI_HEADERS: dict[int, tuple[str, ...]] = {
    2: ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
    3: ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
}
COMMON_2 = {
    "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
    "providesDirectionalDerivative": "true",
}  # fmt: skip
COMMON_3 = {
    "canGetAndSetFMUState": "true", "canSerializeFMUState": "true",
    "providesDirectionalDerivatives": "true", "providesAdjointDerivatives": "true",
}  # fmt: skip
STEPPING = {"canHandleVariableCommunicationStepSize": "true", "maxOutputDerivativeOrder": "0"}
INTERFACES_2: dict[str, dict[str, str]] = {
    "ModelExchange": COMMON_2,
    "CoSimulation": COMMON_2 | STEPPING | {"canInterpolateInputs": "true"},
}
INTERFACES_3: dict[str, dict[str, str]] = {
    "ModelExchange": COMMON_3 | {
        "needsCompletedIntegratorStep": "true", "providesEvaluateDiscreteStates": "true",
    },
    "CoSimulation": COMMON_3 | STEPPING | {
        "hasEventMode": "true", "mightReturnEarlyFromDoStep": "true",
        "providesEvaluateDiscreteStates": "true",
    },
}  # fmt: skip


def compiler_available() -> bool:
    """Whether native FMUs for this machine can be built on it."""
    return own_platform() is not None and (system_compiler() is not None or zig_available())


def build_native(
    model: Model, *, fmi: Literal[2, 3], platforms: Sequence[str] | None = None, out: Path
) -> None:
    """Write the FMU of a block that could be traced. Raises BuildError.

    ``platforms``: names as in :data:`~.platforms.PLATFORMS`; None: this machine's, with its own
    compiler.
    """
    name = model.block.name
    if model.trace is None:
        raise BuildError(name, ["its equations cannot be traced; build it with --target python"])
    targets = choose(name, platforms)
    code = generate(model, fmi)
    identity = token(model, code)
    sources = source_files(model, fmi, code, identity)
    members = {f"sources/{n}": text for n, text in sources.items()}
    members["modelDescription.xml"] = description(model, fmi, code, identity)
    members |= documentation(model)
    if fmi == 3:
        members["terminalsAndIcons/icon.png"] = members.pop("model.png")
    with tempfile.TemporaryDirectory() as folder:
        for file, text in sources.items():
            (Path(folder) / file).write_bytes(text)
        for target in targets:
            library = Path(folder) / f"{target.name}{target.extension}"
            source, portable = Path(folder) / UNIT, platforms is not None
            compile_library(name, target, source, library, portable=portable)
            members[target.binary(fmi, name)] = library.read_bytes()
    if fmi == 2:
        _serve_apple_silicon(members, name)
    write_archive(out, members)


def _serve_apple_silicon(members: dict[str, bytes], name: str) -> None:
    """Put the library for arm64 with that for x86-64, where importers of FMI 2.0 look for it.

    The standard wants it in ``aarch64-darwin``, but fmpy, among others, reads ``darwin64`` only.
    """
    intel, arm = (PLATFORMS[p].binary(2, name) for p in ("macos-x86_64", "macos-arm64"))
    if intel in members and arm in members:
        members[intel] = universal([members[intel], members[arm]])


def _unit(fmi: Literal[2, 3]) -> bytes:
    """The one C file to compile: all others in it, which is faster to compile and to run."""
    files = ("equations.c", *CORE, *INTERFACE[fmi])
    return "".join(f'#include "{f}"\n' for f in files).encode()


def source_files(
    model: Model, fmi: Literal[2, 3], code: Code, identity: str
) -> dict[str, bytes]:
    """All files of the FMU's folder ``sources``."""
    files = {n: (HEADERS / n).read_bytes() for n in FMI_HEADERS[fmi]}
    local = (*CORE, *INTERFACE[fmi], *LOCAL_HEADERS, f"fmi{fmi}.h")
    files |= {n: (HERE / n).read_bytes() for n in local}
    if fmi == 3:
        files["buildDescription.xml"] = fmi3.render_build_description(model.block.name, (UNIT,))
    files["equations.c"] = code.equations.encode()
    files["model.h"] = code.header(model.block.name, identity).encode()
    files[UNIT] = _unit(fmi)
    return files


def description(model: Model, fmi: Literal[2, 3], code: Code, identity: str) -> bytes:
    """The model description."""
    interfaces = INTERFACES_2 if fmi == 2 else INTERFACES_3
    if not code.differentiable:
        interfaces = {i: {n: v for n, v in flags.items() if "Derivative" not in n or "max" in n}
                      for i, flags in interfaces.items()}
    if fmi == 3:
        return fmi3.render(model, identity, interfaces)
    return fmi2.render(model, identity, interfaces, (UNIT,))


def token(model: Model, code: Code) -> str:
    """The FMU's identity: a hash of interface, equations and runtime."""
    digest = hashlib.sha256(_runtime_digest() + code.equations.encode())
    interface = [(v.name, v.kind, v.unit, v.frame, v.optional, v.tunable) for v in model.variables]
    digest.update(repr(interface).encode())
    return "{" + digest.hexdigest()[:32] + "}"


@cache
def _runtime_digest() -> bytes:
    digest = hashlib.sha256()
    for path in sorted([*HERE.glob("*.c"), *HERE.glob("*.h")]):
        digest.update(path.name.encode() + path.read_bytes())
    return digest.digest()
