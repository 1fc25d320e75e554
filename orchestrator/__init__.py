"""The orchestrator: wires and co-simulates FMUs, whoever made them.

``System`` goes from a config to results, ``Builder`` makes the config in code; the errors say what
is wrong with either.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import ConfigError, FmuError, Problem, RunError

if TYPE_CHECKING:
    from .builder import Builder
    from .system import System

__all__ = ["Builder", "ConfigError", "FmuError", "Problem", "RunError", "System"]


def __getattr__(name: str) -> Any:
    """Import what needs numpy when it is asked for: the command line's help does without."""
    if name == "System":
        from .system import System

        return System
    if name == "Builder":
        from .builder import Builder

        return Builder
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
