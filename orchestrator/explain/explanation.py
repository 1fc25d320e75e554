"""What will happen when a system runs, as plain data: order, rates, timing of connections.

A connection's value belongs, while its destination steps from t to t + h, either to the instant
t + h that the destination steps to, because its source stepped before, or to t. Whether this
matters depends on the destination: an input that acts on outputs at once should see the instant
that the outputs belong to; an input that acts on states only is held over the step anyway, or
extrapolated where the coupling says so.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from ..fmi.sampling import sample_period
from ..schedule.order import Schedule, feeds_through
from ..schedule.plan import Unit
from ..system import System
from ..wiring.graph import Connection, SystemGraph
from ..wiring.unchecked import unchecked_frames, unchecked_units
from ..wiring.undriven import undriven

Timing = Literal["same", "ahead", "held", "late"]


def meaning(coupling: str) -> Mapping[Timing, str]:
    """What each timing means, in the order in which they are told."""
    held = ", held over the step" if coupling == "hold" else ""
    return {
        "same": "the value of the same instant",
        "held": f"the value of the step's start{held} (they act on states only)",
        "ahead": "the value of the step's end (they act on states only)",
        "late": "a value that is one step late for outputs that depend on it at once",
    }


@dataclass(frozen=True)
class Step:
    """One instance in the order of stepping, and what is special about its steps, if anything."""

    instance: str
    model: str
    version: str
    rate: str


@dataclass(frozen=True)
class Explanation:
    """Everything that ``sightline explain`` says."""

    facts: tuple[tuple[str, str], ...]
    meaning: Mapping[Timing, str]
    steps: tuple[Step, ...]
    timing: tuple[tuple[Connection, Timing], ...]
    together: tuple[str, ...]
    loops: tuple[str, ...]
    conversions: tuple[str, ...]
    undriven: tuple[tuple[str, tuple[str, ...]], ...]
    unchecked: tuple[tuple[str, tuple[str, ...]], ...]
    others: tuple[tuple[str, tuple[str, ...]], ...]
    frames: tuple[tuple[str, tuple[str, ...]], ...]

    def of(self, timing: Timing) -> list[Connection]:
        """The connections of one timing."""
        return [c for c, t in self.timing if t == timing]


def explain(system: System) -> Explanation:
    """Say what a system will do."""
    graph, order = system.graph, system.schedule
    steps = []
    for unit in system.plan.units:
        node = graph.nodes[unit.node]
        steps.append(Step(node.name, node.fmu.model_name, node.fmu.version, rate(system, unit)))
    return Explanation(
        facts=tuple(_facts(system)),
        meaning=meaning(system.loaded.config.simulation.coupling),
        steps=tuple(steps),
        timing=timings(graph, order),
        together=tuple(_together(system)),
        loops=tuple(_loops(system)),
        conversions=tuple(_conversions(graph)),
        undriven=tuple(_undriven(graph).items()),
        unchecked=tuple(_unchecked(graph).items()),
        others=tuple((n.name, tuple(n.fmu.others)) for n in graph.nodes if n.fmu.others),
        frames=tuple(_frames(graph)),
    )


def timings(graph: SystemGraph, order: Schedule) -> tuple[tuple[Connection, Timing], ...]:
    """When the value belongs that each connection carries."""
    behind = set(map(id, order.delayed))
    found: list[tuple[Connection, Timing]] = []
    for c in graph.connections:
        at_once = feeds_through(graph, c, to_connected=False)
        if id(c) in behind:
            found.append((c, "late" if at_once else "held"))
        else:
            found.append((c, "same" if at_once else "ahead"))
    return tuple(found)


def rate(system: System, unit: Unit) -> str:
    """How an FMU steps and acts unless as most do: how often, and inputs that it cannot vary."""
    step = system.loaded.config.simulation.step
    node = system.graph.nodes[unit.node]
    words = ["isolated"] if node.isolated else []
    if unit.every > 1:
        words.append(f"steps every {unit.every * step:g} s")
    if unit.parts > 1:
        words.append(f"in {unit.parts} parts")
    if period := sample_period(node):
        words.append(f"samples every {period:g} s")
    varies = system.loaded.config.simulation.coupling != "hold"
    if varies and len(unit.sources) and not node.fmu.can_interpolate:
        words.append("inputs held: takes no derivatives of them")
    return ", ".join(words)


def _undriven(graph: SystemGraph) -> dict[str, tuple[str, ...]]:
    """For each instance the inputs, or elements of them, that nothing drives, and why not."""
    idle: dict[str, tuple[str, ...]] = {}
    for one in undriven(graph):
        mark = f" ({one.excuse})" if one.excuse else ""
        names = tuple(f"{label}{mark}" for label in one.labels)
        idle[one.instance] = (*idle.get(one.instance, ()), *names)
    return idle


def _unchecked(graph: SystemGraph) -> dict[str, tuple[str, ...]]:
    """Frames and units: the connections where they are not checked, and why not."""
    return {
        what: tuple(f"{one.connection}: {', '.join(one.reasons)}" for one in found)
        for what, found in (("frames", unchecked_frames(graph)), ("units", unchecked_units(graph)))
        if found
    }


def _facts(system: System) -> Sequence[tuple[str, str]]:
    config, graph = system.loaded.config, system.graph
    simulation = config.simulation
    values = sum(len(c.destination.elements) for c in graph.connections)
    repeats = ", ".join(f"{i} = 1 to {r.count} ({r.neighbours})" for i, r in config.repeat.items())
    recorded = sum(len(s.elements) for s in system.selection.recorded)
    every = config.record.every or simulation.step
    when = "at every accepted step" if simulation.adaptive and config.record.every is None else (
        f"every {every:g} s"
    )
    facts = [
        ("system", f"{len(graph.nodes)} instances, {len(graph.connections)} connections "
                   f"of {values} values"),
        ("repeated", repeats),
        ("time", f"{simulation.start_time:g} to {simulation.stop_time:g} s, "
                 f"communication step {simulation.step:g} s"),
        ("algorithm", f"{simulation.algorithm}, coupling {simulation.coupling}"),
        ("recorded", f"{len(system.selection.recorded)} signals of {recorded} values "
                     f"{when}"),
    ]  # fmt: skip
    return [(name, text) for name, text in facts if text]


def _together(system: System) -> Iterator[str]:
    """Clusters whose values pass variable by variable after all have stepped."""
    nodes = system.graph.nodes
    for cluster in system.schedule.clusters:
        if len(cluster.nodes) > 1 and not cluster.cyclic:
            names = ", ".join(nodes[i].name for i in cluster.nodes)
            passed = ", ".join(nodes[i].name for i in cluster.updates)
            yield f"{names}: all step, then values pass on to {passed}"


def _loops(system: System) -> Iterator[str]:
    """Algebraic loops, and how they are solved or broken."""
    nodes, simulation = system.graph.nodes, system.loaded.config.simulation
    for cluster in system.schedule.clusters:
        if cluster.cyclic:
            names = ", ".join(nodes[i].name for i in cluster.nodes)
            exact = all(nodes[i].fmu.has_derivatives for i in cluster.nodes)
            method = "Newton's method" if exact else "Anderson's acceleration"
            yield (
                f"{names}: solved at every step by {method} to {simulation.loop_tolerance:g}, "
                f"in at most {simulation.loop_iterations} iterations"
            )
    for name in simulation.delay:
        yield f"{name}: one step late, as the configuration allows"


def _conversions(graph: SystemGraph) -> list[str]:
    return [*graph.conversions, *(c.converted for c in graph.connections if c.converted)]


def _frames(graph: SystemGraph) -> list[tuple[str, tuple[str, ...]]]:
    """For each frame of the system which roles of which instances are bound to it."""
    bound: dict[str, list[str]] = {}
    for node in graph.nodes:
        roles = {p.frame for p in node.fmu.ports.values() if p.frame}
        for role in sorted(roles - {"inertial"}):
            frames = node.frames.get(role, "")
            for frame in (frames,) if isinstance(frames, str) else dict.fromkeys(frames):
                bound.setdefault(frame, []).append(f"{node.name} ({role})")
    unbound = bound.pop("", None)
    found = [(frame, tuple(whose)) for frame, whose in bound.items()]
    return [*found, ("not bound, not checked", tuple(unbound))] if unbound else found
