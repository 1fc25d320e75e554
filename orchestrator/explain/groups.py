"""What the picture of a system draws as one: of a large system all copies of a template."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..system import System
from ..wiring.graph import Connection, Node
from .explanation import Timing, timings

TOLD = 3  # instances that a box names one by one
SHOWN = 12  # instances; of more, the copies of a template are one box


@dataclass(frozen=True)
class Group:
    """Instances in one box: ``craft{i}``, or one by its own name. ``numbers``: when they step."""

    name: str
    nodes: tuple[Node, ...]
    numbers: tuple[int, ...]

    @property
    def heading(self) -> str:
        """Which instances, with their places in the order of stepping."""
        *others, last = [n.name for n in self.nodes]
        if not others:
            return f"{self.numbers[0]}  {last}"
        places = sorted(self.numbers)
        if len(places) <= TOLD:
            return f"{', '.join(map(str, places))}  {', '.join((*others, last))}"
        return f"{places[0]}, {places[1]} … {places[-1]}  {others[0]}, {others[1]} … {last}"

    @property
    def place(self) -> float:
        """When they step, on average."""
        return sum(self.numbers) / len(self.numbers)


@dataclass(frozen=True)
class Link:
    """Connections drawn as one, with the timing that most have. ``forward``: along a line.

    ``shown``: the source as the config names it, such as ``craft{i-1}.attitude``.
    """

    source: str
    out: str
    destination: str
    into: str
    shown: str
    timing: Timing
    forward: bool

    @property
    def key(self) -> str:
        """What tells it from others into the same box."""
        return f"{self.into}|{self.shown}"


def groups_of(system: System) -> list[Group]:
    """The boxes of a system, in the order of stepping."""
    graph, origins = system.graph, system.loaded.origins
    number = {graph.nodes[i].name: k for k, i in enumerate(system.schedule.order, 1)}
    members: dict[tuple[str, str], list[Node]] = {}
    for node in graph.nodes:
        origin = origins.get(("instances", node.name)) if len(graph.nodes) > SHOWN else None
        key = (node.name, "") if origin is None else (str(origin[-1]), node.fmu.model_name)
        members.setdefault(key, []).append(node)
    taken = Counter(name for name, _ in members)
    groups = [
        Group(
            name if taken[name] == 1 else f"{name} ({model})",
            tuple(nodes), tuple(number[n.name] for n in nodes),
        )
        for (name, model), nodes in members.items()
    ]  # fmt: skip
    return sorted(groups, key=lambda g: g.place)


def links_of(system: System, groups: Sequence[Group]) -> list[Link]:
    """The connections between and within groups, those of one kind as one."""
    home = {node.name: group for group in groups for node in group.nodes}
    templates = {
        "".join(str(key[1]).split()): str(origin[-1])
        for key, origin in system.loaded.origins.items() if key[0] == "connections"
    }  # fmt: skip
    found: dict[tuple[str, str, str, str, str], Counter[Timing]] = {}
    for c, timing in timings(system.graph, system.schedule):
        source, destination = home[c.source.instance], home[c.destination.instance]
        shown = _shown(c, source, templates)
        key = source.name, _port(c.source), destination.name, _port(c.destination), shown
        found.setdefault(key, Counter())[timing] += 1
    place = {group.name: group.place for group in groups}
    return [
        Link(*key, timing, timing in ("same", "ahead") and place[key[0]] < place[key[2]])
        for key, timings_ in found.items()
        for timing, _ in timings_.most_common(1)
    ]


def _shown(c: Connection, source: Group, templates: Mapping[str, str]) -> str:
    template = templates.get("".join(str(c).split()))
    if len(source.nodes) == 1 or template is None:
        return str(c.source)
    return template.partition("->")[0].strip()


def _port(end: object) -> str:
    return str(end).partition(".")[2]
