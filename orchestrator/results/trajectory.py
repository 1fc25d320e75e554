"""The figure of trajectories of craft as seen from another one, to scale."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .curves import plain
from .file import Results
from .labels import set_title

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7f3c8d")
GREY = "#999999"


def draw_trajectory(figure: Figure, title: str, names: Sequence[str], results: Results) -> None:
    """Draw positions relative to the last of ``names``, in two or three dimensions."""
    reference = results[names[-1]]
    paths = [results[name] - reference for name in names[:-1]]
    unit, dimensions = plain(results.series[names[-1]].unit), reference.shape[1]
    figure.set_size_inches(6.5, 6.0)
    axes: Any = figure.add_subplot(projection="3d" if dimensions == 3 else None)
    points = np.vstack([*paths, np.zeros((1, dimensions))])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, 0.55 * (float((high - low).max()) or 1.0)
    for number, (name, path) in enumerate(zip(names, paths, strict=False)):
        colour = COLOURS[number % len(COLOURS)]
        if dimensions == 3:
            shadow = np.full(len(path), middle[2] - half)
            axes.plot(path[:, 0], path[:, 1], shadow, color=GREY, linewidth=0.7)
        axes.plot(*path.T, color=colour, linewidth=1.4, label=_instance(name))
        axes.plot(*path[:1].T, "o", color=colour, markersize=5)
        axes.plot(*path[-1:].T, "s", color=colour, markersize=6)
    axes.plot(*np.zeros((dimensions, 1)), "k+", markersize=9, label=_instance(names[-1]))
    axes.plot([], [], "o", color=GREY, label="start")
    axes.plot([], [], "s", color=GREY, label="end")
    if dimensions == 3:
        axes.plot([], [], color=GREY, linewidth=0.7, label="shadow in the x-y plane")
    for letter, centre in zip("xyz", middle, strict=False):
        limits = (centre - half, centre + half)
        axes.set(**{f"{letter}label": f"{letter} ({unit})", f"{letter}lim": limits})
    axes.set_aspect("equal")
    axes.grid(True, color="#dddddd", linewidth=0.6)
    place = {"loc": "upper left", "bbox_to_anchor": (-0.05, 1.0)} if dimensions == 3 else {}
    axes.legend(frameon=False, fontsize="small", **place)
    set_title(figure, title)


def _instance(name: str) -> str:
    return plain(name.partition(".")[0])
