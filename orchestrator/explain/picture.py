"""The picture of a system: instances in the order of stepping, lines for values of one instant."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch, PathPatch
from matplotlib.path import Path as Curve

from ..results.plots import METADATA
from ..results.styles import COLOURS
from ..system import System
from ..wiring.undriven import undriven
from .explanation import Timing, rate
from .groups import Group, Link, groups_of, links_of
from .layout import HEAD, ROW, Box, Layout, Line, Port

POINTS = 72.0  # per inch
MARGIN = 24.0
LEGEND = 60.0
TURN = 28.0  # how far lines that go on in another band reach out, less a quarter
MARK: Mapping[Timing, str] = {"late": " ⇠ late ", "held": " ⇠ ", "same": " ↺ ", "ahead": " ↺ "}
MOST = 48  # boxes; of more, the first are drawn
GREY, LATE, HELD = "#8a8a8a", "#c0392b", "#6c4a9e"
FILLS = ("#eaf2fb", "#fdf0e6", "#e8f6f0", "#f8eef5", "#fdf8e4", "#eef0f2", "#f0ecf7", "#e9f5fa")
PNG = 130  # dots per inch


def draw(system: System, path: Path) -> None:
    """Write the picture. Raises OSError, or ValueError for an unknown kind of file."""
    groups = groups_of(system)
    shown = groups[:MOST]
    boxes, edges = _content(system, groups, shown)
    layout = Layout(boxes, edges)
    figure = _figure(layout, shown)
    notes = [f"the first {len(shown)} of {len(groups)} instances"] if len(groups) > MOST else []
    _legend(figure.axes[0], layout, notes)
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": "sightline"}):
        figure.savefig(path, metadata=METADATA.get(path.suffix), dpi=PNG)


def _content(
    system: System, groups: Sequence[Group], shown: Sequence[Group]
) -> tuple[list[Box], list[tuple[Port, Port]]]:
    """Boxes with a row per connected or idle input; edges for values of the same instant."""
    names = {g.name for g in shown}
    inputs: dict[str, list[tuple[str, str]]] = {name: [] for name in names}
    outputs: dict[str, dict[str, str]] = {name: {} for name in names}
    edges: list[tuple[Port, Port]] = []
    for link in links_of(system, groups):
        drawn = link.forward and link.source in names and link.destination in names
        if link.destination in names:
            inputs[link.destination].append((link.key, _input(link, drawn)))
        if drawn:
            outputs[link.source].setdefault(link.out, link.out)
            edges.append(((link.source, link.out), (link.destination, link.key)))
        elif link.source in names:
            outputs[link.source][link.out] = f"{link.out} ⇢"
    idle: dict[str, list[str]] = {}
    for one in undriven(system.graph):
        idle.setdefault(one.instance, []).extend(one.labels)
    rates = {system.graph.nodes[u.node].name: rate(system, u) for u in system.plan.units}
    boxes = []
    for group in shown:
        node, count = group.nodes[0], len(group.nodes)
        rows = [*inputs[group.name], *((p, f"{p} (start)") for p in idle.get(node.name, ()))]
        words = [node.fmu.model_name, f"{count} copies" if count > 1 else "", rates[node.name]]
        detail = ", ".join(filter(None, words))
        boxes.append(
            Box(group.name, group.heading, detail, rows, list(outputs[group.name].items()))
        )
    return boxes, edges


def _input(link: Link, drawn: bool) -> str:
    """What stands at an input: which value it gets, unless a line tells."""
    if not drawn:
        return f"{link.into}{MARK[link.timing]}{link.shown}"
    instance = link.shown.partition(".")[0]
    return link.into if instance == link.source else f"{link.into} of {instance}"


def _figure(layout: Layout, shown: Sequence[Group]) -> Figure:
    width, height = (s + 2 * MARGIN for s in layout.size())
    figure = Figure(figsize=(width / POINTS, (height + LEGEND) / POINTS), dpi=POINTS)
    axes: Any = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(-MARGIN, width - MARGIN), ylim=(height + LEGEND - MARGIN, -MARGIN))
    axes.axis("off")
    colours = {g.name: COLOURS[i % len(COLOURS)] for i, g in enumerate(shown)}
    models = list(dict.fromkeys(g.nodes[0].fmu.model_name for g in shown))
    fills = {
        g.name: FILLS[models.index(g.nodes[0].fmu.model_name) % len(FILLS)] for g in shown
    }  # fmt: skip
    for line in layout.lines():
        axes.add_patch(PathPatch(
            _curve(line), facecolor="none", edgecolor=colours[line.source[0]], linewidth=1.1,
            alpha=0.85,
        ))  # fmt: skip
        axes.plot(*line.points[-1], marker=5, color=colours[line.source[0]], markersize=5)
    for box in layout.boxes.values():
        _box(axes, box, fills[box.name], colours[box.name])
    return figure


def _curve(line: Line) -> Curve:
    points, codes = [line.points[0]], [Curve.MOVETO]
    turn = TURN
    for number, (a, b) in enumerate(itertools.pairwise(line.points)):
        if number % 2:  # across a column, or back to the left between bands
            points.append(b)
            codes.append(Curve.LINETO)
            continue
        middle = (a[0] + b[0]) / 2
        if a[0] == b[0]:  # round a column's right side to a channel, or from it round the left
            middle, turn = a[0] + turn, -turn
        points += [(middle, a[1]), (middle, b[1]), b]
        codes += [Curve.CURVE4] * 3
    return Curve(points, codes)


def _box(axes: Any, box: Box, fill: str, edge: str) -> None:
    axes.add_patch(FancyBboxPatch(
        (box.x, box.y), box.width, box.height, boxstyle="round,pad=0,rounding_size=4",
        facecolor=fill, edgecolor=edge, linewidth=1.2, zorder=3,
    ))  # fmt: skip
    at = {"zorder": 4, "va": "center"}
    axes.text(box.x + 8, box.y + 11, box.heading, fontsize=10.5, fontweight="bold", **at)
    axes.text(box.x + 8, box.y + 24, box.detail, fontsize=8.5, color="#555555", **at)
    axes.plot([box.x, box.x + box.width], [box.y + HEAD - 2] * 2, color="#cccccc", lw=0.7, zorder=4)
    for name, text in box.inputs:
        colour = (
            GREY if text.endswith("(start)") else LATE if MARK["late"] in text
            else HELD if "⇠" in text else "#222222"
        )  # fmt: skip
        axes.text(box.x + 8, box.input_y(name), text, fontsize=8.5, color=colour, **at)
    for name, text in box.outputs:
        axes.text(box.x + box.width - 6, box.output_y(name), text, fontsize=8.5, ha="right", **at)


def _legend(axes: Any, layout: Layout, notes: list[str]) -> None:
    y = layout.size()[1] + 2 * ROW
    rows = [
        ("line: value of the same instant", "#222222"),
        ("⇠ value of the step's start: acts on states only", HELD),
        ("⇠ late: one step late for outputs that need it at once", LATE),
        ("↺ the same instant: solved, passed on after stepping, or within the box", "#222222"),
        ("(start): nothing drives it", GREY),
        *((note, "#222222") for note in notes),
    ]
    x = 0.0
    for text, colour in rows:
        if x and x + len(text) * 5.0 > layout.size()[0]:
            x, y = 0.0, y + ROW
        axes.text(x, y, text, fontsize=8.5, color=colour, va="center")
        x += len(text) * 5.0 + 18
