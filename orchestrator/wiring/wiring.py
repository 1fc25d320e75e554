"""Wires a system: config and FMU descriptions in, a checked graph out, all problems together."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from ..config.loading import Loaded
from ..config.model import CONNECTION
from ..errors import Problem, nearest
from ..fmi.description import FmuDescription, Port
from ..fmi.units import Conversion, Unit, conversion
from .graph import TIME_LIMIT, Connection, End, Frames, Node, SystemGraph
from .notes import notes, warnings
from .values import settings

ELEMENT = re.compile(r"^(?P<port>.+)\[(?P<index>[^\[\]]*)\]$")
WIDENING = {("real", "integer"), ("integer", "enumeration"), ("enumeration", "integer")}


def wire(
    loaded: Loaded, fmus: Mapping[str, FmuDescription]
) -> tuple[SystemGraph, list[Problem]]:
    """The system's graph of all that is right, and every problem.

    ``fmus`` may lack instances whose FMU could not be had.
    """
    wiring = Wiring(loaded, fmus)
    return wiring.graph(), wiring.problems


class Wiring:
    """Collects problems while it wires."""

    def __init__(self, loaded: Loaded, fmus: Mapping[str, FmuDescription]) -> None:
        self.loaded = loaded
        self.fmus = fmus
        self.problems: list[Problem] = []
        self.driven: dict[tuple[str, str], tuple[int, str]] = {}
        self.nodes = {n: self._node(n, fmu) for n, fmu in fmus.items()}

    def graph(self) -> SystemGraph:
        """The graph of what is right."""
        found = [self._connection(i, c) for i, c in enumerate(self.loaded.config.connections)]
        connections = tuple(c for c in found if c is not None)
        graph = SystemGraph(tuple(self.nodes.values()), connections)
        return replace(graph, notes=tuple(notes(graph)), warnings=tuple(warnings(graph)))

    def _report(self, problem: Problem, path: tuple[str, ...]) -> None:
        self.problems.append(self.loaded.place(problem, path))

    def _node(self, name: str, fmu: FmuDescription) -> Node:
        instance = self.loaded.config.instances[name]
        tables = {"parameters": instance.parameters, "start": instance.start}
        values = settings(name, fmu, tables, self._report)
        roles = {p.frame for p in fmu.ports.values() if p.frame} - {"inertial"}
        for role in instance.frames if roles else ():  # a foreign FMU may stand in for a block
            if role not in roles:
                path = ("instances", name, "frames", role)
                what = f"{fmu.model_name} has no frame of this role"
                self._report(Problem(".".join(path), what, nearest(role, roles, "roles")), path)
            elif odd := _other_rows(fmu, role, instance.frames[role]):
                path = ("instances", name, "frames", role)
                what = f"{len(instance.frames[role])} frames, but {odd.name} has {_rows(odd)}"
                remedy = "name one frame for each row, or one for all"
                self._report(Problem(".".join(path), what, remedy), path)
        limit = TIME_LIMIT if instance.time_limit is None else instance.time_limit
        return Node(name, fmu, values, instance.frames, instance.isolate, limit)

    def _connection(self, number: int, text: str) -> Connection | None:
        match = CONNECTION.match(text)
        if match is None:
            self._wrong(text, "is not of the form a.x -> b.y", "elements: a.x[1] -> b.y[2]")
            return None
        source = self._end(text, match["source"], match["output"], "output")
        destination = self._end(text, match["destination"], match["input"], "input")
        if destination is not None:
            self._drive(number, text, destination)
        if source is None or destination is None:
            return None
        fits = self._fits(text, source, destination)
        passes = self._units(text, source, destination)
        self._frames(text, source, destination)
        return Connection(source, destination, passes) if fits and passes is not None else None

    def _wrong(self, text: str, what: str, remedy: str = "") -> None:
        self._report(Problem(f'connection "{text}"', what, remedy), ("connections", text))

    def _end(self, text: str, instance: str, name: str, causality: str) -> End | None:
        known = self.loaded.config.instances
        if instance not in known:
            what = f"there is no instance {instance}"
            self._wrong(text, what, nearest(instance, known, "instances"))
        elif instance in self.fmus:  # else its FMU is a problem of its own
            try:
                return find_end(instance, self.fmus[instance], name, causality)
            except _Refused as refused:
                self._wrong(text, refused.what, refused.remedy)
        return None

    def _fits(self, text: str, source: End, destination: End) -> bool:
        out, into = source.port, destination.port
        one = len(source.elements) == len(destination.elements) == 1
        if source.shape != destination.shape and not one:
            what = f"{source} has {_size(source)}, {destination} needs {_size(destination)}"
            self._wrong(text, what, "connect elements or rows: a.x[1] -> b.y[2]")
            return False
        if out.kind != into.kind and (into.kind, out.kind) not in WIDENING:
            self._wrong(text, f"{source} is {out.kind}, {destination} needs {into.kind}")
            return False
        return True

    def _units(self, text: str, source: End, destination: End) -> Conversion | None:
        out, into = source.port.unit, destination.port.unit
        passes = conversion(out, into)
        if passes is None:
            what = f"{source} is in {_unit(out)}, {destination} needs {_unit(into)}"
            self._wrong(text, what)
        return passes

    def _frames(self, text: str, source: End, destination: End) -> None:
        sender, receiver = self.nodes[source.instance], self.nodes[destination.instance]
        for one, other in zip(source.elements, destination.elements, strict=False):
            out, into = sender.frame(source.port, one), receiver.frame(destination.port, other)
            if out and into and out != into:
                what = (
                    f"{source} is of the frame {out}{_role(source, out)}, "
                    f"{destination} needs {into}{_role(destination, into)}"
                )
                self._wrong(text, what, "connect ports of one frame, or correct frames = {...}")
                return

    def _drive(self, number: int, text: str, destination: End) -> None:
        for element in destination.elements:
            label = destination.port.label(element)
            first, by = self.driven.setdefault((destination.instance, label), (number, text))
            if first != number:
                what = f'{destination.instance}.{label} is already driven by "{by}"'
                self._wrong(text, what, "an input has one source")
                return


def find_end(instance: str, fmu: FmuDescription, name: str, causality: str) -> End:
    """The port, or the elements of it, that a connection names. Raises _Refused."""
    port, element = fmu.ports.get(name), ELEMENT.match(name)
    if port is None and element is not None:
        port = fmu.ports.get(element["port"])
    else:
        element = None
    valid = fmu.of(causality)
    if port is None and name in fmu.others:
        what = f"{instance}.{name} is of the type {fmu.others[name]}"
        raise _Refused(what, "only numbers can be connected")
    if port is None:
        what = f"{instance} ({fmu.model_name}) has no port {name}"
        asked = ELEMENT.sub(r"\g<port>", name)
        raise _Refused(what, nearest(asked, valid, f"its {causality}s"))
    if port.causality != causality:
        what = f"{instance}.{port.name} is {_article(port.causality)}, not {_article(causality)}"
        raise _Refused(what, nearest(port.name, valid, f"its {causality}s"))
    if port.kind == "string":
        raise _Refused(f"{instance}.{port.name} is a string", "only numbers can be connected")
    if element is None:
        return End(instance, port, tuple(range(port.size)), port.shape)
    index = [i.strip() for i in element["index"].split(",")]
    chosen = _chosen(port.shape, index)
    if chosen is None:
        has = f"{port.label(0)} to {port.label(port.size - 1)}" if port.shape else "a scalar"
        asked = f"{instance}.{port.name}[{','.join(index)}]"
        raise _Refused(f"{asked} does not exist", f"{port.name} is {has}")
    axes = [len(a) for a, i in itertools.zip_longest(chosen, index) if i in (":", None)]
    strides = [math.prod(port.shape[k + 1:]) for k in range(len(port.shape))]
    elements = tuple(
        sum(i * stride for i, stride in zip(place, strides, strict=True))
        for place in itertools.product(*chosen)
    )
    return End(instance, port, elements, tuple(axes), ",".join(index))


def _chosen(shape: tuple[int, ...], index: list[str]) -> list[range] | None:
    """What an index takes of each axis: ``2`` one place, ``:`` and what is left out all."""
    if len(index) > len(shape):
        return None
    chosen = []
    for extent, text in zip(shape, [*index, *":" * (len(shape) - len(index))], strict=True):
        number = int(text) if text.isdecimal() else 0
        if text != ":" and not 1 <= number <= extent:
            return None
        chosen.append(range(extent) if text == ":" else range(number - 1, number))
    return chosen


@dataclass
class _Refused(Exception):
    what: str
    remedy: str


def _article(causality: str) -> str:
    return f"{'an' if causality[0] in 'aeiou' else 'a'} {causality}"


def _size(end: End) -> str:
    if len(end.shape) > 1:
        return f"{' x '.join(str(n) for n in end.shape)} elements"
    count = len(end.elements)
    return "1 element" if count == 1 else f"{count} elements"


def _unit(unit: Unit | None) -> str:
    if unit is None or unit.exponents is None or unit.dimension == unit.name:
        return str(unit)
    return f"{unit} ({unit.dimension})"


def _other_rows(fmu: FmuDescription, role: str, frames: Frames) -> Port | None:
    """A port of a role that has not one row for each of its frames; None if all have."""
    if isinstance(frames, str):
        return None
    ports = (p for p in fmu.of("input", "output").values() if p.frame == role)
    return next((p for p in ports if len(p.shape) < 2 or p.shape[0] != len(frames)), None)


def _rows(port: Port) -> str:
    return f"{port.shape[0]} rows" if len(port.shape) > 1 else "no rows"


def _role(end: End, frame: str) -> str:
    return "" if end.port.frame == frame else f" (its {end.port.frame})"
