"""``sightline list``, ``info`` and ``build``: the blocks and their FMUs."""

from __future__ import annotations

import inspect
import re
import sys
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exit_codes import DONE, FAILED, MISUSED
from .terminal import console as terminal
from .terminal import unwritable

if TYPE_CHECKING:
    from rich.console import Console

    from ...components.component import Component

NUMBER = re.compile(r"[0-9]{1,9}")
SHORT = 18  # letters of a start value in a table; longer ones are told below their row
LEAST = 24  # letters of a line of the last column
INDENT = "    "
MANY = 12  # elements; of more, the first and last rows are told
SMALL, LARGE = 1e-4, 1e7  # numbers outside of these have an exponent


def list_blocks() -> None:
    """Print the blocks by family, one line each."""
    from ...components import catalogue

    console = terminal()
    families = catalogue.families()
    width = max((len(name) for blocks in families.values() for name in blocks), default=0)
    for family, blocks in families.items():
        if blocks:
            console.print(f"[bold]{family}[/]")
        for name, block in blocks.items():
            console.print(f"  {name:<{width}}  {catalogue.summary(block)}", markup=False)


def info(name: str) -> int:
    """Print everything about a block; the exit code."""
    from ...fmus.errors import BuildError
    from ...fmus.load import load_block

    try:
        block = load_block(name)
    except BuildError as error:
        terminal(stderr=True).print(str(error), markup=False)
        return MISUSED
    console = terminal()
    console.print(block.name, style="bold")
    console.print(inspect.getdoc(type(block)) or "", markup=False, soft_wrap=True)
    _structure(console, block)
    from ...components import DiscreteState, Noise, Parameter, State
    from ...fmus.model import settings_of

    _quantities(console, "inputs", block.inputs_.values())
    _quantities(console, "outputs", block.outputs_.values(), started=False)
    _quantities(console, "parameters", block.of_type(Parameter).values())
    _quantities(console, "states", block.of_type(State, DiscreteState).values())
    _quantities(console, "noise", block.of_type(Noise).values(), started=False)
    _quantities(console, "settings of the FMU", settings_of(block))
    console.print(f"\nsource: {inspect.getsourcefile(type(block))}", markup=False, soft_wrap=True)
    return DONE


def build(
    names: Sequence[str], out: Path, target: str | None, fmi: int, platforms: str | None,
    structure: Sequence[str],
) -> int:  # fmt: skip
    """Build FMUs; the exit code."""
    from ...fmus.build import build as build_fmu
    from ...fmus.errors import BuildError

    console = terminal()
    errors = terminal(stderr=True)
    sizes = _sizes(structure)
    wrong = [t for t in (target,) if t not in (None, "python", "native")]
    if sizes is None or wrong:
        usage = "--structure takes name=number"
        what = f"--target {wrong[0]}: choose python or native" if wrong else usage
        errors.print(what, markup=False)
        return MISUSED

    def note(text: str) -> None:
        errors.print(f"note: {text}", markup=False)

    asked: dict[str, Any] = {"target": target, "fmi": fmi, "structure": sizes, "note": note}
    if platforms:
        asked["platforms"] = [p.strip() for p in platforms.split(",")]
    code = DONE
    for name in names:
        try:
            path = build_fmu(name, out=out, **asked)
        except BuildError as error:
            errors.print(str(error), markup=False)
            code = FAILED
        except OSError as error:
            errors.print(unwritable(out, error), markup=False)
            return FAILED
        else:
            console.print(f"{path} ({path.stat().st_size / 1000:.0f} kB)", markup=False)
    return code


def _sizes(structure: Sequence[str]) -> dict[str, int] | None:
    pairs = [text.partition("=") for text in structure]
    if not all(equals and NUMBER.fullmatch(value.strip()) for _, equals, value in pairs):
        return None
    return {name.strip(): int(value) for name, _, value in pairs}


def _structure(console: Console, block: Component) -> None:
    if block.structures:
        found = block.structures.values()
        _table(console, {
            "structure": list(block.structures),
            "default": [str(s.default) for s in found],
            "least": [str(s.min) for s in found],
            "what": [s.doc for s in found],
        })  # fmt: skip


def _quantities(
    console: Console, title: str, quantities: Iterable[Any], started: bool = True
) -> None:
    quantities = list(quantities)
    if not quantities:
        return
    columns = {
        title: [q.name for q in quantities],
        "shape": [" x ".join(str(n) for n in q.shape) or "scalar" for q in quantities],
        "unit": [q.unit or "" for q in quantities],
    }
    if any(q.frame for q in quantities):
        columns["frame"] = [q.frame or "" for q in quantities]
    starts = [_value(q.value) if started else "" for q in quantities]
    if started:
        columns["start"] = [s if len(s) <= SHORT else "below" for s in starts]
    columns["what"] = [q.doc for q in quantities]
    _table(console, columns, ["" if len(s) <= SHORT else s for s in starts])


def _table(
    console: Console, columns: Mapping[str, Sequence[str]], below: Sequence[str] = ()
) -> None:
    """Print columns, of which the last one wraps; ``below``: what is told below each row."""
    *heads, last = columns
    widths = [max(map(len, (head, *columns[head]))) + 2 for head in heads]
    room = max(console.width - sum(widths), LEAST)

    def line(cells: Sequence[str]) -> str:
        return "".join(f"{cell:<{width}}" for cell, width in zip(cells, widths, strict=True))

    console.print()
    console.print(f"{line(heads)}{last}", style="bold", markup=False, soft_wrap=True)
    for row, (*cells, text) in enumerate(zip(*columns.values(), strict=True)):
        first, *others = textwrap.wrap(text, room) or [""]
        lines = [line(cells) + first, *(" " * sum(widths) + other for other in others)]
        lines += textwrap.indent(below[row], INDENT).splitlines() if below else []
        console.print("\n".join(x.rstrip() for x in lines), markup=False, soft_wrap=True)


def _value(value: Any) -> str:
    """A start value with all of its digits, a line for each row of a matrix."""
    if value.size and np.all(value == value.flat[0]):
        return f"{'' if value.size == 1 else 'all '}{_number(value.flat[0])}"
    return np.array2string(
        value, separator=" ", threshold=MANY, formatter={"all": _number}, max_line_width=sys.maxsize
    )


def _number(value: Any) -> str:
    """The shortest text that gives the same number."""
    if value == 0 or SMALL <= abs(value) < LARGE:
        return np.format_float_positional(value, trim="-")
    return np.format_float_scientific(value, trim="-", exp_digits=1)
