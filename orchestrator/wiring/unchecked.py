"""Connections whose frames or units cannot be checked, because an end does not say what it has."""

from __future__ import annotations

from dataclasses import dataclass

from .graph import Connection, End, Node, SystemGraph

UNBOUND = "does not bind"


@dataclass(frozen=True)
class Unchecked:
    """A connection, the instances that leave it unchecked, and how."""

    connection: Connection
    reasons: tuple[str, ...]
    silent: tuple[str, ...]  # instances that declare nothing, so that nothing can be bound


def unchecked_frames(graph: SystemGraph) -> list[Unchecked]:
    """Connections of a frame at one end at least that is not known at both."""
    found = []
    for c in graph.connections:
        ends = [(graph.nodes[graph.index[e.instance]], e) for e in (c.source, c.destination)]
        unknown = [end for node, end in ends if not _known(node, end)]
        if unknown and any(end.port.frame for _, end in ends):
            reasons = tuple(
                f"{end.instance} {UNBOUND} {end.port.frame}" if end.port.frame
                else f"{end} declares none"
                for end in unknown
            )
            silent = tuple(end.instance for end in unknown if not end.port.frame)
            found.append(Unchecked(c, reasons, silent))
    return found


def unchecked_units(graph: SystemGraph) -> list[Unchecked]:
    """Connections of real numbers with a unit at one end only."""
    found = []
    for c in graph.connections:
        silent = [e for e in (c.source, c.destination) if e.port.unit is None]
        if len(silent) == 1 and c.source.port.kind == c.destination.port.kind == "real":
            reason = f"{silent[0]} declares none"
            found.append(Unchecked(c, (reason,), (silent[0].instance,)))
    return found


def _known(node: Node, end: End) -> bool:
    return all(node.frame(end.port, element) for element in end.elements)
