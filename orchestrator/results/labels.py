"""What figures say: titles, the axes' names with unit and frame, components, the unit of time."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from ...fmus.units import QUANTITIES
from .curves import Curve, plain

LETTERS_PER_INCH = 9.5  # of a title
TITLE_LINES = 3
NAMES = 3  # of ports that an axis can be named after
TIMES = (("d", 86400.0, 5 * 86400.0), ("h", 3600.0, 1e4), ("s", 1.0, 0.0))  # from a span on, s


def set_title(figure: Figure, *texts: str) -> None:
    """Head a figure by texts, each wrapped to its width; what is too long is cut."""
    width = int(figure.get_size_inches()[0] * LETTERS_PER_INCH)
    lines = [textwrap.fill(t, width, max_lines=TITLE_LINES, placeholder=" …") for t in texts]
    figure.suptitle(plain("\n".join(lines)))


def time_unit(span: float) -> tuple[str, float]:
    """The unit that a time axis is read in, and its seconds."""
    return next((name, seconds) for name, seconds, least in TIMES if span >= least)


def value_label(lines: Sequence[Curve], name: str = "", magnitude: bool = False) -> str:
    """The name of an axis: what the lines show, in which frame and unit. ``name``: if given."""
    name = name or _quantity(lines)
    shown = f"|{name}|" if magnitude and name else name
    return with_unit(f"{shown}{_frame(lines, name)}", lines[0].unit if lines else "")


def with_unit(name: str, unit: str) -> str:
    """The label of an axis."""
    return plain(f"{name} ({unit})" if name and unit else name or unit)


def _quantity(lines: Sequence[Curve]) -> str:
    """What ports share: their name or its last words; else their names, or the unit's quantity."""
    names = list(dict.fromkeys(c.port.partition(".")[2] or c.port for c in lines))
    words = [re.split(r"[_ ]", name)[::-1] for name in names]
    common = []
    for last in zip(*words, strict=False):
        if len(set(last)) > 1:
            break
        common.append(last[0])
    if common:
        return " ".join(common[::-1])
    if len(names) <= NAMES:
        return ", ".join(names).replace("_", " ")
    quantity = QUANTITIES.get(lines[0].unit, "value")
    return re.sub(r"(?<!^)([A-Z])", r" \1", quantity).lower()


def _frame(lines: Sequence[Curve], name: str) -> str:
    """The frames that components are in, unless the name tells."""
    frames = list(dict.fromkeys(c.frame for c in lines))
    if not all(frames) or set(frames) & set(name.split()):
        return ""
    if len(frames) > 2:
        return ", each in its own frame"
    return f" in {' and '.join(frames)}" if frames else ""


def spans_decades(lines: Sequence[Curve]) -> bool:
    """Whether a logarithmic axis can be read: the magnitudes differ by ten or more."""
    values = np.abs(np.concatenate([c.values for c in lines]))
    values = values[(values > 0) & np.isfinite(values)]
    return bool(values.size and values.max() >= 10.0 * values.min())
