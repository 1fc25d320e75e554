"""Values that differ from copy to copy of a template, as data.

    { each = [[1, 0, 0], [0, 1, 0]] }                    one value per copy
    { first = [0.0, 0.0, 0.0], step = [10.0, 0.0, 0.0] } the same difference from copy to copy
    { file = "starts.csv", columns = ["x", "y", "z"] }   one row per copy; all columns if not given
    { random = "uniform", low = -1.0, high = 1.0, seed = 7 }
    { random = "normal", mean = [0, 0, 0], sigma = [1, 1, 1], seed = 7 }
    { random = "attitude", seed = 7 }                    every attitude alike likely
    { random = "direction", seed = 7 }                   every unit vector alike likely
    { value = 0.15, unit = "deg/sqrt(h)" }               one value in a unit of its own for all

Each takes ``unit`` besides. It is left for :mod:`.quantities` to convert, copy by copy.

A random value depends on the seed, the number of the copy and the name of the value only: the
third copy of ten is the third of a thousand.
"""

from __future__ import annotations

import csv
import math
import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..errors import nearest

KEYS: Mapping[str, tuple[set[str], set[str]]] = {  # required and allowed besides
    "each": (set(), set()),
    "first": ({"step"}, set()),
    "file": (set(), {"columns"}),
    "random": ({"seed"}, {"low", "high", "mean", "sigma"}),
}
RANDOM = {
    "uniform": ("low", "high"),
    "normal": ("mean", "sigma"),
    "attitude": (),
    "direction": (),
}


@dataclass
class Refused(Exception):
    """A rule for values that cannot be followed."""

    what: str
    remedy: str = ""


def spread(rule: Mapping[str, Any], count: int, folder: Path, name: str) -> list[Any]:
    """The values of all copies. ``name`` keeps random values of one seed apart. Raises Refused."""
    if "value" in rule:
        return [dict(rule) for _ in range(count)]
    if "unit" in rule:
        plain = {k: v for k, v in rule.items() if k != "unit"}
        values = spread(plain, count, folder, name)
        return [{"value": v, "unit": rule["unit"]} for v in values]
    kind = next((k for k in KEYS if k in rule), None)
    if kind is None:
        raise Refused("is a table", f"give each copy's value by {', '.join(KEYS)}")
    required, allowed = KEYS[kind]
    if absent := sorted(required - rule.keys()):
        raise Refused(f"lacks {absent[0]}")
    if unknown := sorted(rule.keys() - required - allowed - {kind}):
        raise Refused(f"has the unknown key {unknown[0]}", nearest(unknown[0], required | allowed))
    makers: Mapping[str, Callable[[], list[Any]]] = {
        "each": lambda: _each(rule["each"], count),
        "first": lambda: [_plus(rule["first"], rule["step"], i) for i in range(count)],
        "file": lambda: _rows(folder / str(rule["file"]), rule.get("columns"), count),
        "random": lambda: _random(rule, count, name),
    }
    return makers[kind]()


def written_out(rule: Mapping[str, Any], column: list[Any]) -> dict[str, Any]:
    """A rule that names no file any more but holds the values that it gave to all copies."""
    if "unit" in rule:
        return {"each": [given["value"] for given in column], "unit": rule["unit"]}
    return {"each": column}


def _each(values: Any, count: int) -> list[Any]:
    if not isinstance(values, list) or len(values) != count:
        found = len(values) if isinstance(values, list) else "no list"
        raise Refused(f"each needs {count} values, one per copy; found {found}")
    return values


def _plus(first: Any, step: Any, times: int) -> Any:
    if isinstance(first, list) and isinstance(step, list) and len(first) == len(step):
        return [_plus(a, b, times) for a, b in zip(first, step, strict=True)]
    if not _number(first) or not _number(step):
        raise Refused("first and step must be numbers, or arrays of one shape")
    return first + times * step


def _rows(path: Path, columns: Any, count: int) -> list[Any]:
    try:
        if path.exists() and not path.is_file():  # a device may never end
            raise Refused(f"{path} is not a file")
        with path.open(newline="", encoding="utf-8-sig") as file:
            rows = [row for row in csv.reader(file) if row]
    except (OSError, ValueError, csv.Error) as error:  # what a path or an encoding can be
        raise Refused(f"{path} cannot be read: {error}") from None
    head = [cell.strip() for cell in rows[0]] if rows and not _are_numbers(rows[0]) else []
    rows = rows[1:] if head else rows
    chosen = head.index if columns is not None else None
    wanted = columns if isinstance(columns, list) else [columns]
    if chosen is not None and (unknown := [str(c) for c in wanted if c not in head]):
        raise Refused(f"{path.name} has no column {unknown[0]}", nearest(unknown[0], head))
    if len(rows) < count:
        raise Refused(f"{path.name} has {len(rows)} rows for {count} copies")
    values: list[Any] = []
    for number, row in enumerate(rows[:count], 2 if head else 1):
        try:
            cells = [float(row[chosen(c)]) for c in wanted] if chosen else [float(c) for c in row]
        except (ValueError, IndexError):
            raise Refused(f"row {number} of {path.name} is not all numbers") from None
        values.append(cells[0] if len(cells) == 1 else cells)
    return values


def _random(rule: Mapping[str, Any], count: int, name: str) -> list[Any]:
    kind, seed = rule["random"], rule["seed"]
    if not isinstance(kind, str) or kind not in RANDOM:
        raise Refused(f"{kind!r} is not a distribution", f"supported: {', '.join(RANDOM)}")
    if not isinstance(seed, int) or isinstance(seed, bool):
        raise Refused(f"the seed is {seed!r}, not an integer")
    wanted = set(RANDOM[kind])
    if wanted != rule.keys() - {"random", "seed"}:
        needs = f"needs {' and '.join(RANDOM[kind])}" if wanted else "needs only the seed"
        raise Refused(f"{kind} {needs}")
    draws = [random.Random(f"{seed}/{name}/{number}") for number in range(1, count + 1)]
    if kind == "uniform":
        return [_each_element(rule["low"], rule["high"], _uniform(d)) for d in draws]
    if kind == "normal":
        return [_each_element(rule["mean"], rule["sigma"], _normal(d)) for d in draws]
    return [_unit(d, 4 if kind == "attitude" else 3) for d in draws]


def _each_element(one: Any, other: Any, draw: Callable[[float, float], float]) -> Any:
    if isinstance(one, list) and isinstance(other, list) and len(one) == len(other):
        return [_each_element(a, b, draw) for a, b in zip(one, other, strict=True)]
    if not _number(one) or not _number(other):
        raise Refused("the two values must be numbers, or arrays of one shape")
    return draw(one, other)


def _uniform(generator: random.Random) -> Callable[[float, float], float]:
    return lambda low, high: low + (high - low) * generator.random()


def _normal(generator: random.Random) -> Callable[[float, float], float]:
    """Box and Muller's: from ``random()`` alone, whose numbers Python promises to keep."""

    def draw(mean: float, sigma: float) -> float:
        radius = math.sqrt(-2.0 * math.log(1.0 - generator.random()))
        return mean + sigma * radius * math.cos(2.0 * math.pi * generator.random())

    return draw


def _unit(generator: random.Random, size: int) -> list[float]:
    draw = _normal(generator)
    vector = [draw(0.0, 1.0) for _ in range(size)]
    length = math.sqrt(sum(v * v for v in vector))
    return [v / length for v in vector]


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _are_numbers(cells: list[str]) -> bool:
    try:
        return bool([float(c) for c in cells])
    except ValueError:
        return False
