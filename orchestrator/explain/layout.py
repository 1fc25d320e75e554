"""Places a system's instances in layers by the order of stepping, and routes lines between them.

Instances stand in the column after those whose values of the same step they take; a line that
passes a column gets a place in it, so that no line crosses a box. The order within a column comes
from sweeps of barycentres, the heights from least squares with a least distance. Columns that do
not fit on a page go on below in another band, lines between bands pass in the space between them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

HEAD, ROW, FOOT = 34.0, 15.0, 6.0  # heights in points
GAP_X, GAP_Y, PASS = 90.0, 22.0, 7.0  # between columns, boxes, lines that pass
LETTER = 5.6  # width of a letter
PAGE = 1300.0  # width of a band of columns: letters can be read where it is fitted to a page
SWEEPS = 12

Port = tuple[str, str]  # instance and port


@dataclass
class Box:
    """One instance. Inputs and outputs: name and what to write; ``x``, ``y``: upper left."""

    name: str
    heading: str
    detail: str
    inputs: Sequence[tuple[str, str]]
    outputs: Sequence[tuple[str, str]]
    x: float = 0.0
    y: float = 0.0
    width: float = field(init=False)

    def __post_init__(self) -> None:
        left = max((len(text) for _, text in self.inputs), default=0)
        right = max((len(text) for _, text in self.outputs), default=0)
        rows = (left + right + 4) * LETTER
        self.width = max(rows, (len(self.heading) + 3) * LETTER * 1.2, len(self.detail) * LETTER)

    @property
    def height(self) -> float:
        """Its height."""
        return HEAD + ROW * max(len(self.inputs), len(self.outputs)) + FOOT

    def input_y(self, name: str) -> float:
        """The height of an input's row."""
        return self.y + self._row([n for n, _ in self.inputs].index(name))

    def output_y(self, name: str) -> float:
        """The height of an output's row."""
        return self.y + self._row([n for n, _ in self.outputs].index(name))

    def _row(self, number: int) -> float:
        return HEAD + ROW * (number + 0.5)


@dataclass(frozen=True)
class Line:
    """A connection as points: out of the source, across columns, into the destination."""

    source: Port
    destination: Port
    points: tuple[tuple[float, float], ...]


@dataclass
class _Place:
    """A box or a passing line in a column."""

    box: Box | None
    y: float = 0.0

    @property
    def height(self) -> float:
        return self.box.height if self.box else 0.0


class Layout:
    """Places ``boxes``, given in the order of stepping, and routes ``edges``, which go forward."""

    def __init__(self, boxes: Sequence[Box], edges: Iterable[tuple[Port, Port]]) -> None:
        self.boxes = {b.name: b for b in boxes}
        self.edges = list(edges)
        self.layer = self._layers()
        count = max(self.layer.values(), default=0) + 1
        self.columns: list[list[_Place]] = [[] for _ in range(count)]
        self.places = {b.name: _Place(b) for b in boxes}
        for box in boxes:
            self.columns[self.layer[box.name]].append(self.places[box.name])
        self.passing: dict[tuple[Port, int], _Place] = {}
        self._links: list[tuple[_Place, str, _Place, str]] = []  # between adjacent columns
        for source, destination in self.edges:
            self._link(source, destination)
        self._sort()
        self._heights()
        self._widths()
        self._bands()

    def lines(self) -> list[Line]:
        """The lines of all edges."""
        return [Line(s, d, tuple(self._points(s, d))) for s, d in self.edges]

    def size(self) -> tuple[float, float]:
        """Width and height of everything."""
        return (
            max(b.x + b.width for b in self.boxes.values()),
            max(b.y + b.height for b in self.boxes.values()),
        )

    def _layers(self) -> dict[str, int]:
        layer = dict.fromkeys(self.boxes, 0)
        sources: dict[str, set[str]] = {name: set() for name in self.boxes}
        for (source, _), (destination, _) in self.edges:
            sources[destination].add(source)
        for name in self.boxes:  # in the order of stepping: sources come first
            layer[name] = max((layer[s] + 1 for s in sources[name]), default=0)
        return layer

    def _link(self, source: Port, destination: Port) -> None:
        place, port = self.places[source[0]], source[1]
        for number in range(self.layer[source[0]] + 1, self.layer[destination[0]]):
            known = self.passing.get((source, number))
            if known is None:
                known = self.passing[(source, number)] = _Place(None)
                self.columns[number].append(known)
                self._links.append((place, port, known, ""))
            place, port = known, ""
        self._links.append((place, port, self.places[destination[0]], destination[1]))

    def _sort(self) -> None:
        """Sweeps to and fro: each place to the mean position of its neighbours."""
        before: dict[int, list[_Place]] = {}
        after: dict[int, list[_Place]] = {}
        for one, _, other, _ in self._links:
            after.setdefault(id(one), []).append(other)
            before.setdefault(id(other), []).append(one)
        best, least = [list(c) for c in self.columns], self._crossings()
        for sweep in range(SWEEPS):
            neighbours: Mapping[int, list[_Place]] = before if sweep % 2 == 0 else after
            columns = self.columns if sweep % 2 == 0 else self.columns[::-1]
            for column in columns:
                rank = {
                    id(place): i / max(len(c) - 1, 1)
                    for c in self.columns for i, place in enumerate(c)
                }  # fmt: skip
                goal = {
                    id(p): _mean([rank[id(n)] for n in neighbours.get(id(p), [])], rank[id(p)])
                    for p in column
                }
                column.sort(key=lambda place, goal=goal: goal[id(place)])  # type: ignore[misc]
            if (count := self._crossings()) < least:
                best, least = [list(c) for c in self.columns], count
        self.columns = best

    def _crossings(self) -> int:
        """How many pairs of lines cross between columns."""
        rank = {id(p): (k, i) for k, c in enumerate(self.columns) for i, p in enumerate(c)}
        links: dict[int, list[tuple[int, int]]] = {}
        for one, _, other, _ in self._links:
            column, row = rank[id(one)]
            links.setdefault(column, []).append((row, rank[id(other)][1]))
        return sum(
            (a[0] - b[0]) * (a[1] - b[1]) < 0
            for pairs in links.values() for a, b in itertools.combinations(pairs, 2)
        )  # fmt: skip

    def _heights(self) -> None:
        for column in self.columns:
            y = 0.0
            for place in column:
                place.y, y = y, y + place.height + GAP_Y
        for sweep in range(SWEEPS):
            forward = sweep % 2 == 0
            for column in self.columns if forward else self.columns[::-1]:
                wanted = {id(p): [p.y] for p in column}
                for one, out, other, into in self._links:
                    a, b = _at(one, out, True), _at(other, into, False)
                    if forward and id(other) in wanted:
                        wanted[id(other)].append(one.y + a - b)
                    elif not forward and id(one) in wanted:
                        wanted[id(one)].append(other.y + b - a)
                goals = [_mean(w[1:], w[0]) for w in wanted.values()]
                for place, y in zip(column, _apart(goals, _distances(column)), strict=True):
                    place.y = y
    def _widths(self) -> None:
        x = 0.0
        self.left: list[float] = []
        self.right: list[float] = []
        self.first: list[int] = []  # the column that each band begins with
        for number, column in enumerate(self.columns):
            width = max((p.box.width for p in column if p.box), default=0.0)
            if not number or x + width > PAGE:
                self.first.append(number)
                x = 0.0
            for place in column:
                if place.box:
                    place.box.x, place.box.width = x, width
            self.left.append(x)
            self.right.append(x + width)
            x += width + GAP_X

    def _bands(self) -> None:
        """One band below the other, with a channel for each source whose lines go on below."""
        self.channels: dict[tuple[Port, int], float] = {}
        y = 0.0
        for first, end in itertools.pairwise([*self.first, len(self.columns)]):
            places = [p for column in self.columns[first:end] for p in column]
            for source, destination in self.edges:
                goes_on = self.layer[source[0]] < first <= self.layer[destination[0]]
                if goes_on and (source, first) not in self.channels:
                    self.channels[(source, first)] = y
                    y += PASS
            y += GAP_Y if first else 0.0
            top = min(p.y for p in places)
            for place in places:
                place.y += y - top
                if place.box:
                    place.box.y = place.y
            y = max(p.y + p.height for p in places) + GAP_Y

    def _points(self, source: Port, destination: Port) -> Iterable[tuple[float, float]]:
        start, end = self.boxes[source[0]], self.boxes[destination[0]]
        yield start.x + start.width, start.output_y(source[1])
        for number in range(self.layer[source[0]] + 1, self.layer[destination[0]] + 1):
            if number in self.first:
                y = self.channels[(source, number)]
                yield self.right[number - 1], y
                yield self.left[number], y
            if number < self.layer[destination[0]]:
                y = self.passing[(source, number)].y
                yield self.left[number], y
                yield self.right[number], y
        yield end.x, end.input_y(destination[1])


def _at(place: _Place, port: str, out: bool) -> float:
    """The height of a port within its place."""
    if place.box is None:
        return 0.0
    y = place.box.output_y(port) if out else place.box.input_y(port)
    return y - place.box.y


def _distances(column: Sequence[_Place]) -> list[float]:
    """The least distance from each place to the next."""
    return [
        a.height + (PASS if a.box is None and b.box is None else GAP_Y)
        for a, b in itertools.pairwise(column)
    ]


def _apart(goals: Sequence[float], distances: Sequence[float]) -> list[float]:
    """The heights nearest to the goals in least squares that keep order and distances."""
    shift, blocks = 0.0, []  # blocks: sum and count of goals that move together
    offsets = []
    for goal, distance in zip(goals, [0.0, *distances], strict=True):
        shift += distance
        offsets.append(shift)
        blocks.append([goal - shift, 1])
        while len(blocks) > 1 and blocks[-2][0] / blocks[-2][1] > blocks[-1][0] / blocks[-1][1]:
            total, count = blocks.pop()
            blocks[-1][0] += total
            blocks[-1][1] += count
    means = [total / count for total, count in blocks for _ in range(int(count))]
    return [mean + offset for mean, offset in zip(means, offsets, strict=True)]


def _mean(values: Sequence[float], otherwise: float) -> float:
    return sum(values) / len(values) if values else otherwise
