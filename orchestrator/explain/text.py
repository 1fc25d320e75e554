"""An explanation as text. What differs in numbers only is told once, with how often."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..alike import few
from .explanation import Explanation


def text(explanation: Explanation) -> str:
    """The whole explanation, a section after the other."""
    return "\n".join(_lines(explanation)) + "\n"


def _lines(explanation: Explanation) -> Iterator[str]:
    width = max(len(name) for name, _ in explanation.facts)
    yield from (f"{name:<{width}}  {what}" for name, what in explanation.facts)
    yield from _section("order of stepping", list(_steps(explanation)))
    for timing, meaning in explanation.meaning.items():
        connections = [str(c) for c in explanation.of(timing)]
        if connections:
            yield from _section(_counted(len(connections), meaning), connections)
    if explanation.together:
        yield from _section("stepping together", list(explanation.together))
    loops = explanation.loops or ["none"]
    yield from _section("algebraic loops", list(loops))
    if explanation.conversions:
        yield from _section("unit conversions", list(explanation.conversions))
    if explanation.undriven:
        rows = [f"{name}: {', '.join(ports)}" for name, ports in explanation.undriven]
        yield from _section("inputs that nothing drives, kept at their start values", rows)
    if explanation.others:
        rows = [f"{name}: {', '.join(variables)}" for name, variables in explanation.others]
        yield from _section("variables that nothing can drive: clocks and binary ones", rows)
    for what, unchecked in explanation.unchecked:
        yield from _section(f"connections whose {what} are not checked", unchecked)
    if explanation.frames:
        rows = [f"{frame}: {', '.join(few(whose))}" for frame, whose in explanation.frames]
        yield from _section("frames", rows)


def _steps(explanation: Explanation) -> Iterator[str]:
    places = len(str(len(explanation.steps)))
    width = max(len(s.instance) for s in explanation.steps)
    models = max(len(s.model) for s in explanation.steps)
    for number, step in enumerate(explanation.steps, 1):
        rate = f"  {step.rate}" if step.rate else ""
        yield (
            f"{number:>{places}}  {step.instance:<{width}}  {step.model:<{models}}  "
            f"FMI {step.version}{rate}"
        )


def _counted(count: int, meaning: str) -> str:
    if count > 1:
        return f"{count} connections carry {meaning}"
    return f"1 connection carries {meaning}".replace("they act", "it acts")


def _section(title: str, rows: Sequence[str]) -> Iterator[str]:
    yield ""
    yield f"{title}:"
    yield from (f"  {row}" for row in few(rows))
