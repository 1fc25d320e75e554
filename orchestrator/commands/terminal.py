"""What commands print with, and how they say that something cannot be written."""

from __future__ import annotations

from os.path import isfile  # which answers for whatever is no path, too
from pathlib import Path

from rich.console import Console


def console(stderr: bool = False) -> Console:
    """Prints texts as they are: no line is broken, no number coloured, no ``:x:`` replaced."""
    return Console(stderr=stderr, highlight=False, soft_wrap=True, emoji=False)


def unwritable(out: Path, error: OSError) -> str:
    """The line that says why a folder cannot be written to."""
    why = "it is a file, not a folder" if isfile(out) else error.strerror or error
    return f"cannot write to {out}: {why}"
