"""Find a block by its name in the catalogue, or in a user's own file."""

from __future__ import annotations

import difflib
import hashlib
import importlib.util
import inspect
import sys
from collections.abc import Mapping
from os.path import isfile  # which answers for whatever is no path, too
from pathlib import Path

from ..components.catalogue import find
from ..components.component import Component
from ..components.errors import DeclarationError, UnknownBlockError
from .errors import BuildError


def load_block(reference: str, structure: Mapping[str, int] | None = None) -> Component:
    """The block that ``reference`` names, with its structure bound and its declarations checked.

    ``reference`` is a name of the catalogue (``FreeRigidBody``) or a file of the user's own and a
    class in it (``my_blocks.py:MyController``; the class may be left out if there is only one).
    Raises BuildError if there is none or it is declared wrongly.
    """
    cls = load_class(reference)
    try:
        block = cls(**(structure or {}))
        block.check()
    except DeclarationError as error:
        raise BuildError(reference, [str(error)]) from None
    except (Exception, SystemExit) as error:
        problem = f"its equations fail at the start values: {_describe(error)}"
        raise BuildError(reference, [problem]) from error
    return block


def load_class(reference: str) -> type[Component]:
    """The class that ``reference`` names. Raises BuildError."""
    path, _, class_name = reference.partition(".py")
    if not _ and ":" not in reference:
        try:
            return find(reference)
        except UnknownBlockError as error:
            raise BuildError(reference, [str(error)]) from None
    return _from_file(reference, Path(path + ".py"), class_name.lstrip(":"))


def _from_file(reference: str, path: Path, class_name: str) -> type[Component]:
    if not isfile(path):
        raise BuildError(reference, [f"there is no file {path}"])
    source = path.read_bytes()
    name = f"_sightline_user_{path.stem}_{hashlib.sha256(source).hexdigest()[:12]}"
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except SyntaxError as error:
        raise BuildError(reference, [f"{path}, line {error.lineno}: {error.msg}"]) from None
    except DeclarationError as error:
        raise BuildError(reference, [str(error)]) from None
    except (Exception, SystemExit) as error:
        raise BuildError(reference, [f"{path} cannot be imported: {_describe(error)}"]) from error
    blocks = {
        n: c for n, c in inspect.getmembers(module, inspect.isclass)
        if issubclass(c, Component) and c.__module__ == name
    }
    if class_name in blocks:
        return blocks[class_name]
    if not class_name and len(blocks) == 1:
        return next(iter(blocks.values()))
    listed = ", ".join(blocks) or "none"
    if not class_name:
        raise BuildError(reference, [f"name the block: {path}:CLASS; {path} defines {listed}"])
    close = difflib.get_close_matches(class_name, blocks, n=1)
    hint = f"did you mean {close[0]}?" if close else f"it defines {listed}"
    raise BuildError(reference, [f"{path} defines no block {class_name}; {hint}"])


def _describe(error: BaseException) -> str:
    """Kind and text of an error without its stack."""
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
