"""Compiles a scheduled system into a plan."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from ..fmi.sampling import sample_period
from ..stepping.courses import with_courses
from ..wiring.graph import Node, SystemGraph
from ..wiring.signals import Signal
from .layout import Drives, Layout, drives_of
from .order import Cluster, Schedule
from .plan import Act, Loop, Plan, Rates, Unit


def compile_plan(
    graph: SystemGraph,
    order: Schedule,
    recorded: Iterable[Signal],
    rates: Mapping[str, Rates] | None = None,
    degree: int = 0,
) -> Plan:
    """Lay out a scheduled system; ``degree``: of the polynomials that inputs follow in a step."""
    layout = Layout()
    drives = drives_of(graph)
    for number in order.order:
        layout.add(graph.nodes[number], drives)
    rates = rates or {}
    units = []
    for number in order.order:
        node = graph.nodes[number]
        unit = _unit(number, node, layout, drives, rates.get(node.name, Rates()))
        units.append(unit)
    if degree:
        units = with_courses(graph, order, units, layout, drives, degree)
    place = {unit.node: i for i, unit in enumerate(units)}
    loops = [_loop(graph, c, place, layout, drives) for c in order.clusters if c.cyclic]
    columns = [
        layout.positions[(s.instance, s.port.name, e)] for s in recorded for e in s.elements
    ]
    return Plan(
        layout.size, tuple(units), tuple(_acts(order, place)), tuple(loops),
        np.array(columns, dtype=np.intp), np.array(list(_smooth(graph, layout)), dtype=np.intp),
    )  # fmt: skip


def _smooth(graph: SystemGraph, layout: Layout) -> Iterable[int]:
    for node, port in graph.signals.values():
        if port.kind == "real" and port.variability == "continuous" and not sample_period(node):
            for element in range(port.size):
                yield layout.positions[(node.name, port.name, element)]


def _unit(number: int, node: Node, layout: Layout, drives: Drives, rates: Rates) -> Unit:
    inputs, outputs = layout.segments[node.name]
    keys = [k for k in layout.keys[inputs.first:inputs.last] if k is not None]
    mine = [drives.get(key, (key, 1.0, 0.0)) for key in keys]  # an array's idle elements: their own
    sources = np.array([layout.positions[source] for source, _, _ in mine], dtype=np.intp)
    gain = np.array([g for _, g, _ in mine], dtype=float)
    shift = np.array([s for _, _, s in mine], dtype=float)
    plain = bool(np.all(gain == 1.0) and np.all(shift == 0.0))
    return Unit(
        number, inputs, outputs, sources, None if plain else gain, None if plain else shift,
        rates.every, rates.parts,
    )  # fmt: skip


def _acts(order: Schedule, place: Mapping[int, int]) -> Iterable[tuple[Act, int]]:
    if order.jacobi:
        for act in (Act.WRITE, Act.STEP, Act.READ):
            for unit in range(len(order.order)):
                yield act, unit
        return
    solved = 0
    for cluster in order.clusters:
        members = [place[node] for node in cluster.nodes]
        for unit in members:
            yield Act.WRITE, unit
            yield Act.STEP, unit
            if len(members) == 1:
                yield Act.READ, unit
        if cluster.cyclic:
            yield Act.SOLVE, solved
            solved += 1
        elif len(members) > 1:
            for unit in members:
                yield Act.READ, unit
            for node in cluster.updates:
                yield Act.UPDATE, place[node]
                yield Act.READ, place[node]


def _loop(
    graph: SystemGraph, cluster: Cluster, place: Mapping[int, int], layout: Layout, drives: Drives
) -> Loop:
    names = {graph.nodes[n].name for n in cluster.nodes}
    inside = {into for into, (out, _, _) in drives.items() if into[0] in names and out[0] in names}
    ports = {k: graph.nodes[graph.index[k[0]]].fmu.ports[k[1]] for k in inside}
    ordered = sorted(inside, key=lambda k: layout.positions[k])
    return Loop(
        tuple(place[n] for n in cluster.nodes),
        np.array([layout.positions[k] for k in ordered], dtype=np.intp),
        tuple(f"{k[0]}.{ports[k].label(k[2])}" for k in ordered),
    )
