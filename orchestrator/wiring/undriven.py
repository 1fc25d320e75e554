"""Inputs that nothing drives, and whether that is meant."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from ..fmi.description import Port
from .graph import Node, Setting, SystemGraph

LONG = 9  # elements: start values of as many are told


@dataclass(frozen=True)
class Undriven:
    """An input, or elements of it. ``excuse``: why it is meant, empty if it may be forgotten.

    ``value``: what it stays at, where that is short.
    """

    instance: str
    labels: tuple[str, ...]
    excuse: Literal["", "optional", "start value given"]
    value: str

    def __str__(self) -> str:
        return f"{self.instance}.{', '.join(self.labels)}"


def undriven(graph: SystemGraph) -> Iterator[Undriven]:
    """All of them, in the system's order."""
    driven: dict[tuple[str, str], set[int]] = {}
    for c in graph.connections:
        end = c.destination
        driven.setdefault((end.instance, end.port.name), set()).update(end.elements)
    for node in graph.nodes:
        for port in node.fmu.inputs.values():
            missing = set(range(port.size)) - driven.get((node.name, port.name), set())
            if missing:
                whole = len(missing) == port.size
                labels = [port.name] if whole else [port.label(e) for e in sorted(missing)]
                yield _undriven(node, port, tuple(labels))


def _undriven(node: Node, port: Port, labels: tuple[str, ...]) -> Undriven:
    given = next((s for s in node.settings if s.port.name == port.name), None)
    value = str(given or _start(port)) if labels == (port.name,) and port.size <= LONG else ""
    if port.optional:
        return Undriven(node.name, labels, "optional", value)
    return Undriven(node.name, labels, "start value given" if given else "", value)


def _start(port: Port) -> Setting | str:
    if not port.start:
        return ""
    real = port.kind == "real"
    return Setting(port, tuple(float(s) if real else s for s in port.start))
