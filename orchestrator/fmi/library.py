"""An FMU's shared library: loaded once for all its instances, every function bound once."""

from __future__ import annotations

import ctypes
import os
from functools import cache
from pathlib import Path
from typing import Any

import fmpy


class Library:
    """The functions of one binary; raw ones take ready ctypes arguments and give a status."""

    def __init__(self, path: Path) -> None:
        """Raises OSError with what the loader says."""
        before = Path.cwd()
        os.chdir(path.parent)  # some binaries look for others next to them
        try:
            self._library = ctypes.CDLL(str(path))
        finally:
            os.chdir(before)
        self._bound: dict[str, Any] = {}

    def __contains__(self, name: str) -> bool:
        return hasattr(self._library, name)

    def raw(self, name: str) -> Any:
        """A function without argument types, apart from all others of this name."""
        return self._library[name]

    def bind(self, name: str, *types: Any, result: Any = ctypes.c_int) -> Any:
        """A function with argument types. Raises AttributeError if the binary lacks it."""
        if name not in self._bound:
            function = self._library[name]
            function.argtypes, function.restype = types, result
            self._bound[name] = function
        return self._bound[name]

    def address(self, name: str) -> int:
        """Where a function is; 0 if the binary lacks it."""
        if name not in self:
            return 0
        return ctypes.cast(self._library[name], ctypes.c_void_p).value or 0


@cache
def _loaded(path: Path, stamp: int) -> Library:
    return Library(path)


def load(folder: Path, identifier: str, platform: str) -> Library:
    """The binary of an unpacked FMU, the same for all who ask. Raises OSError."""
    path = folder / "binaries" / platform / f"{identifier}{fmpy.sharedLibraryExtension}"
    return _loaded(path.resolve(), path.stat().st_mtime_ns)


def references(values: tuple[int, ...]) -> Any:
    """Value references as C has them."""
    return (ctypes.c_uint * len(values))(*values)
