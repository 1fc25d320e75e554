"""Templates: instances and connections written once for the copy ``{i}`` and repeated.

    [repeat.i]
    count = 10
    connections = ["craft{i}.attitude -> control{i+1}.neighbour_attitude"]

    [repeat.i.instances."craft{i}"]
    component = "RigidRotation"
    start = { attitude = { random = "attitude", seed = 1 } }

``{i+1}`` of the last copy is the first with ``neighbours = "ring"``; with ``"open"`` a connection
that names a copy outside 1 to ``count`` is left out. Values per copy: see :mod:`.spread`. A table
``[instances.craft3]`` of its own overlays the third copy.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ..alike import without_numbers
from ..errors import Problem
from .merging import overlay
from .model import Repeat, Repeats
from .spread import Refused, spread, written_out

PLACE = re.compile(r"\{\s*(?P<index>[A-Za-z_]\w*)\s*(?P<offset>[+-]\s*\d{1,9})?\s*\}")

Path_ = tuple[str | int, ...]
Origins = dict[Path_, Path_]  # where in a template a repeated instance or connection stands


@dataclass
class Expansion:
    """A config's data with all copies written out, and what is wrong with its templates.

    ``read``: what stands in files, as rules that hold the values themselves.
    """

    data: dict[str, Any]
    origins: Origins = field(default_factory=dict)
    read: dict[Path_, dict[str, Any]] = field(default_factory=dict)
    problems: list[tuple[Path_, str, str]] = field(default_factory=list)


def expand(data: Mapping[str, Any], templates: Repeats, folder: Path) -> Expansion:
    """Write out every copy. ``templates``: those of ``data``, their form checked."""
    result = Expansion(dict(data))
    if not templates.repeat:
        return result
    copies = _Copies(result, folder)
    for index, template in templates.repeat.items():
        copies.repeat(index, template)
    own = data.get("instances", {})
    if isinstance(own, dict):
        result.data["instances"] = overlay(copies.instances, own)
    connections = data.get("connections", [])
    if isinstance(connections, list):
        result.data["connections"] = [*connections, *copies.connections]
    return result


def collapse(problems: Iterable[Problem]) -> list[Problem]:
    """One problem of a line for all its copies, which differ in numbers only."""
    groups: dict[tuple[object, ...], list[Problem]] = {}
    for number, problem in enumerate(problems):
        words = without_numbers(f"{problem.where}|{problem.what}|{problem.remedy}")
        key = (problem.file, problem.line, words) if problem.line is not None else (number,)
        groups.setdefault(key, []).append(problem)
    return [
        group[0] if len(set(group)) == 1
        else replace(group[0], what=f"{group[0].what} (the first of {len(set(group))} alike)")
        for group in groups.values()
    ]


class _Copies:
    """Collects the copies of all templates."""

    def __init__(self, result: Expansion, folder: Path) -> None:
        self.result = result
        self.folder = folder
        self.instances: dict[str, Any] = {}
        self.connections: list[str] = []

    def repeat(self, index: str, template: Repeat) -> None:
        """Write out the copies of one template."""
        root: Path_ = ("repeat", index)
        named = {
            name: self._values(index, name, table, template)
            for name, table in template.instances.items()
            if self._sound((*root, "instances", name), name, index)
        }
        texts = [
            text for text in template.connections
            if self._sound((*root, "connections", text), text, index)
        ]  # fmt: skip
        for number in range(1, template.count + 1):
            filler = _Filler(index, number, template)
            for name, tables in named.items():
                self._instance((*root, "instances", name), filler, tables[number - 1])
            for text in texts:
                filled = filler.text(text)
                if filled is not None:
                    self.connections.append(filled)
                    self.result.origins[("connections", filled)] = (*root, "connections", text)

    def _sound(self, path: Path_, text: str, index: str) -> bool:
        """Whether a name or connection differs from copy to copy, by this index alone."""
        found = {match["index"] for match in PLACE.finditer(text)}
        if index not in found:
            remedy = f"put {{{index}}} into it, or take it out of the template"
            self._report(path, "is the same for every copy", remedy)
        elif strange := found - {index}:
            what = f"{{{min(strange)}}} is not the index of this template"
            self._report(path, what, f"{{{index}}} is")
        return found == {index}

    def _report(self, path: Path_, what: str, remedy: str) -> None:
        self.result.problems.append((path, what, remedy))

    def _instance(self, path: Path_, filler: _Filler, table: Mapping[str, Any]) -> None:
        name = filler.text(str(path[-1]))
        if name is None:  # an offset beyond the end of an open row
            return
        if name in self.instances:
            other = ".".join(str(p) for p in self.result.origins[("instances", name)])
            self._report(path, f"{name} is named by {other} too", "")
            return
        self.instances[name] = filler.all(table)
        self.result.origins[("instances", name)] = path

    def _values(
        self, index: str, name: str, table: Mapping[str, Any], template: Repeat
    ) -> list[dict[str, Any]]:
        """The template's table for each copy, with the values of that copy."""
        tables = [copy.deepcopy(dict(table)) for _ in range(template.count)]
        for key in ("parameters", "start"):
            values = table.get(key)
            for port, rule in values.items() if isinstance(values, dict) else ():
                if not isinstance(rule, dict):
                    continue
                path = ("repeat", index, "instances", name, key, port)
                try:
                    column = spread(rule, template.count, self.folder, f"{name}.{port}")
                except Refused as refused:
                    self._report(path, refused.what, refused.remedy)
                    for one in tables:
                        del one[key][port]
                else:
                    if "file" in rule:
                        self.result.read[path] = written_out(rule, column)
                    for one, value in zip(tables, column, strict=True):
                        one[key][port] = value
        return tables


class _Filler:
    """Puts the number of a copy in place of ``{i}``, ``{i+1}``, ``{i-1}``."""

    def __init__(self, index: str, number: int, template: Repeat) -> None:
        self.index = index
        self.number = number
        self.count = template.count
        self.ring = template.neighbours == "ring"

    def text(self, text: str) -> str | None:
        """A text filled in; None if it names a copy beyond the end of an open row."""
        numbers = [self._number(m) for m in PLACE.finditer(text) if m["index"] == self.index]
        if not self.ring and not all(1 <= n <= self.count for n in numbers):
            return None
        return PLACE.sub(
            lambda m: str(self._number(m)) if m["index"] == self.index else m[0], text
        )

    def all(self, data: Any) -> Any:
        """Data with every text in it filled in."""
        if isinstance(data, str):
            filled = self.text(data)
            return data if filled is None else filled
        if isinstance(data, dict):
            return {key: self.all(value) for key, value in data.items()}
        if isinstance(data, list):
            return [self.all(value) for value in data]
        return data

    def _number(self, match: re.Match[str]) -> int:
        number = self.number + int((match["offset"] or "0").replace(" ", ""))
        return (number - 1) % self.count + 1 if self.ring else number
