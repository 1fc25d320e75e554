"""Things timed side by side: in turn, for several rounds, so that all meet the same machine.

A ratio is the median of the ratios within each round: what slows the machine for a while slows
both numbers of it.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Mapping

from rich.table import Table

Timing = Callable[[], float]


def timed(timings: Mapping[str, Timing], rounds: int) -> dict[str, list[float]]:
    """What each timing gives in each round."""
    found: dict[str, list[float]] = {name: [] for name in timings}
    for _ in range(rounds):
        for name, timing in timings.items():
            found[name].append(timing())
    return found


def ratio(found: Mapping[str, list[float]], name: str, reference: str) -> float:
    """How many times the reference one of them takes."""
    pairs = zip(found[name], found[reference], strict=True)
    return statistics.median(a / b for a, b in pairs)


def table(title: str, unit: str, found: Mapping[str, list[float]], reference: str) -> Table:
    """One row for each: median and least, and the ratio to the reference."""
    result = Table(title=title, title_justify="left")
    for heading in ("", f"{unit}, median", "least", f"ratio to {reference}"):
        result.add_column(heading, justify="right" if heading else "left")
    for name, values in found.items():
        median, least = statistics.median(values), min(values)
        times = ratio(found, name, reference)
        result.add_row(name, f"{median:.3f}", f"{least:.3f}", f"{times:.2f}")
    return result
