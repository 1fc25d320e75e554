"""Reads a config file and merges it over the files that it extends."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..errors import ConfigError, Problem, nearest
from . import toml_text
from .model import CONNECTION
from .parsing import parse

LARGEST = 16_000_000  # characters of a config


@dataclass
class Merged:
    """Plain data, and the texts that it came from: file and text, the most derived file first."""

    data: dict[str, Any]
    texts: list[tuple[str, str]] = field(default_factory=list)


def read(path: Path, seen: tuple[Path, ...] = ()) -> Merged:
    """Read a config and the files that it extends. Raises ConfigError."""
    name = str(path)
    if (own := Path(os.path.realpath(path))) in seen:
        raise ConfigError([Problem("extends", "a file extends itself", file=name)])
    try:
        text = _text(path)
        data = parse(text)
    except FileNotFoundError:
        remedy = nearest(path.name, [p.name for p in path.parent.glob("*.toml")], "in that folder")
        raise ConfigError([Problem("config", f"there is no file {name}", remedy)]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError([Problem("config", f"cannot be read: {error}", file=name)]) from None
    except ValueError as error:
        raise ConfigError([Problem("config", f"is not TOML: {error}", file=name)]) from None
    base_name = data.get("extends")
    if not isinstance(base_name, str):
        return Merged(data, [(name, text)])
    base_path = path.parent / base_name
    if not os.path.isfile(base_path):
        found = toml_text.find(text, ["extends"])
        problem = Problem("extends", f"there is no file {base_path}")
        raise ConfigError([problem.at(name, found[0] if found else None)])
    base = read(base_path, (*seen, own))
    _rebase(base.data, os.path.relpath(base_path.parent, path.parent))
    del data["extends"]
    return Merged(_merge(base.data, data), [(name, text), *base.texts])


def _text(path: Path) -> str:
    """A text file, whether or not it begins with a mark of its encoding."""
    with path.open(encoding="utf-8-sig") as file:
        text = file.read(LARGEST + 1)
    if len(text) > LARGEST:
        raise OSError(f"it has more than {LARGEST} characters")
    return text


def _rebase(data: dict[str, Any], folder: str) -> None:
    """Write the base's relative paths as seen from the file that extends it."""
    for level in (data, *_tables(data.get("repeat"))):
        for table in _tables(level.get("instances")):
            for key in ("fmu", "component"):
                named = table.get(key)
                is_path = key == "fmu" or (isinstance(named, str) and ".py:" in named)
                if isinstance(named, str) and is_path and not os.path.isabs(named):
                    table[key] = _moved(folder, named)
            for values in (table.get("parameters"), table.get("start")):
                for rule in _tables(values):
                    if isinstance(rule.get("file"), str):
                        rule["file"] = _moved(folder, rule["file"])


def _tables(table: Any) -> list[dict[str, Any]]:
    """The tables in a table, as far as the data have this form."""
    values = table.values() if isinstance(table, dict) else ()
    return [v for v in values if isinstance(v, dict)]


def _moved(folder: str, path: str) -> str:
    return os.path.normpath(os.path.join(folder, path)).replace(os.sep, "/")


def _merge(base: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
    merged = overlay(base, data)
    olds, news = base.get("repeat"), data.get("repeat")
    if isinstance(olds, dict) and isinstance(news, dict):
        for index in olds.keys() & news.keys():
            if isinstance(olds[index], dict) and isinstance(news[index], dict):
                merged["repeat"][index] = _merge(olds[index], news[index])
    old, new = base.get("connections"), data.get("connections")
    if isinstance(old, list) and isinstance(new, list):
        driven = {d for c in new if (d := _destination(c))}
        kept = [c for c in old if not _replaced(_destination(c), driven)]
        merged["connections"] = kept + new
    return merged


def overlay(base: Mapping[str, Any], data: Mapping[str, Any]) -> dict[str, Any]:
    """A table with the keys of another over its own, table within table."""
    merged = dict(base)
    for key, value in data.items():
        old = merged.get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        merged[key] = overlay(old, value) if both else value  # type: ignore[arg-type]
    for one, other in (("component", "fmu"), ("fmu", "component")):
        if one in data and other in base and other not in data:
            del merged[other]  # an instance changes its origin
    return merged


def _destination(connection: Any) -> str:
    match = CONNECTION.match(connection) if isinstance(connection, str) else None
    return f"{match['destination']}.{match['input']}" if match else ""


def _replaced(destination: str, driven: set[str]) -> bool:
    return destination in driven or destination.partition("[")[0] in driven
