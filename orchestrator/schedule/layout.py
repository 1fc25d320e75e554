"""Hands out positions in the array of values."""

from __future__ import annotations

from collections.abc import Mapping

from ..fmi.description import Port
from ..wiring.graph import Node, SystemGraph
from .plan import Block, Segment

Key = tuple[str, str, int]
Drives = Mapping[Key, tuple[Key, float, float]]


class Layout:
    """``positions`` of elements of ports, ``keys`` the other way round."""

    def __init__(self) -> None:
        self.keys: list[Key | None] = []
        self.positions: dict[Key, int] = {}
        self.segments: dict[str, tuple[Segment, Segment]] = {}

    def add(self, node: Node, drives: Drives) -> None:
        """Place a node's inputs and outputs."""

        def driven(port: Port) -> list[int]:
            some = [e for e in range(port.size) if (node.name, port.name, e) in drives]
            whole = len(set(port.references)) < port.size  # an array is set as a whole
            return list(range(port.size)) if some and whole else some

        inputs = [(p, driven(p)) for p in node.fmu.inputs.values()]
        numbers = (p for p in node.fmu.outputs.values() if p.kind != "string")
        outputs = [(p, list(range(p.size))) for p in numbers]
        self.segments[node.name] = self._segment(node, inputs), self._segment(node, outputs)

    def reserve(self, count: int) -> int:
        """The first of some more positions, for values that are no port's."""
        self.keys += [None] * count
        return self.size - count

    @property
    def size(self) -> int:
        """How many positions there are."""
        return len(self.keys)

    def _segment(self, node: Node, elements: list[tuple[Port, list[int]]]) -> Segment:
        first, blocks = self.size, []
        kinds = [(p.type, _changes_by_events(node, p)) for p, _ in elements]
        for kind in dict.fromkeys(sorted(kinds, key=_reals_first)):
            start, references = self.size, []
            for (port, chosen), found in zip(elements, kinds, strict=True):
                for element in chosen if found == kind else ():
                    key = node.name, port.name, element
                    self.positions[key] = self.size
                    self.keys.append(key)
                    references.append(port.references[element])
            if references:
                unique = tuple(dict.fromkeys(references))
                type_, events = kind
                blocks.append(Block(type_, unique, start, self.size, events))
        return Segment(first, self.size, tuple(blocks))


def _changes_by_events(node: Node, port: Port) -> bool:
    discrete = port.causality == "input" and port.variability == "discrete"
    return discrete and node.fmu.event_mode


def _reals_first(kind: tuple[str, bool]) -> tuple[bool, bool, str]:
    type_, events = kind
    return events, type_ not in ("Real", "Float64"), type_


def drives_of(graph: SystemGraph) -> dict[Key, tuple[Key, float, float]]:
    """For each driven input element its source and conversion."""
    return {
        (c.destination.instance, c.destination.port.name, into): (
            (c.source.instance, c.source.port.name, out),
            c.conversion.gain,
            c.conversion.shift,
        )
        for c in graph.connections
        for out, into in zip(c.source.elements, c.destination.elements, strict=True)
    }
