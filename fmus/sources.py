"""The Python files that a block consists of: its own module and what that imports of Sightline."""

from __future__ import annotations

import ast
import importlib.util
import inspect
import re
import sys
from keyword import iskeyword
from pathlib import Path

from ..components.component import Component

ROOT = __package__.rpartition(".")[0]  # the import name under which the packages are installed
CORE = f"{ROOT}.components.component"


def block_module(cls: type[Component]) -> str:
    """Dotted name of the block's module inside a package of its own, relative to its root."""
    module = cls.__module__
    if module.startswith(f"{ROOT}."):
        return module.removeprefix(f"{ROOT}.")
    return f"user.{_own_name(Path(inspect.getfile(cls)))}"


def block_sources(cls: type[Component]) -> dict[str, bytes]:
    """Files of a package that can run the block with numpy only: relative path -> content.

    A user's own file is taken along as ``user/<name>.py``, or a similar name if it cannot be
    imported by its own, its imports of ``sightline`` turned to the copy beside it.
    """
    files: dict[str, bytes] = {}
    modules = [CORE, *(c.__module__ for c in cls.__mro__ if issubclass(c, Component))]
    for module in modules:
        _add(module, files)
    return files


def _add(module: str, files: dict[str, bytes]) -> None:
    if not module.startswith(f"{ROOT}."):
        source = Path(inspect.getfile(sys.modules[module]))
        own = source.read_text(encoding="utf-8")
        files[f"user/{_own_name(source)}.py"] = _relative(own).encode()
        files["user/__init__.py"] = b""
        for name in _imported(own, "user"):
            _add(name, files)
        return
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        return
    path = module.removeprefix(f"{ROOT}.").replace(".", "/")
    package = spec.submodule_search_locations is not None
    name = f"{path}/__init__.py" if package else f"{path}.py"
    if name in files:
        return
    content = Path(spec.origin).read_bytes()
    files[name] = content
    _add(module.rpartition(".")[0], files) if module.count(".") > ROOT.count(".") + 1 else None
    for imported in _imported(content.decode(), module if package else module.rpartition(".")[0]):
        _add(imported, files)


def _own_name(source: Path) -> str:
    """The name of the module that a user's file becomes."""
    name = source.stem
    if name.isascii() and name.isidentifier() and not iskeyword(name) and name != "__init__":
        return name
    return "own_" + re.sub(r"[^0-9A-Za-z]", "_", name)


def _relative(source: str) -> str:
    """The source with its imports of Sightline turned to the package that carries it."""
    source = re.sub(rf"^(\s*)from {ROOT}\b(?:\.|(?= import))", r"\1from ..", source, flags=re.M)
    return re.sub(
        rf"^(\s*)import {ROOT}\.((?:\w+\.)*)(\w+) as ",
        lambda m: f"{m[1]}from ..{m[2].rstrip('.')} import {m[3]} as ", source, flags=re.M,
    )


def _imported(source: str, package: str) -> list[str]:
    """Absolute names of the modules of Sightline that a source text imports."""
    names: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names += [a.name for a in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = importlib.util.resolve_name("." * node.level + (node.module or ""), package) \
                if node.level else node.module or ""
            names += [base, *(f"{base}.{a.name}" for a in node.names)]
    return [n for n in names if n.startswith(f"{ROOT}.") and _is_module(n)]


def _is_module(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False
