"""How often each FMU steps, and in how many parts; what does not fit is said with its remedy."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from ..config.loading import Loaded
from ..config.model import Config, Simulation
from ..errors import Problem
from ..wiring.graph import Node, SystemGraph
from .plan import Rates

DEGREES = {"hold": 0, "linear": 1, "quadratic": 2}
NEAR = 1e-9  # relative, of numbers that should be whole


def rates_of(loaded: Loaded, graph: SystemGraph) -> tuple[dict[str, Rates], list[Problem]]:
    """The rates of all instances, and every problem."""
    config = loaded.config
    rates = {node.name: _rates(config, node) for node in graph.nodes}
    problems = [
        loaded.place(Problem(".".join(path), what, remedy), path)
        for path, what, remedy in _problems(config, graph, rates)
    ]
    return rates, problems


def _rates(config: Config, node: Node) -> Rates:
    instance = config.instances[node.name]
    if instance.max_step is None:
        return Rates(instance.every)
    width = instance.every * config.simulation.step
    return Rates(instance.every, max(1, math.ceil(width / instance.max_step * (1 - NEAR))))


Found = tuple[tuple[str, ...], str, str]


def _problems(
    config: Config, graph: SystemGraph, rates: Mapping[str, Rates]
) -> Iterator[Found]:
    simulation = config.simulation
    for node in graph.nodes:
        every = rates[node.name].every
        path = ("instances", node.name, "every")
        if not simulation.adaptive and simulation.steps % every:
            near = max(1, round(simulation.steps / every)) * every * simulation.step
            what = f"{every} steps do not divide the run's {simulation.steps}"
            remedy = f"nearest stop_time: {simulation.start_time + near:.12g}"
            yield path, what, remedy
        yield from _own_step(simulation, node, rates[node.name])
    pairs = {
        tuple(sorted((c.source.instance, c.destination.instance), key=lambda n: rates[n].every)): c
        for c in reversed(graph.connections)
    }
    for (fast, slow), c in reversed(pairs.items()):
        if rates[slow].every % rates[fast].every:
            what = f"{rates[slow].every} is not a multiple of {fast}'s {rates[fast].every}"
            low = rates[slow].every // rates[fast].every * rates[fast].every
            remedy = f"{c} connects them; nearest: {low} or {low + rates[fast].every}"
            yield ("instances", slow, "every"), what, remedy
    if simulation.adaptive:
        yield from _adaptive(graph)


def _own_step(simulation: Simulation, node: Node, rates: Rates) -> Iterator[Found]:
    """An FMU whose solver has a fixed step takes multiples of it."""
    own, width = node.fmu.fixed_step, rates.every * simulation.step / rates.parts
    if own is None or simulation.adaptive:
        return
    count = width / own
    if round(count) < 1 or abs(count - round(count)) > NEAR * max(count, 1.0):
        what = f"{node.fmu.model_name} steps by {own:g}, of which {width:g} is no multiple"
        remedy = f"let step · every be a multiple of {own:g}"
        yield ("instances", node.name), what, remedy


def _adaptive(graph: SystemGraph) -> Iterator[Found]:
    """Error control takes steps again, with other sizes."""
    for node in graph.nodes:
        lacks = []
        if not node.fmu.can_restore:
            lacks.append("cannot restore its state")
        if not node.fmu.variable_step:
            lacks.append("takes steps of one size only")
        if lacks:
            what = f"{node.name} ({node.fmu.model_name}) {' and '.join(lacks)}"
            remedy = 'set algorithm = "gauss-seidel"'
            yield ("simulation", "algorithm"), what, remedy
