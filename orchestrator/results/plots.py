"""Figures of results: time histories, angles between attitudes, trajectories, activity."""

from __future__ import annotations

import textwrap
import warnings
from collections.abc import Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..config.model import Plot
from ..schedule.plan import Array
from .curves import Curve, chosen, curves, plain
from .file import Results
from .labels import set_title, spans_decades, time_unit, value_label
from .styles import styles
from .trajectory import draw_trajectory

SIZE = (8.0, 4.5)  # inches
DPI = 120
NAMED = 24  # lines that a legend can name
LABEL_LETTERS = 26  # of the name of an axis beside one of several pairs of axes, in a line
GRID = {"color": "#dddddd", "linewidth": 0.6}
METADATA = {".png": {"Software": None}, ".svg": {"Date": None, "Creator": None}}
COMPARABLE = {"trajectory": "of 2 or 3 elements", "angle": "that are quaternions of 4 elements"}


def draw(
    folder: Path, plots: Sequence[Plot], results: Results, suffix: str = ".png"
) -> list[Path]:
    """Draw every plot to a file named after its title. Raises OSError if it cannot be written."""
    paths = []
    for plot in plots:
        path = folder / plot.file_name(suffix)
        save(figure_of(plot, results), path)
        paths.append(path)
    return paths


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the same figure gives the same bytes. Raises OSError, ValueError."""
    with matplotlib.rc_context({"svg.hashsalt": "sightline"}), warnings.catch_warnings():
        for text in ("Glyph", "constrained_layout"):  # a title of strange signs, or too long
            warnings.filterwarnings("ignore", text, UserWarning)
        figure.savefig(path, metadata=METADATA.get(path.suffix))


def figure_of(plot: Plot, results: Results) -> Figure:
    """A plot as a figure. Raises ValueError if its signals do not suit its kind."""
    figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
    names = chosen(plot.signals, results)
    if plot.until is not None:
        results = results.until(plot.until)
    if plot.kind == "trajectory":
        draw_trajectory(figure, plot.title, _compared(plot, names, results), results)
    elif plot.kind == "angle":
        _histories(figure, plot, _angles(_compared(plot, names, results), results), results.time)
    elif plot.kind == "activity":
        _activity(figure, plot, curves(names, results), results.time)
    else:
        _histories(figure, plot, curves(names, results), results.time)
    return figure


def _histories(figure: Figure, plot: Plot, lines: Sequence[Curve], time: Array) -> None:
    """One pair of axes per unit, one below the other."""
    units = list(dict.fromkeys(c.unit for c in lines))
    if len(units) > 1:
        figure.set_size_inches(SIZE[0], 1.0 + 2.6 * len(units))
    rows = figure.subplots(len(units), 1, sharex=True, squeeze=False)[:, 0]
    letters = LABEL_LETTERS if len(units) > 1 else 2 * LABEL_LETTERS
    name, seconds = time_unit(float(time[-1] - time[0]))
    for axes, unit in zip(rows, units, strict=True):
        mine = [c for c in lines if c.unit == unit]
        logarithmic = plot.scale == "log" and spans_decades(mine)
        signed = logarithmic and any(np.any(c.values < 0) for c in mine)
        _lines(axes, mine, time / seconds, absolute=signed)
        label = value_label(mine, plot.y, magnitude=signed)
        axes.set_ylabel(textwrap.fill(label, letters, break_long_words=False))
        axes.set_yscale("log" if logarithmic else "linear")
        if not logarithmic:
            axes.ticklabel_format(axis="y", useOffset=False)
            if plot.kind == "angle":
                axes.set_ylim(0.0, 1.05 * max(float(np.max(c.values)) for c in mine) or 1.0)
        axes.set_xmargin(0.0)
        axes.grid(True, **GRID)
        axes.spines[["top", "right"]].set_visible(False)
    set_title(figure, plot.title)
    rows[-1].set_xlabel(f"time ({name})")


def _lines(axes: Axes, lines: Sequence[Curve], time: Array, absolute: bool) -> None:
    named = len(lines) <= NAMED
    shades = matplotlib.colormaps["viridis"](np.linspace(0.0, 0.95, len(lines)))
    looks = styles(lines) if named else [{"color": c, "linewidth": 0.6} for c in shades]
    for curve, look in zip(lines, looks, strict=True):
        values = np.abs(curve.values) if absolute else curve.values
        axes.plot(time, values, label=plain(curve.label), **look)
    if len(lines) > 1 and named:
        axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    elif len(lines) > 1:
        first, last = plain(lines[0].label), plain(lines[-1].label)
        span = f"{len(lines)} lines,\n{first}\n(dark) to\n{last}\n(light)"
        axes.text(1.01, 0.5, span, transform=axes.transAxes, va="center", fontsize="small")


def _angles(names: Sequence[str], results: Results) -> list[Curve]:
    """The angle of the rotation from each attitude to the last one, in degrees."""
    reference = results[names[-1]]
    found = []
    for name in names[:-1]:
        found.append(Curve("angle", f"{name} to {names[-1]}", "deg",
                           np.degrees(rotation_angle(results[name], reference))))
    return found


def rotation_angle(one: Array, other: Array) -> Array:
    """The angle between attitudes as rows of quaternions; exact for small angles too."""
    vector = (
        one[:, 3:] * other[:, :3] - other[:, 3:] * one[:, :3] - np.cross(one[:, :3], other[:, :3])
    )  # of the product conj(one) * other
    sine, cosine = np.linalg.norm(vector, axis=1), np.abs(np.sum(one * other, axis=1))
    angle: Array = 2.0 * np.arctan2(sine, cosine)
    return angle


def _activity(figure: Figure, plot: Plot, rows: Sequence[Curve], time: Array) -> None:
    """A row of colour per element, one pair of axes per port; at the right what it adds up to."""
    ports = list(dict.fromkeys(c.port for c in rows))
    counts = [sum(c.port == p for c in rows) for p in ports]
    figure.set_size_inches(SIZE[0], 1.3 + 0.24 * sum(counts) + 0.5 * len(ports))
    all_axes = figure.subplots(
        len(ports), 1, sharex=True, squeeze=False, height_ratios=counts
    )[:, 0]
    largest = max((float(np.max(np.abs(c.values))) for c in rows), default=0.0) or 1.0
    signed = any(np.any(c.values < 0) for c in rows)
    name, seconds = time_unit(float(time[-1] - time[0]))
    edges = np.append(time, time[-1] + (time[-1] - time[-2] if len(time) > 1 else 1.0))
    for axes, port, count in zip(all_axes, ports, counts, strict=True):
        mine = [c for c in rows if c.port == port]
        image = axes.pcolormesh(
            edges / seconds, np.arange(count + 1) + 0.5, np.array([c.values for c in mine]),
            cmap="RdBu_r" if signed else "Blues", vmin=-largest if signed else 0.0, vmax=largest,
            rasterized=True,
        )  # fmt: skip
        axes.set(ylim=(count + 0.5, 0.5), ylabel=plain(port), yticks=range(1, count + 1))
        axes.tick_params(labelsize="small")
        sums = axes.twinx()
        sums.set(ylim=(count + 0.5, 0.5), yticks=range(1, count + 1))
        sums.set_yticklabels([f"{_integral(c.values, time):.3g}" for c in mine], fontsize="small")
        sums.tick_params(length=0)
    unit = rows[0].unit if rows else ""
    sums_up = "right: ∫|value| dt" + (f" ({unit} s)" if unit else "")
    set_title(figure, plot.title, sums_up)
    all_axes[-1].set_xlabel(f"time ({name})")
    figure.colorbar(image, ax=list(all_axes), label=value_label(rows, plot.y), pad=0.09)


def _integral(values: Array, time: Array) -> float:
    return float(np.sum(np.abs(values[:-1]) * np.diff(time)))


def _compared(plot: Plot, names: Sequence[str], results: Results) -> list[str]:
    shapes = {results.series[n].values.shape[1:] if n in results.series else () for n in names}
    suits = {(2,), (3,)} if plot.kind == "trajectory" else {(4,)}
    if len(names) < 2 or len(shapes) != 1 or not shapes <= suits:
        what = f"{plot.kind} needs two or more signals {COMPARABLE[plot.kind]}, the last one the "
        raise ValueError(f"{what}reference; found {', '.join(names) or 'none'}")
    return list(names)
