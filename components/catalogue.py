"""The blocks that come with the package, by family.

A family is a subpackage; a block is a public Component class defined in one of its modules. A new
block is found by being there: nothing has to be registered.
"""

from __future__ import annotations

import importlib
import inspect
import pkgutil
from functools import cache
from types import ModuleType

from .component import Component
from .errors import UnknownBlockError


@cache
def families() -> dict[str, dict[str, type[Component]]]:
    """Blocks by family and name, both in alphabetical order."""
    root = importlib.import_module(__package__)
    return {
        info.name: _blocks(importlib.import_module(f"{root.__name__}.{info.name}"))
        for info in sorted(pkgutil.iter_modules(root.__path__), key=lambda i: i.name)
        if info.ispkg
    }


def blocks() -> dict[str, type[Component]]:
    """All blocks by name."""
    return {name: block for family in families().values() for name, block in family.items()}


def find(name: str) -> type[Component]:
    """The block of this name. Raises UnknownBlockError, with the nearest names, if there is none.
    """
    known = blocks()
    if name not in known:
        raise UnknownBlockError(name, tuple(known))
    return known[name]


def summary(block: type[Component]) -> str:
    """The first line of the block's docstring."""
    return (inspect.getdoc(block) or "").partition("\n")[0]


def _blocks(family: ModuleType) -> dict[str, type[Component]]:
    modules = [
        importlib.import_module(f"{family.__name__}.{info.name}")
        for info in pkgutil.iter_modules(family.__path__)
    ]
    found = {
        name: value
        for module in modules
        for name, value in vars(module).items()
        if inspect.isclass(value) and issubclass(value, Component)
        and value.__module__ == module.__name__ and not name.startswith("_")
        and value().outputs_  # a class without is a base of blocks
    }
    return dict(sorted(found.items()))
