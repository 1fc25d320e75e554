"""``sightline explain``: what a system will do, as text and as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ..errors import ConfigError
from ..exit_codes import DONE, FAILED, MISUSED
from ..explain.explanation import explain
from ..explain.text import text
from ..system import System
from .run import overrides
from .terminal import console


def run(config: Path, settings: Sequence[str], graph: Path | None) -> int:
    """Explain a system; the exit code. ``graph``: the picture's .svg, .png or .pdf file."""
    errors = console(stderr=True)
    try:
        system = System.from_toml(
            config, overrides(settings), lambda t: errors.print(t, markup=False)
        )
    except ConfigError as error:
        errors.print(str(error), markup=False)
        return MISUSED
    out = console()
    out.print(text(explain(system)), markup=False, end="")
    if graph is None:
        return DONE
    from ..explain.picture import draw

    try:
        graph.parent.mkdir(parents=True, exist_ok=True)
        draw(system, graph)
    except ValueError as error:
        errors.print(str(error), markup=False)
        return MISUSED
    except OSError as error:
        errors.print(f"cannot write the picture: {error}", markup=False)
        return FAILED
    out.print(f"\npicture in {graph}", markup=False)
    return DONE
