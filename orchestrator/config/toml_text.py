"""TOML as text: writes plain data as TOML, and finds the line that says a given key."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

BARE = re.compile(r"^[A-Za-z0-9_-]+$")
TABLE = re.compile(r"^\s*\[\s*(?P<name>[^\[\]]+?)\s*\]")
ARRAY_OF_TABLES = re.compile(r"^\s*\[\[\s*(?P<name>[^\[\]]+?)\s*\]\]")
KEY = re.compile(r"""^\s*(?P<key>[A-Za-z0-9_."'\- ]+?)\s*=""")


def dump(data: Mapping[str, Any]) -> str:
    """Plain data as TOML; tables nest to two levels (templates to four), what is deeper inline."""
    lines = [f"{_key(k)} = {value(v)}" for k, v in data.items() if not _table(v)]
    for key, table in data.items():
        if isinstance(table, Mapping):
            lines += _table_lines(_key(key), table, depth=4 if key == "repeat" else 2)
        elif _table(table):
            for row in table:
                lines += ["", f"[[{_key(key)}]]"]
                lines += [f"{_key(k)} = {value(v)}" for k, v in row.items()]
    return "\n".join(lines).strip() + "\n"


def value(data: Any) -> str:
    """One value as TOML."""
    if isinstance(data, bool):
        return "true" if data else "false"
    if isinstance(data, float):
        return repr(data) if math.isfinite(data) else str(data)
    if isinstance(data, int):
        return str(data)
    if isinstance(data, str):
        return json.dumps(data, ensure_ascii=False)
    if isinstance(data, Mapping):
        inside = ", ".join(f"{_key(k)} = {value(v)}" for k, v in data.items())
        return f"{{ {inside} }}" if inside else "{}"
    rows = [value(v) for v in data]
    if len(rows) > 4 and all(isinstance(v, str) for v in data):
        return "[\n" + "".join(f"  {row},\n" for row in rows) + "]"
    return f"[{', '.join(rows)}]"


def find(text: str, path: Sequence[str | int]) -> tuple[int, int] | None:
    """Line (from 1) and depth of the deepest key of ``path`` that the text contains.

    Best effort: it knows tables, dotted keys and keys inside inline tables; an integer counts
    the tables of an array. The last key of a path to ``connections`` is a connection's text.
    """
    if len(path) > 1 and path[-2] == "connections" and isinstance(path[-1], str):
        line = line_with(text, f'"{path[-1]}"')
        return None if line is None else (line, len(path))
    keys = _keys(text)
    for depth in range(len(path), 0, -1):
        head = tuple(str(p) for p in path[:depth])
        if head in keys:
            line, more = _inside(text, keys[head], [str(p) for p in path[depth:]])
            return line, depth + more
    return None


def line_with(text: str, fragment: str) -> int | None:
    """The first line that contains a fragment, spaces and the kind of quotes aside."""
    wanted = "".join(fragment.split())
    for number, line in enumerate(text.splitlines(), 1):
        if wanted and wanted in "".join(line.replace("'", '"').split()):
            return number
    return None


def _keys(text: str) -> dict[tuple[str, ...], int]:
    keys: dict[tuple[str, ...], int] = {}
    counts: dict[str, int] = {}
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.splitlines(), 1):
        if match := ARRAY_OF_TABLES.match(line):
            name = match["name"]
            table = (*_split(name), str(counts.setdefault(name, 0)))
            counts[name] += 1
            keys.setdefault(table[:-1], number)
        elif match := TABLE.match(line):
            table = _split(match["name"])
        elif match := KEY.match(line):
            keys.setdefault((*table, *_split(match["key"])), number)
            continue
        else:
            continue
        for depth in range(1, len(table) + 1):
            keys.setdefault(table[:depth], number)
    return keys


def _inside(text: str, number: int, names: Sequence[str]) -> tuple[int, int]:
    """Line and count of those of ``names`` that are keys of the value that starts on a line."""
    lines = text.splitlines()
    found = 0
    for name in names:
        for later in range(number, len(lines) + 1):
            line = lines[later - 1]
            if later > number and (TABLE.match(line) or ARRAY_OF_TABLES.match(line)):
                break
            if re.search(rf"(?<![\w.-])[\"']?{re.escape(name)}[\"']?\s*=", line):
                number, found = later, found + 1
                break
    return number, found


def _split(name: str) -> tuple[str, ...]:
    return tuple(part.strip().strip("\"'") for part in name.split("."))


def _key(name: str) -> str:
    return name if BARE.match(name) else json.dumps(name, ensure_ascii=False)


def _table(data: Any) -> bool:
    rows = isinstance(data, list) and bool(data) and all(isinstance(v, Mapping) for v in data)
    return isinstance(data, Mapping) or rows


def _table_lines(name: str, table: Mapping[str, Any], depth: int) -> list[str]:
    nested = {k: v for k, v in table.items() if isinstance(v, Mapping)} if depth > 1 else {}
    if depth == 2 and len(nested) < len(table):
        nested = {}
    lines = [f"{_key(k)} = {value(v)}" for k, v in table.items() if k not in nested]
    if lines or not nested:
        lines = ["", f"[{name}]", *lines]
    for key, inner in nested.items():
        lines += _table_lines(f"{name}.{_key(key)}", inner, depth - 1)
    return lines
