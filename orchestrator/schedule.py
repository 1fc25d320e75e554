"""The order in which FMUs step, from the declared dependencies of outputs on inputs.

Gauss-Seidel: an FMU whose outputs depend at once on an input steps after the FMU that drives
this input, so that a chain sensor -> controller -> allocation holds values of one instant. Other
connections carry the value of the same instant if their source happens to step earlier, else that
of the instant before. Jacobi: all FMUs step on the values of the instant before.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from .errors import ConfigError, Problem
from .graph import Connection, SystemGraph

Edges = Mapping[int, frozenset[int]]


@dataclass(frozen=True)
class Schedule:
    """``order``: positions of the graph's nodes; ``delayed``: connections one step late."""

    order: tuple[int, ...]
    delayed: tuple[Connection, ...]
    jacobi: bool = False


def schedule(graph: SystemGraph, algorithm: str = "gauss-seidel") -> Schedule:
    """Order a system's FMUs. Raises ConfigError for an algebraic loop (Gauss-Seidel)."""
    jacobi = algorithm == "jacobi"
    order = _order(graph)
    if order is None and not jacobi:
        raise ConfigError([_loop_problem(graph)])
    if order is None:
        order = list(range(len(graph.nodes)))
    place = {node: i for i, node in enumerate(order)}
    index = graph.index
    delayed = tuple(
        c
        for c in graph.connections
        if jacobi or place[index[c.source.instance]] >= place[index[c.destination.instance]]
    )
    return Schedule(tuple(order), delayed, jacobi)


def feeds_through(graph: SystemGraph, connection: Connection, to_connected: bool) -> bool:
    """Whether an output of the destination depends at once on this connection's input.

    With ``to_connected`` only outputs count that drive another FMU.
    """
    end = connection.destination
    fmu = graph.nodes[graph.index[end.instance]].fmu
    acting = {end.port.references[e] for e in end.elements}
    outputs = graph.connected[end.instance] if to_connected else fmu.feedthrough.keys()
    return any(acting & fmu.feedthrough.get(o, frozenset()) for o in outputs)


def _order(graph: SystemGraph) -> list[int] | None:
    """The order that honours all feedthrough; if there is none, that to connected outputs."""
    for to_connected in (False, True):
        order = _sorted(len(graph.nodes), _edges(graph, to_connected))
        if order is not None:
            return order
    return None


def _edges(graph: SystemGraph, to_connected: bool) -> Edges:
    """For each node the nodes that must step after it."""
    index = graph.index
    after: dict[int, set[int]] = {i: set() for i in range(len(graph.nodes))}
    for c in graph.connections:
        if feeds_through(graph, c, to_connected):
            after[index[c.source.instance]].add(index[c.destination.instance])
    return {k: frozenset(v) for k, v in after.items()}


def _sorted(count: int, after: Edges) -> list[int] | None:
    """Topological order, the config's order among equals; None if there is a cycle."""
    waiting = [0] * count
    for followers in after.values():
        for node in followers:
            waiting[node] += 1
    ready = [i for i in range(count) if not waiting[i]]
    order = []
    while ready:
        node = heapq.heappop(ready)
        order.append(node)
        for follower in after[node]:
            waiting[follower] -= 1
            if not waiting[follower]:
                heapq.heappush(ready, follower)
    return order if len(order) == count else None


def _loop_problem(graph: SystemGraph) -> Problem:
    loop = _cycle(_port_edges(graph))
    if loop is not None:
        return Problem(
            "connections",
            f"algebraic loop: {' -> '.join(loop)}",
            'let one of these FMUs declare no direct feedthrough, put one with a state into the '
            'loop, or set algorithm = "jacobi", which delays every connection by one step',
        )
    edges = _edges(graph, to_connected=True)
    names = _cycle({graph.nodes[k].name: [graph.nodes[v].name for v in vs]
                    for k, vs in edges.items()})
    return Problem(
        "connections",
        f"no order of whole FMUs serves {' -> '.join(names or ())}: each feeds the other at once",
        'split one of these FMUs, or set algorithm = "jacobi", which delays every connection by '
        "one step",
    )


def _port_edges(graph: SystemGraph) -> Mapping[str, list[str]]:
    """What acts at once on what, by port: connections, and feedthrough inside FMUs."""
    edges: dict[str, list[str]] = {}
    for c in graph.connections:
        source = f"{c.source.instance}.{c.source.port.name}"
        destination = f"{c.destination.instance}.{c.destination.port.name}"
        edges.setdefault(source, []).append(destination)
    for node in graph.nodes:
        for port in node.fmu.inputs.values():
            edges.setdefault(f"{node.name}.{port.name}", []).extend(
                f"{node.name}.{o.name}"
                for o in node.fmu.outputs.values()
                if node.fmu.depends(o, port)
            )
    return edges


def _cycle(edges: Mapping[str, Iterable[str]]) -> list[str] | None:
    """Some cycle, closed by its first name; depth first without recursion."""
    done: set[str] = set()
    for root in edges:
        if root in done:
            continue
        path, on_path = [root], {root}
        branches = [iter(edges.get(root, ()))]
        while branches:
            follower = next(branches[-1], None)
            if follower is None:
                done.add(path[-1])
                on_path.discard(path.pop())
                branches.pop()
            elif follower in on_path:
                return [*path[path.index(follower):], follower]
            elif follower not in done:
                path.append(follower)
                on_path.add(follower)
                branches.append(iter(edges.get(follower, ())))
    return None
