"""The orchestrator: wires and co-simulates FMUs, whoever made them.

``System`` goes from a config to results; the errors say what is wrong with either.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .errors import ConfigError, FmuError, Problem, RunError

if TYPE_CHECKING:
    from .system import System

__all__ = ["ConfigError", "FmuError", "Problem", "RunError", "System"]


def __getattr__(name: str) -> Any:
    """Import ``System`` when it is asked for: the command line's help needs no numpy."""
    if name == "System":
        from .system import System

        return System
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
