"""Build the FMU of a block, or take it from the cache.

The cache is keyed by the content of everything that goes into an FMU, so that a change in a block
rebuilds its FMU and no other.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Mapping, Sequence
from importlib.metadata import version
from os.path import isfile  # which answers for whatever is no path, too
from pathlib import Path
from typing import Literal, TypeAlias

import platformdirs

from ..components.component import Component
from .archive import complete
from .errors import BuildError
from .load import load_block
from .model import Model, model_of
from .sources import block_sources
from .tracing import Trace, trace
from .units import UnitError, unit
from .untraceable import TracingError

Target: TypeAlias = Literal["python", "native"]
Traced: TypeAlias = Trace | TracingError  # of a block that can be traced, and of one that cannot
TOOLS = ("sightline", "casadi", "pythonfmu", "fmpy")  # whose versions show in an FMU


def cache_folder() -> Path:
    """Where built FMUs are kept: SIGHTLINE_CACHE, or the user's cache folder."""
    return Path(os.environ.get("SIGHTLINE_CACHE") or platformdirs.user_cache_dir("sightline"))


def build(
    component: str,
    *,
    structure: Mapping[str, int] | None = None,
    target: Target | None = None,
    fmi: Literal[2, 3] = 2,
    platforms: Sequence[str] | None = None,
    out: Path | None = None,
    begun: Callable[[], None] = lambda: None,
    note: Callable[[str], None] = lambda text: None,
) -> Path:
    """The path of the block's FMU, built if the cache does not hold it.

    ``component``: a block's name or ``file.py:Class``. ``target``: None takes native where a C
    compiler is found and the block can be traced, or ``fmi`` or ``platforms`` ask for it, else
    python. ``platforms``: of a native FMU, None for this machine's. ``out``: a folder that gets a
    copy named after the block; None leaves the FMU in the cache. ``begun`` is called if it is
    really built, ``note`` with the reason if the FMU is a Python one although there is a compiler.
    Raises BuildError with every reason, OSError if ``out`` cannot be written to.
    """
    block = load_block(component, structure)
    if target == "python" and fmi != 2:
        raise BuildError(component, ["a Python FMU is FMI 2.0; FMI 3.0 needs --target native"])
    if target == "python" and platforms:
        raise BuildError(component, ["a Python FMU takes no platform, it runs on Python"])
    traced: Traced | None = None
    if target is None and (fmi != 2 or platforms):
        target = "native"
    elif target is None:
        target, traced = _default_target(block)
    if isinstance(traced, TracingError):
        note(f"{block.name} runs as a Python FMU, slower: {traced.reason}")
    cached = _cached(block, target, fmi, platforms)
    if not isfile(cached):
        begun()
        model = describe(component, block, target, traced)
        try:
            _write(model, target, fmi, platforms, cached)
        except OSError as error:
            raise BuildError(component, [_unwritable(error)]) from None
    if out is None:
        return cached
    copy, content = out / f"{block.name}.fmu", cached.read_bytes()
    with complete(copy) as stream:
        stream.write(content)
    return copy


def describe(
    component: str, block: Component, target: Target, traced: Traced | None = None
) -> Model:
    """The interface of the block's FMU. Raises BuildError for unknown units or, native, tracing.

    ``traced``: what tracing the block gave, if it is known.
    """
    problems = []
    for name, quantity in block.quantities.items():
        try:
            unit(str(quantity.unit))
        except UnitError as error:
            problems.append(f"{block.name}.{name}: {error}")
    traced = traced or _traced(block)
    if isinstance(traced, TracingError) and target == "native":
        problems.append(str(traced))
    if problems:
        raise BuildError(component, problems)
    return model_of(
        block, traced if isinstance(traced, Trace) else None, derivatives=target == "native"
    )


def _write(
    model: Model, target: Target, fmi: Literal[2, 3], platforms: Sequence[str] | None, path: Path
) -> None:
    if target == "python":
        from .python.target import build_python

        build_python(model, path)
    else:
        from .native.target import build_native

        build_native(model, fmi=fmi, platforms=platforms, out=path)


def _unwritable(error: OSError) -> str:
    folder = error.filename or "the folder of temporary files"
    if folder == str(cache_folder()):
        folder = f"the cache of FMUs, {folder}"
    remedy = "SIGHTLINE_CACHE and TMPDIR name other folders"
    return f"cannot write to {folder}: {error.strerror or error}; {remedy}"


def _traced(block: Component) -> Traced:
    try:
        return trace(block)
    except TracingError as error:
        return error


def _default_target(block: Component) -> tuple[Target, Traced | None]:
    """The target that nobody chose, and what tracing gave if that decided."""
    from .native.target import compiler_available

    if not compiler_available():
        return "python", None
    if isfile(_cached(block, "native", 2, None)):
        return "native", None
    traced = _traced(block)
    return "python" if isinstance(traced, TracingError) else "native", traced


def _cached(
    block: Component, target: Target, fmi: int, platforms: Sequence[str] | None
) -> Path:
    return cache_folder() / f"{block.name}-{_key(block, target, fmi, platforms)}.fmu"


def _key(
    block: Component, target: Target, fmi: int, platforms: Sequence[str] | None
) -> str:
    sha = hashlib.sha256(repr((sorted(block.structure.items()), target, fmi,
                               sorted(platforms or ()), *map(version, TOOLS))).encode())
    for name, content in sorted(block_sources(type(block)).items()):
        sha.update(name.encode() + content)
    here = Path(__file__).parent
    for path in sorted([*here.glob("*.py"), *(here / target).glob("*")]):
        if path.is_file() and path.suffix in (".py", ".c", ".h"):
            sha.update(path.read_bytes())
    return sha.hexdigest()[:16]
