"""What a run says of its wiring before it starts: in few lines, each once for the whole system."""

from __future__ import annotations

from collections.abc import Iterator

from ..alike import FEW
from .graph import SystemGraph
from .unchecked import unchecked_frames, unchecked_units
from .undriven import Undriven, undriven

ALL = "sightline explain tells which"


def notes(graph: SystemGraph) -> Iterator[str]:
    """What is allowed but worth knowing."""
    yield from _conversions(graph)
    yield from _unchecked(graph)
    if excused := sum(1 for one in undriven(graph) if one.excuse):
        what = "1 input that is" if excused == 1 else f"{excused} inputs that are"
        yield f"nothing drives {what} optional or given a start value ({ALL})"
    for node in graph.nodes:
        if node.fmu.others:
            them = ", ".join(f"{other} ({type_})" for other, type_ in node.fmu.others.items())
            yield f"{node.name}: nothing can drive {them}; left to the FMU"


def warnings(graph: SystemGraph) -> Iterator[str]:
    """What is allowed but more likely a connection that was forgotten."""
    return (f"nothing drives {one}; {_stays(one)}" for one in undriven(graph) if not one.excuse)


def _stays(one: Undriven) -> str:
    if len(one.labels) > 1:
        return "they stay at their start values"
    return f"it stays at its start value {one.value}".rstrip()


def _conversions(graph: SystemGraph) -> list[str]:
    found = [*(c.converted for c in graph.connections if c.converted), *graph.conversions]
    if len(found) <= FEW:
        return found
    return [f"{len(found)} values are converted from one unit to another ({ALL})"]


def _unchecked(graph: SystemGraph) -> Iterator[str]:
    frames, units = unchecked_frames(graph), unchecked_units(graph)
    counts = [f"{name} of {len(found)}" for name, found in (("frames", frames), ("units", units))
              if found]  # fmt: skip
    if not counts:
        return
    silent = list(dict.fromkeys(name for one in (*frames, *units) for name in one.silent))
    why = ["bind roles with frames = {...}"] if any(
        len(one.reasons) > len(one.silent) for one in frames
    ) else []  # fmt: skip
    if silent:
        others = f" and {len(silent) - 1} more" if len(silent) > 1 else ""
        why.append(f"{silent[0]}{others} {'declare' if others else 'declares'} none")
    last = len(units or frames)
    connections = "connection" if last == 1 else "connections"
    yield f"{' and '.join(counts)} {connections} are not checked: {', '.join(why)} ({ALL})"
