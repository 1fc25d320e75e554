"""Reads a config from TOML: base files, merging, command-line values, and all problems at once."""

from __future__ import annotations

import copy
import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ValidationError

from . import toml_text
from .config import CONNECTION, Config, Instance, Plot, Record, Simulation, inconsistencies
from .errors import ConfigError, Problem, nearest

TABLES: Mapping[str, type[BaseModel]] = {
    "simulation": Simulation,
    "instances": Instance,
    "record": Record,
    "plots": Plot,
}
STOPGAPS = {  # stand in for what is missing or wrong while the rest is checked
    "simulation": {"stop_time": 1.0, "step": 1.0},
    "stop_time": 1.0,
    "step": 1.0,
    "title": "",
    "signals": ["*"],
}


@dataclass(frozen=True)
class Loaded:
    """A config with the texts that it came from, its folder and the merged data."""

    config: Config
    folder: Path
    data: Mapping[str, Any]
    texts: tuple[tuple[str, str], ...] = ()  # file and text, the most derived file first

    @property
    def text(self) -> str:
        """The merged config as TOML."""
        return toml_text.dump(self.data)

    def place(self, problem: Problem, path: Sequence[str | int] = ()) -> Problem:
        """A problem with the line of the file that says it, as far as it can be found."""
        return _place(problem, path, self.texts)


@dataclass
class _Merged:
    data: dict[str, Any]
    texts: list[tuple[str, str]] = field(default_factory=list)


def load(path: Path) -> tuple[Loaded, list[Problem]]:
    """Read a config, and every problem of its form; what is wrong is left out of it.

    Raises ConfigError if the file cannot be read, or so much is wrong that nothing is left.
    """
    merged = _read(path, seen=())
    return check(merged.data, path.parent, tuple(merged.texts))


def check(
    data: Mapping[str, Any], folder: Path, texts: tuple[tuple[str, str], ...] = ()
) -> tuple[Loaded, list[Problem]]:
    """Plain data as a config, and every problem of its form. Raises ConfigError as ``load``."""
    rest = copy.deepcopy(dict(data))
    problems: dict[tuple[str | int, ...], Problem] = {}
    while True:
        try:
            config = Config.model_validate(rest)
            break
        except ValidationError as error:
            before = copy.deepcopy(rest)
            for found in reversed(error.errors(include_url=False)):
                path = tuple(p for p in found["loc"] if p != "[key]")
                problems.setdefault(path, _problem(dict(found), path, texts))
                _repair(rest, path, missing=found["type"] == "missing")
            if rest == before:
                raise ConfigError(list(problems.values())) from None
    found_problems = list(problems.values())
    for path, what, remedy in inconsistencies(config):
        problem = Problem(".".join(str(p) for p in path), what, remedy)
        found_problems.append(_place(problem, path, texts))
    return Loaded(config, folder, data, texts), found_problems


def _repair(data: Any, path: tuple[str | int, ...], missing: bool) -> None:
    """Take out what is wrong, or put in what is missing, so that the rest can be checked."""
    for key in path[:-1]:
        data = data[key]
    last: Any = path[-1] if path else None
    if missing and last in STOPGAPS:
        data[last] = copy.deepcopy(STOPGAPS[last])
    elif not missing and (isinstance(data, list) or last in data):
        del data[last]


def _read(path: Path, seen: tuple[Path, ...]) -> _Merged:
    name = str(path)
    if path.resolve() in seen:
        raise ConfigError([Problem("extends", "a file extends itself", file=name)])
    try:
        text = path.read_text(encoding="utf-8")
        data = tomllib.loads(text)
    except FileNotFoundError:
        remedy = nearest(path.name, [p.name for p in path.parent.glob("*.toml")], "in that folder")
        raise ConfigError([Problem("config", f"there is no file {name}", remedy)]) from None
    except (OSError, UnicodeDecodeError) as error:
        raise ConfigError([Problem("config", f"cannot be read: {error}", file=name)]) from None
    except tomllib.TOMLDecodeError as error:
        raise ConfigError([Problem("config", f"is not TOML: {error}", file=name)]) from None
    base_name = data.get("extends")
    if not isinstance(base_name, str):
        return _Merged(data, [(name, text)])
    base_path = path.parent / base_name
    if not base_path.is_file():
        where = Problem("extends", f"there is no file {base_path}")
        raise ConfigError([_place(where, ["extends"], [(name, text)])])
    base = _read(base_path, (*seen, path.resolve()))
    _rebase(base.data, os.path.relpath(base_path.parent, path.parent))
    del data["extends"]
    return _Merged(_merge(base.data, data), [(name, text), *base.texts])


def _rebase(data: dict[str, Any], folder: str) -> None:
    """Write the base's relative paths as seen from the file that extends it."""
    instances = data.get("instances")
    for table in instances.values() if isinstance(instances, dict) else ():
        if not isinstance(table, dict):
            continue
        for key in ("fmu", "component"):
            named = table.get(key)
            is_path = key == "fmu" or (isinstance(named, str) and ".py:" in named)
            if isinstance(named, str) and is_path and not os.path.isabs(named):
                table[key] = os.path.normpath(os.path.join(folder, named)).replace(os.sep, "/")


def _merge(base: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
    merged = _overlay(base, data)
    old, new = base.get("connections"), data.get("connections")
    if isinstance(old, list) and isinstance(new, list):
        driven = {d for c in new if (d := _destination(c))}
        kept = [c for c in old if not _replaced(_destination(c), driven)]
        merged["connections"] = kept + new
    return merged


def _overlay(base: dict[str, Any], data: dict[str, Any]) -> dict[str, Any]:
    merged = dict(base)
    for key, value in data.items():
        old = merged.get(key)
        both = isinstance(old, dict) and isinstance(value, dict)
        merged[key] = _overlay(old, value) if both else value  # type: ignore[arg-type]
    for one, other in (("component", "fmu"), ("fmu", "component")):
        if one in data and other in base and other not in data:
            del merged[other]  # an instance changes its origin
    return merged


def _destination(connection: Any) -> str:
    match = CONNECTION.match(connection) if isinstance(connection, str) else None
    return f"{match['destination']}.{match['input']}" if match else ""


def _replaced(destination: str, driven: set[str]) -> bool:
    return destination in driven or destination.partition("[")[0] in driven


def _problem(
    error: dict[str, Any], path: tuple[str | int, ...], texts: Sequence[tuple[str, str]]
) -> Problem:
    where = ".".join(str(p) for p in path) or "config"
    kind, context = error["type"], error.get("ctx", {})
    remedy = ""
    if kind == "extra_forbidden":
        what = "unknown key"
        remedy = nearest(str(path[-1]), _keys_at(path[:-1]))
    elif kind == "missing":
        what = "is missing"
    elif kind == "literal_error":
        what = f"{error['input']!r} is not supported"
        remedy = f"supported: {context['expected']}"
    elif kind == "string_pattern_mismatch":
        what = f"{error['input']!r} is not a name"
        remedy = "use letters, digits, _ and -"
    else:
        what = error["msg"][0].lower() + error["msg"][1:]
        if not isinstance(error["input"], dict | list):
            what += f", found {error['input']!r}"
    return _place(Problem(where, what, remedy), path, texts)


def _keys_at(path: Sequence[str | int]) -> list[str]:
    model = TABLES[str(path[0])] if path else Config
    return list(model.model_fields)


def _place(
    problem: Problem, path: Sequence[str | int], texts: Sequence[tuple[str, str]]
) -> Problem:
    """Where a key (or, for a connection, its text) stands; the most derived file first."""
    found: list[tuple[int, str, int]] = []
    for name, text in texts:
        if len(path) == 2 and path[0] == "connections" and isinstance(path[1], str):
            line = toml_text.line_with(text, f'"{path[1]}"')
            place = (line, 2) if line is not None else None
        else:
            place = toml_text.find(text, path)
        if place is not None:
            found.append((place[1], name, place[0]))
    if not found:
        return problem.at(texts[0][0], None) if texts else problem
    best = max(found, key=lambda f: f[0])
    return problem.at(best[1], best[2])
