"""``sightline list``, ``info`` and ``build``: the blocks and their FMUs."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from rich.console import Console
from rich.table import Table

from ..exit_codes import DONE, FAILED, MISUSED

if TYPE_CHECKING:
    from ...components.component import Component

NUMBER = re.compile(r"[0-9]{1,9}")


def list_blocks() -> None:
    """Print the blocks by family, one line each."""
    from ...components import catalogue

    console = Console(highlight=False, soft_wrap=True)
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
        Console(stderr=True, highlight=False, soft_wrap=True).print(str(error), markup=False)
        return MISUSED
    console = Console(highlight=False)
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

    console = Console(highlight=False, soft_wrap=True)
    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    sizes = _sizes(structure)
    wrong = [t for t in (target,) if t not in (None, "python", "native")]
    if sizes is None or wrong:
        usage = "--structure takes name=number"
        what = f"--target {wrong[0]}: choose python or native" if wrong else usage
        errors.print(what, markup=False)
        return MISUSED
    asked: dict[str, Any] = {"target": target, "fmi": fmi, "structure": sizes}
    if platforms:
        asked["platforms"] = [p.strip() for p in platforms.split(",")]
    code = DONE
    for name in names:
        try:
            path = build_fmu(name, out=out, **asked)
        except BuildError as error:
            errors.print(str(error), markup=False)
            code = FAILED
        else:
            console.print(f"{path} ({path.stat().st_size / 1000:.0f} kB)", markup=False)
    return code


def _sizes(structure: Sequence[str]) -> dict[str, int] | None:
    pairs = [text.partition("=") for text in structure]
    if not all(equals and NUMBER.fullmatch(value.strip()) for _, equals, value in pairs):
        return None
    return {name.strip(): int(value) for name, _, value in pairs}


def _structure(console: Console, block: Component) -> None:
    if not block.structures:
        return
    table = _table("structure", "default", "least", "what")
    for name, structure in block.structures.items():
        table.add_row(name, str(structure.default), str(structure.min), structure.doc)
    console.print()
    console.print(table)


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
    if started:
        columns["start"] = [_value(q.value) for q in quantities]
    columns["what"] = [q.doc for q in quantities]
    table = _table(*columns)
    for row in zip(*columns.values(), strict=True):
        table.add_row(*row)
    console.print()
    console.print(table)


def _table(*heads: str) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for number, head in enumerate(heads):
        table.add_column(head, no_wrap=number == 0)
    return table


def _value(value: Any) -> str:
    if value.size == 1:
        return f"{value.flat[0]:g}"
    if value.size and np.all(value == value.flat[0]):
        return f"all {value.flat[0]:g}"
    return np.array2string(value, separator=" ", precision=6, threshold=12)
