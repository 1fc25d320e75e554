"""The compiled system: where every value lives in one array, and which values go where.

Every FMU has one contiguous segment for the inputs that are driven and one for its outputs, each
ordered real, integer, boolean. A stepper needs nothing else of the system; it holds no names.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .description import Port
from .graph import SystemGraph
from .schedule import Schedule
from .signals import Signal

Indices = NDArray[np.intp]
Array = NDArray[np.float64]
KINDS = ("real", "integer", "boolean")


@dataclass(frozen=True)
class Block:
    """Values of one type: their value references and where they start in the array."""

    references: tuple[int, ...]
    first: int

    @property
    def last(self) -> int:
        """One past the last position."""
        return self.first + len(self.references)


@dataclass(frozen=True)
class Segment:
    """The inputs or outputs of an FMU, by type in the order of ``KINDS``."""

    blocks: tuple[Block, Block, Block]

    @property
    def first(self) -> int:
        """The first position."""
        return self.blocks[0].first

    @property
    def last(self) -> int:
        """One past the last position."""
        return self.blocks[-1].last


@dataclass(frozen=True)
class Unit:
    """What is done with one FMU: input[k] = gain[k] · value[sources[k]] + shift[k], then a step.

    ``gain`` and ``shift`` are None where all values pass unchanged.
    """

    node: int
    inputs: Segment
    outputs: Segment
    sources: Indices
    gain: Array | None
    shift: Array | None


@dataclass(frozen=True)
class Plan:
    """Units in the order of stepping; ``recorded`` are the positions of one row of results."""

    size: int
    units: tuple[Unit, ...]
    recorded: Indices
    jacobi: bool


def compile_plan(graph: SystemGraph, order: Schedule, recorded: Iterable[Signal]) -> Plan:
    """Lay out a scheduled system."""
    layout = _Layout()
    segments = {}
    drives = _sources(graph)
    for number in order.order:
        node = graph.nodes[number]
        driven = {
            (p.name, e)
            for p in node.fmu.inputs.values()
            for e in range(p.size)
            if (node.name, p.name, e) in drives
        }
        inputs = layout.segment(node.name, node.fmu.inputs.values(), driven)
        outputs = layout.segment(node.name, node.fmu.outputs.values(), None)
        segments[number] = inputs, outputs
    feeds = {layout.positions[into]: feed for into, feed in drives.items()}
    units = [_unit(n, *segments[n], layout, feeds) for n in order.order]
    columns = [
        layout.positions[(s.instance, s.port.name, e)] for s in recorded for e in s.elements
    ]
    return Plan(layout.size, tuple(units), np.array(columns, dtype=np.intp), order.jacobi)


Key = tuple[str, str, int]


class _Layout:
    """Hands out positions."""

    def __init__(self) -> None:
        self.size = 0
        self.positions: dict[Key, int] = {}

    def segment(
        self, instance: str, ports: Iterable[Port], only: set[tuple[str, int]] | None
    ) -> Segment:
        blocks = []
        ports = list(ports)
        for kind in KINDS:
            first, references = self.size, []
            for port in ports:
                if ("integer" if port.kind == "enumeration" else port.kind) != kind:
                    continue
                for element, reference in enumerate(port.references):
                    if only is None or (port.name, element) in only:
                        self.positions[(instance, port.name, element)] = self.size
                        references.append(reference)
                        self.size += 1
            blocks.append(Block(tuple(references), first))
        return Segment((blocks[0], blocks[1], blocks[2]))


def _sources(graph: SystemGraph) -> dict[Key, tuple[Key, float, float]]:
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


def _unit(
    number: int,
    inputs: Segment,
    outputs: Segment,
    layout: _Layout,
    feeds: dict[int, tuple[Key, float, float]],
) -> Unit:
    mine = [feeds[p] for p in range(inputs.first, inputs.last)]
    sources = np.array([layout.positions[source] for source, _, _ in mine], dtype=np.intp)
    gain = np.array([g for _, g, _ in mine], dtype=float)
    shift = np.array([s for _, _, s in mine], dtype=float)
    plain = bool(np.all(gain == 1.0) and np.all(shift == 0.0))
    return Unit(
        number, inputs, outputs, sources, None if plain else gain, None if plain else shift
    )
