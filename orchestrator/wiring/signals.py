"""Chooses signals of a system by globs: what is recorded, what is drawn."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..config.loading import Loaded
from ..errors import Problem, nearest
from ..fmi.description import Port
from .graph import SystemGraph

COMPARED: Mapping[str, tuple[tuple[int, ...], ...]] = {  # shapes that kinds of plots compare
    "trajectory": ((2,), (3,)),
    "angle": ((4,),),
}


@dataclass(frozen=True)
class Signal:
    """Elements of an output: ``name`` is ``instance.port`` or ``instance.port[i]``."""

    name: str
    instance: str
    port: Port
    elements: tuple[int, ...]

    @property
    def dataset(self) -> str:
        """Where the results hold the whole port, quoted as in a URL: slashes make groups."""
        name = "%2E" if self.port.name == "." else self.port.name.replace("%", "%25")
        return f"{self.instance}/{name.replace('/', '%2F')}"


def match(pattern: str, graph: SystemGraph) -> list[Signal]:
    """The outputs that a glob names; elements only where it names elements."""
    whole = compile_glob(pattern)
    found = [
        Signal(name, node.name, port, tuple(range(port.size)))
        for name, (node, port) in graph.signals.items()
        if whole.fullmatch(name)
    ]
    if found or "[" not in pattern:
        return found
    return [
        Signal(f"{node.name}.{label}", node.name, port, (element,))
        for node, port in graph.signals.values()
        for element, label in enumerate(port.labels())
        if whole.fullmatch(f"{node.name}.{label}")
    ]


def compile_glob(pattern: str) -> re.Pattern[str]:
    """A glob in which only ``*`` and ``?`` are special: brackets are indices of elements."""
    parts = (".*" if c == "*" else "." if c == "?" else re.escape(c) for c in pattern)
    return re.compile("".join(parts))


@dataclass(frozen=True)
class Selection:
    """The whole ports to record, and the signals of each plot, which are recorded too."""

    recorded: tuple[Signal, ...]
    drawn: tuple[tuple[Signal, ...], ...]


def select(loaded: Loaded, graph: SystemGraph) -> tuple[Selection, list[Problem]]:
    """The signals that a config names, and a problem for every glob that names no output."""
    problems: list[Problem] = []
    config = loaded.config

    def chosen(patterns: Sequence[str], path: tuple[str | int, ...]) -> list[Signal]:
        found: dict[str, Signal] = {}
        for pattern in patterns:
            matches = match(pattern, graph)
            if not matches:
                problems.append(loaded.place(_nothing(pattern, path, graph), path))
            found.update({s.name: s for s in matches})
        return list(found.values())

    recorded = chosen(config.record.signals, ("record", "signals"))
    drawn = [chosen(p.signals, ("plots", i, "signals")) for i, p in enumerate(config.plots)]
    for number, plot in enumerate(config.plots):
        shapes = COMPARED.get(plot.kind)
        if shapes is not None and not problems:
            problems += _compared_problems(loaded, number, drawn[number], shapes)
    ports = _whole_ports([*recorded, *(s for plot in drawn for s in plot)], graph.signals)
    return Selection(tuple(ports), tuple(map(tuple, drawn))), problems


def _whole_ports(chosen: Iterable[Signal], all_signals: Mapping[str, object]) -> list[Signal]:
    """Each port once, in the system's order."""
    ports = {f"{s.instance}.{s.port.name}": s for s in chosen}
    return [
        Signal(name, ports[name].instance, ports[name].port, tuple(range(ports[name].port.size)))
        for name in all_signals
        if name in ports
    ]


def _nothing(pattern: str, path: tuple[str | int, ...], graph: SystemGraph) -> Problem:
    where = ".".join(str(p) for p in path)
    instance, _, port = pattern.partition(".")
    what = f'"{pattern}" names no output'
    index = graph.index
    if instance in index and port.partition("[")[0] in graph.nodes[index[instance]].fmu.inputs:
        drivers = [
            str(c.source)
            for c in graph.connections
            if c.destination.instance == instance
            and c.destination.port.name == port.partition("[")[0]
        ]
        return Problem(where, f"{what} but an input", f"name its source {', '.join(drivers)}")
    return Problem(where, what, nearest(pattern, graph.signals, "outputs"))


def _compared_problems(
    loaded: Loaded, number: int, drawn: list[Signal], shapes: tuple[tuple[int, ...], ...]
) -> list[Problem]:
    path = ("plots", number, "signals")
    found = {s.port.shape for s in drawn}
    if len(drawn) > 1 and len(found) == 1 and found <= set(shapes):
        return []
    kind = loaded.config.plots[number].kind
    sizes = " or ".join(str(shape[0]) for shape in shapes)
    what = f"{kind} needs two or more signals of {sizes} elements, found "
    what += ", ".join(f"{s.name} {list(s.port.shape)}" for s in drawn)
    return [loaded.place(Problem(f"plots.{number}.signals", what), path)]
