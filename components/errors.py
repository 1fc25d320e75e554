"""Errors of declarations and look-ups, with the component and the port that they concern."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from dataclasses import dataclass


def nearest(name: str, valid: Iterable[str]) -> str:
    """The remedy for an unknown name: the nearest valid ones, or all of them."""
    names = sorted(valid)
    close = difflib.get_close_matches(name, names, n=3)
    if close:
        return "did you mean " + " or ".join(repr(n) for n in close) + "?"
    return "valid are " + ", ".join(names) if names else "none are declared"


@dataclass
class DeclarationError(Exception):
    """A block is declared wrongly.

    ``component`` and ``port`` say where, ``problem`` what is wrong, ``remedy`` what would be right.
    """

    component: str
    port: str
    problem: str
    remedy: str = ""

    def __str__(self) -> str:
        where = f"{self.component}.{self.port}" if self.port else self.component
        return f"{where}: {self.problem}" + (f"; {self.remedy}" if self.remedy else "")


@dataclass
class UnknownBlockError(Exception):
    """No block has this name; ``known`` are the names there are."""

    name: str
    known: tuple[str, ...]

    def __str__(self) -> str:
        return f"no block is named {self.name!r}; {nearest(self.name, self.known)}"
