"""Figures of recorded signals: time histories, and trajectories of one craft as seen by another."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from .config import Plot
from .plan import Array
from .results import Results
from .signals import Signal

SIZE = (8.0, 4.5)  # inches
DPI = 120
COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3c8d", "#333333",
)  # fmt: skip
DASHES = ("-", "--", "-.")  # so that lines on top of each other are seen


def draw(
    folder: Path, plots: Sequence[Plot], drawn: Sequence[Sequence[Signal]], results: Results
) -> list[Path]:
    """Draw every plot to a PNG named after its title. Raises OSError if it cannot be written."""
    paths = []
    for plot, signals in zip(plots, drawn, strict=True):
        path = folder / (plot.file or f"{slug(plot.title)}.png")
        figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        if plot.kind == "trajectory":
            _trajectory(figure, plot, signals, results)
        else:
            _histories(figure, plot, signals, results)
        FigureCanvasAgg(figure).print_figure(path, metadata={"Software": None})
        paths.append(path)
    return paths


def slug(title: str) -> str:
    """A file name from a title."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "plot"


def _histories(figure: Figure, plot: Plot, signals: Sequence[Signal], results: Results) -> None:
    """One pair of axes per unit, one below the other."""
    units = list(dict.fromkeys(_unit(s, results) for s in signals))
    if len(units) > 1:
        figure.set_size_inches(SIZE[0], 1.0 + 2.6 * len(units))
    rows = figure.subplots(len(units), 1, sharex=True, squeeze=False)[:, 0]
    for axes, unit in zip(rows, units, strict=True):
        lines = _lines([s for s in signals if _unit(s, results) == unit], results)
        for number, (label, values) in enumerate(lines):
            dash, colour = DASHES[number % len(DASHES)], COLOURS[number % len(COLOURS)]
            axes.plot(results.time, values, dash, color=colour, linewidth=1.4, label=label)
        axes.set_ylabel(_axis(plot.y or _shared(signals, unit, results), unit))
        axes.set_xmargin(0.0)
        axes.grid(True, color="#dddddd", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        if len(lines) > 1:
            axes.legend(
                frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5)
            )
    rows[0].set_title(plot.title)
    rows[-1].set_xlabel("time (s)")


def _trajectory(figure: Figure, plot: Plot, signals: Sequence[Signal], results: Results) -> None:
    path = results[signals[0].name] - results[signals[1].name]
    unit = _unit(signals[0], results)
    dimensions = path.shape[1]
    figure.set_size_inches(6.5, 6.0)
    axes: Any = figure.add_subplot(projection="3d" if dimensions == 3 else None)
    axes.plot(*path.T, color=COLOURS[0], linewidth=1.4)
    axes.plot(*path[:1].T, "o", color=COLOURS[2], label="start")
    axes.plot(*path[-1:].T, "s", color=COLOURS[1], label="end")
    axes.plot(*np.zeros((dimensions, 1)), "k+", markersize=9, label=signals[1].instance)
    points = np.vstack([path, np.zeros(dimensions)])
    low, high = points.min(axis=0), points.max(axis=0)
    half = 0.55 * (float((high - low).max()) or 1.0)
    for letter, middle in zip("xyz", (low + high) / 2, strict=False):
        axes.set(**{
            f"{letter}label": _axis(letter, unit), f"{letter}lim": (middle - half, middle + half)
        })  # fmt: skip
    axes.set_aspect("equal")
    axes.grid(True, color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False, fontsize="small")
    axes.set_title(plot.title)


def _lines(signals: Sequence[Signal], results: Results) -> list[tuple[str, Array]]:
    lines = []
    for signal in signals:
        whole = results[f"{signal.instance}.{signal.port.name}"]
        flat = whole.reshape(len(whole), -1)
        lines += [
            (f"{signal.instance}.{signal.port.label(e)}", flat[:, e]) for e in signal.elements
        ]
    return lines


def _unit(signal: Signal, results: Results) -> str:
    unit = results.series[f"{signal.instance}.{signal.port.name}"].unit
    return "" if unit == "1" else unit


def _shared(signals: Sequence[Signal], unit: str, results: Results) -> str:
    """The name of the port if all lines show one port."""
    names = {s.port.name for s in signals if _unit(s, results) == unit}
    return names.pop().replace("_", " ") if len(names) == 1 else ""


def _axis(name: str, unit: str) -> str:
    return f"{name} ({unit})" if name and unit else name or unit
