"""Build a Python FMU (FMI 2.0 co-simulation): pythonfmu's archive, with our description in it."""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
import threading
import zipfile
from pathlib import Path
from typing import Any

from pythonfmu.builder import FmuBuilder

from ..archive import write_archive
from ..documentation import documentation
from ..fmi2 import render
from ..model import Model
from ..sources import block_module, block_sources
from . import noise, runtime, slave, solvers

RUNTIME = (noise, runtime, slave, solvers)
CAPABILITIES = {
    "needsExecutionTool": "true", "canHandleVariableCommunicationStepSize": "true",
    "canGetAndSetFMUstate": "true", "canSerializeFMUstate": "true",
    "canNotUseMemoryManagementFunctions": "true",
}  # fmt: skip
SCRIPT = "from {package}.entry import {block}Slave\n"  # what the builder looks for a class in
# What the FMU carries instead. pythonfmu's binary runs it for every instance, releases its globals
# each time, and leaves memory behind for every class that it finds; finding none, it asks the
# module for the name "".
ENTRY = """from {package}.entry import keep, slave_class as __getattr__
keep(globals())
"""
CLASS = '''"""The slave that pythonfmu runs."""

from {package}.fmus.python.slave import BlockSlave, keep
from {package}.{module} import {block}


class {block}Slave(BlockSlave):
    """The slave of {block}."""

    block_class = {block}
    structure = {structure!r}


def slave_class(name: str) -> type[BlockSlave]:
    """The class of the slave, by which name the module is asked for it."""
    if name:
        raise AttributeError(name)
    return {block}Slave
'''

_builder_lock = threading.Lock()  # pythonfmu's builder changes sys.path and sys.modules


def build_python(model: Model, out: Path) -> None:
    """Write the FMU of a block to ``out``."""
    block = type(model.block)
    files = block_sources(block) | {
        f"fmus/python/{Path(str(m.__file__)).name}": Path(str(m.__file__)).read_bytes()
        for m in RUNTIME
    }
    for package in ("", "fmus/", "fmus/python/"):
        files.setdefault(f"{package}__init__.py", b"")
    layout = json.dumps([_slot(v) for v in model.variables], indent=1).encode()
    digest = _digest({**files, slave.LAYOUT_FILE: layout, "entry": (ENTRY + CLASS).encode(),
                      "structure": repr(model.block.structure).encode(),
                      "xml": render(model, "", {"CoSimulation": CAPABILITIES})})
    unique = f"sightline_{block.__name__.lower()}_{digest[:12]}"
    names = {"package": unique, "module": block_module(block), "block": block.__name__,
             "structure": model.block.structure}
    files["entry.py"] = CLASS.format(**names).encode()
    script = Path(f"{unique}_slave.py")
    with tempfile.TemporaryDirectory(prefix="sightline-") as folder:
        source = Path(folder, "source")
        for name, content in files.items():
            _write(source / unique / name, content)
        _write(source / slave.LAYOUT_FILE, layout)
        _write(source / script, SCRIPT.format(**names).encode())
        members = _pythonfmu_archive(source / script)
    members[f"resources/{script}"] = ENTRY.format(**names).encode()
    identifier = f"{block.__name__}Slave"
    members = {n.replace(f"/{identifier}.", f"/{block.__name__}.") if n.startswith("binaries/")
               else n: c for n, c in members.items()}
    members["modelDescription.xml"] = render(model, f"{{{digest}}}", {"CoSimulation": CAPABILITIES})
    write_archive(out, members | documentation(model))


def _slot(variable: Any) -> dict[str, Any]:
    start = variable.start
    return {
        "name": variable.name, "kind": variable.kind, "shape": list(variable.shape),
        "reference": variable.reference, "min": variable.min, "max": variable.max,
        "start": None if start is None else start.ravel().tolist(),
        "is_output": variable.is_output, "tunable": variable.tunable,
    }  # fmt: skip


def _digest(files: dict[str, bytes]) -> str:
    sha = hashlib.sha256()
    for name in sorted(files):
        sha.update(name.encode() + b"\0" + files[name] + b"\0")
    return sha.hexdigest()[:32]


def _write(path: Path, content: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)


def _pythonfmu_archive(script: Path) -> dict[str, bytes]:
    """Members of the archive that pythonfmu's builder makes of a script and what lies beside it."""
    out, beside = script.parent.with_suffix(".fmu"), set(script.parent.iterdir()) - {script}
    with _builder_lock:
        path_before, modules_before = list(sys.path), set(sys.modules)
        try:
            FmuBuilder.build_FMU(script, dest=out, project_files=beside)
        finally:
            sys.path[:] = path_before
            packages = {path.stem for path in beside}
            for name in set(sys.modules) - modules_before:
                if name.partition(".")[0] in packages | {script.stem}:
                    del sys.modules[name]
    with zipfile.ZipFile(out) as archive:
        return {n: archive.read(n) for n in archive.namelist()
                if "__pycache__" not in n and not n.endswith("/")}
