"""The course of inputs inside a step: polynomials through their values at communication points.

An FMU that takes derivatives of its inputs follows u(τ) = base + slope τ + curvature τ²/2 during a
step. Where the source has stepped before, its value at the end of the step is known and the
polynomial interpolates; where not, it extrapolates from the step's start. Both leave an error of
order h² (linear) or h³ (quadratic) in the input, hence in the states over a given time.

A unit vector or quaternion that is extrapolated would leave the unit sphere by an error of the same
order, and a block may refuse it: its slope is changed such that it ends on the sphere.

Discrete signals, and those of FMUs that step less often than the FMU they drive, are held.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from ..fmi.sampling import sample_period
from ..schedule.layout import Drives, Key, Layout
from ..schedule.order import Schedule
from ..schedule.plan import Array, Course, Unit
from ..wiring.graph import Node, SystemGraph


def with_courses(
    graph: SystemGraph, order: Schedule, units: Sequence[Unit], layout: Layout, drives: Drives,
    degree: int,
) -> list[Unit]:  # fmt: skip
    """The units, with a course for the inputs that can have one."""
    every = {graph.nodes[u.node].name: u.every for u in units}
    place = {
        graph.nodes[n].name: i for i, c in enumerate(order.clusters) for n in c.nodes
    }
    result = []
    for unit in units:
        node = graph.nodes[unit.node]
        inputs, keys, references, newest = [], [], [], []
        for position in range(unit.inputs.first, unit.inputs.last):
            key = layout.keys[position]
            if key is None or key not in drives or not node.fmu.can_interpolate:
                continue
            source, _, _ = drives[key]
            if every[source[0]] > unit.every or not _continuous(graph, source, key):
                continue
            fresh = not order.jacobi and place[source[0]] < place[node.name]
            inputs.append(position)
            keys.append(key)
            references.append(node.fmu.ports[key[1]].references[key[2]])
            newest.append(0 if fresh else every[source[0]])
        course = None
        if inputs:
            history = layout.reserve(2 * len(inputs))
            positions = np.array(inputs, dtype=np.intp)
            course = Course(
                degree, positions, tuple(references), tuple(newest), history,
                tuple(_directions(node, keys, newest)),
            )  # fmt: skip
        result.append(replace(unit, course=course))
    return result


def _directions(
    node: Node, keys: Sequence[Key], newest: Sequence[int]
) -> Iterator[tuple[int, int]]:
    """First and count of three or four numbers of one port, all known at the step's start only."""
    for first, (_, name, element) in enumerate(keys):
        port = node.fmu.ports[name]
        count = port.shape[-1] if port.shape else 1
        row = [(node.name, name, element + k) for k in range(count)]
        plain = port.unit is None or port.unit.dimension == "1"
        if (
            count in (3, 4) and element % count == 0 and plain
            and keys[first:first + count] == row and all(newest[first:first + count])
        ):  # fmt: skip
            yield first, count


def _continuous(
    graph: SystemGraph, source: tuple[str, str, int], destination: tuple[str, str, int]
) -> bool:
    ends: list[tuple[Node, str]] = [
        (graph.nodes[graph.index[key[0]]], key[1]) for key in (source, destination)
    ]
    ports = [node.fmu.ports[name] for node, name in ends]
    return sample_period(ends[0][0]) == 0.0 and all(
        p.kind == "real" and p.variability == "continuous" for p in ports
    )


def weights(order: int, nodes: Array) -> Array:
    """What values at three instants contribute to base, slope and curvature at the instant 0.

    ``nodes``: instants, the newest first, one column for each input. The result has the shape
    (3 results, 3 values, inputs). Lagrange's polynomials and their derivatives.
    """
    count = nodes.shape[1]
    result = np.zeros((3, 3, count))
    if order == 1:
        a, b = nodes[0], nodes[1]
        result[0, 0], result[0, 1] = -b / (a - b), -a / (b - a)
        result[1, 0], result[1, 1] = 1.0 / (a - b), 1.0 / (b - a)
        return result
    for i in range(3):
        a, b, c = (nodes[(i + k) % 3] for k in range(3))
        scale = (a - b) * (a - c)
        result[0, i], result[1, i], result[2, i] = b * c / scale, -(b + c) / scale, 2.0 / scale
    return result


def through(instants: Sequence[float], values: Sequence[Array], at: Array) -> Array:
    """The polynomial through values at instants, evaluated at one instant for each input."""
    result = np.zeros(len(at))
    for i, value in enumerate(values):
        factor = np.ones(len(at))
        for j in range(len(values)):
            if j != i:
                factor *= (at - instants[j]) / (instants[i] - instants[j])
        result += factor * value
    return result
