"""How lines look, so that each is told from the others, also from those that it lies on."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.colors import to_hex

from .curves import Curve

COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3c8d", "#333333",
)  # fmt: skip
DARKER = 0.85  # so that yellow is seen on white
DASHES = ("-", "--", "-.", ":")  # so that lines on top of each other are seen
LAYERS: tuple[Mapping[str, Any], ...] = (  # of ports that have the same components
    {"linewidth": 5.0, "alpha": 0.35}, {"linewidth": 1.3}, {"linewidth": 1.6, "linestyle": ":"},
)  # fmt: skip


def styles(lines: Sequence[Curve]) -> list[dict[str, Any]]:
    """The style of each line.

    Of a few ports with the same components: a colour by component, broad to narrow by port.
    """
    counts = Counter(c.port for c in lines)
    ports, (size, *others) = list(counts), sorted(set(counts.values()))
    if 2 <= len(ports) <= len(LAYERS) and size > 1 and not others:
        colours = palette(size)
        return [
            {"color": colours[number % size], **LAYERS[ports.index(curve.port)]}
            for number, curve in enumerate(lines)
        ]
    colours = palette(len(lines))
    return [
        {"color": colour, "linestyle": DASHES[number % len(DASHES)], "linewidth": 1.4}
        for number, colour in enumerate(colours)
    ]


def palette(count: int) -> list[str]:
    """So many colours, each another one."""
    if count <= len(COLOURS):
        return list(COLOURS[:count])
    shades = matplotlib.colormaps["turbo"](np.linspace(0.0, 1.0, count))[:, :3]
    return [to_hex((r, g, b)) for r, g, b in DARKER * shades]
