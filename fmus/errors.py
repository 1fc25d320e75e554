"""Errors of building FMUs."""

from __future__ import annotations

from collections.abc import Sequence


class BuildError(Exception):
    """An FMU cannot be built: ``component`` says of what, ``problems`` lists every reason."""

    def __init__(self, component: str, problems: Sequence[str]) -> None:
        super().__init__(component, tuple(problems))
        self.component = component
        self.problems = tuple(problems)

    def __str__(self) -> str:
        if len(self.problems) == 1:
            return f"cannot build {self.component}: {self.problems[0]}"
        return f"cannot build {self.component}:" + "".join(f"\n  - {p}" for p in self.problems)
