"""The order in which FMUs step, from the declared dependencies of outputs on inputs.

Gauss-Seidel: an FMU whose outputs depend at once on an input steps after the FMU that drives
this input, so that a chain sensor -> controller -> allocation holds values of one instant. Other
connections carry the value of the same instant if their source happens to step earlier, else that
of the instant before. FMUs that no order of whole FMUs serves form a cluster: they all step, then
values pass between them variable by variable; if the variables feed each other in a circle, the
stepper solves for values that agree. Jacobi: all FMUs step on the values of the instant before.
"""

from __future__ import annotations

import heapq
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..errors import ConfigError, Problem, nearest
from ..wiring.graph import Connection, SystemGraph
from .cycles import has_cycle, strong_components

Edges = Mapping[int, frozenset[int]]
Element = tuple[int, int]  # a node and a value reference of it


@dataclass(frozen=True)
class Cluster:
    """FMUs that step together: positions of nodes in the graph, one for most clusters.

    ``cyclic``: an algebraic loop, to be solved. ``updates``: else the nodes whose inputs are to be
    set again, in this order, after all have stepped.
    """

    nodes: tuple[int, ...]
    cyclic: bool = False
    updates: tuple[int, ...] = ()


@dataclass(frozen=True)
class Schedule:
    """``order``: positions of the graph's nodes; ``delayed``: connections one step late."""

    order: tuple[int, ...]
    delayed: tuple[Connection, ...]
    jacobi: bool = False
    clusters: tuple[Cluster, ...] = ()


def schedule(
    graph: SystemGraph, algorithm: str = "gauss-seidel", delay: Collection[str] = ()
) -> Schedule:
    """Order a system's FMUs; ``delay`` names connections that may be one step late.

    Raises ConfigError if such a name is no connection's.
    """
    _check_names(graph, delay)
    acting = [c for c in graph.connections if str(c) not in delay]
    clusters = _clusters(graph, acting)
    jacobi = algorithm == "jacobi"
    if jacobi and any(len(c.nodes) > 1 or c.cyclic for c in clusters):
        clusters = [Cluster((i,)) for i in range(len(graph.nodes))]
    place = {node: i for i, cluster in enumerate(clusters) for node in cluster.nodes}
    index = graph.index
    delayed = tuple(c for c in graph.connections if jacobi or _late(c, clusters, place, index))
    order = tuple(node for cluster in clusters for node in cluster.nodes)
    return Schedule(order, delayed, jacobi, tuple(clusters))


def _late(
    c: Connection, clusters: Sequence[Cluster], place: Mapping[int, int], index: Mapping[str, int]
) -> bool:
    """Whether a connection carries the value of the instant before."""
    source, destination = (index[end.instance] for end in (c.source, c.destination))
    within = place[source] == place[destination]
    cluster = clusters[place[source]]
    if within and (cluster.cyclic or len(cluster.nodes) > 1):
        return False
    return place[source] >= place[destination]


def feeds_through(graph: SystemGraph, connection: Connection, to_connected: bool) -> bool:
    """Whether an output of the destination depends at once on this connection's input.

    With ``to_connected`` only outputs count that drive another FMU.
    """
    end = connection.destination
    fmu = graph.nodes[graph.index[end.instance]].fmu
    acting = {end.port.references[e] for e in end.elements}
    outputs = graph.connected[end.instance] if to_connected else fmu.feedthrough.keys()
    return any(acting & fmu.feedthrough.get(o, frozenset()) for o in outputs)


def _check_names(graph: SystemGraph, delay: Collection[str]) -> None:
    names = {str(c) for c in graph.connections}
    problems = [
        Problem("simulation.delay", f'"{name}" is no connection', nearest(name, names))
        for name in delay
        if name not in names
    ]
    if problems:
        raise ConfigError(problems)


def _clusters(graph: SystemGraph, acting: Sequence[Connection]) -> list[Cluster]:
    """Clusters that honour all feedthrough; if a loop grows by it, that to connected ones."""
    edges = _edges(graph, acting, to_connected=False)
    clusters = _ordered(graph, acting, edges)
    if any(c.cyclic for c in clusters):
        fewer = _edges(graph, acting, to_connected=True)
        smaller = _ordered(graph, acting, fewer)
        if {frozenset(c.nodes) for c in clusters} != {frozenset(c.nodes) for c in smaller}:
            return smaller
    return clusters


def _ordered(graph: SystemGraph, acting: Sequence[Connection], edges: Edges) -> list[Cluster]:
    parts = _sorted(strong_components(edges), edges)
    return [_cluster(graph, acting, sorted(part), edges) for part in parts]


def _edges(graph: SystemGraph, acting: Iterable[Connection], to_connected: bool) -> Edges:
    """For each node the nodes that must step after it."""
    index = graph.index
    after: dict[int, set[int]] = {i: set() for i in range(len(graph.nodes))}
    for c in acting:
        if feeds_through(graph, c, to_connected):
            after[index[c.source.instance]].add(index[c.destination.instance])
    return {k: frozenset(v) for k, v in after.items()}


def _sorted(parts: Sequence[Sequence[int]], after: Edges) -> list[Sequence[int]]:
    """Topological order of the parts, the config's order among equals."""
    part_of = {node: i for i, part in enumerate(parts) for node in part}
    followers: list[set[int]] = [set() for _ in parts]
    for node, nodes in after.items():
        followers[part_of[node]] |= {part_of[n] for n in nodes} - {part_of[node]}
    waiting = [0] * len(parts)
    for some in followers:
        for part in some:
            waiting[part] += 1
    ready = [(min(parts[i]), i) for i in range(len(parts)) if not waiting[i]]
    heapq.heapify(ready)
    order = []
    while ready:
        _, i = heapq.heappop(ready)
        order.append(parts[i])
        for part in followers[i]:
            waiting[part] -= 1
            if not waiting[part]:
                heapq.heappush(ready, (min(parts[part]), part))
    return order


def _cluster(
    graph: SystemGraph, acting: Iterable[Connection], nodes: Sequence[int], after: Edges
) -> Cluster:
    if len(nodes) == 1 and nodes[0] not in after[nodes[0]]:
        return Cluster(tuple(nodes))
    edges, inputs = _element_edges(graph, acting, nodes)
    if has_cycle(edges):
        return Cluster(tuple(nodes), cyclic=True)
    return Cluster(tuple(nodes), updates=_updates(edges, inputs))


def _element_edges(
    graph: SystemGraph, acting: Iterable[Connection], nodes: Sequence[int]
) -> tuple[dict[Element, set[Element]], set[Element]]:
    """What acts at once on what within a cluster, and the inputs that are driven within it."""
    edges: dict[Element, set[Element]] = {}
    inputs: set[Element] = set()
    within = set(nodes)
    for c in acting:
        source, destination = (graph.index[end.instance] for end in (c.source, c.destination))
        if source in within and destination in within:
            for out, into in zip(c.source.elements, c.destination.elements, strict=True):
                element = destination, c.destination.port.references[into]
                inputs.add(element)
                edges.setdefault((source, c.source.port.references[out]), set()).add(element)
    for node in nodes:
        for out, acting_inputs in graph.nodes[node].fmu.feedthrough.items():
            for into in acting_inputs:
                if (node, into) in inputs:
                    edges.setdefault((node, into), set()).add((node, out))
    return edges, inputs


def _updates(edges: Mapping[Element, set[Element]], inputs: set[Element]) -> tuple[int, ...]:
    """The nodes to set again, level by level: an input after all that its source depends on."""
    level: dict[Element, int] = {}
    for part in reversed(strong_components(edges)):
        element = part[0]
        depth = level.setdefault(element, 0)
        for follower in edges.get(element, ()):
            step = 1 if follower in inputs else 0
            level[follower] = max(level.get(follower, 0), depth + step)
    nodes = [node for _, node in sorted({(level[element], element[0]) for element in inputs})]
    return tuple(n for i, n in enumerate(nodes) if i == 0 or n != nodes[i - 1])
