"""A config from TOML: templates repeated, values checked, and all problems at once."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from ..errors import ConfigError, Problem, nearest
from . import merging, toml_text
from .model import (
    Config,
    Instance,
    Plot,
    Record,
    Repeat,
    Repeats,
    Simulation,
    inconsistencies,
)
from .repeat import Origins, collapse, expand

Texts = Sequence[tuple[str, str]]  # file and text, the most derived file first
Key = tuple[str | int, ...]
M = TypeVar("M", bound=BaseModel)
TABLES: Mapping[str, type[BaseModel]] = {
    "simulation": Simulation,
    "instances": Instance,
    "record": Record,
    "plots": Plot,
    "repeat": Repeat,
}
STOPGAPS = {  # stand in for what is missing or wrong while the rest is checked
    "simulation": {"stop_time": 1.0, "step": 1.0},
    "stop_time": 1.0,
    "step": 1.0,
    "title": "",
    "signals": ["*"],
    "count": 1,
}


@dataclass(frozen=True)
class Loaded:
    """A config with the texts that it came from, its folder and the merged data.

    Values that stand in files of their own are in the data, so that it says all that is run.
    """

    config: Config
    folder: Path
    data: Mapping[str, Any]
    texts: Texts = ()
    origins: Origins = field(default_factory=dict)

    @property
    def text(self) -> str:
        """The merged config as TOML, templates as templates."""
        return toml_text.dump(self.data)

    def place(self, problem: Problem, path: Sequence[str | int] = ()) -> Problem:
        """A problem with the line of the file that says it, as far as it can be found."""
        return _place(problem, path, self.texts, self.origins)


def load(
    path: Path, overrides: Mapping[str, Any] | None = None, isolate: bool = False
) -> tuple[Loaded, list[Problem]]:
    """Read a config, and every problem of its form; what is wrong is left out of it.

    ``overrides``: ``simulation.step``, ``record.every`` or the count ``repeat.i`` -> value.
    ``isolate``: every instance will be isolated, whatever the config says.
    Raises ConfigError if the file cannot be read, or so much is wrong that nothing is left.
    """
    merged = merging.read(path)
    data, problems = _overridden(merged.data, overrides or {})
    loaded, found = check(data, path.parent, tuple(merged.texts), isolate)
    return loaded, problems + found


def check(
    data: Mapping[str, Any], folder: Path, texts: Texts = (), isolate: bool = False
) -> tuple[Loaded, list[Problem]]:
    """Plain data as a config, and every problem of its form. Raises ConfigError as ``load``."""
    template_data = {"repeat": data["repeat"]} if "repeat" in data else {}
    templates, problems = _validated(Repeats, template_data, texts, {})
    expansion = expand(data, templates, folder)
    for path, what, remedy in expansion.problems:
        problem = Problem(".".join(str(p) for p in path), what, remedy)
        problems.append(_place(problem, path, texts, {}))
    config, found = _validated(Config, expansion.data, texts, expansion.origins)
    problems += found
    loaded = Loaded(config, folder, _with(data, expansion.read), texts, expansion.origins)
    for path, what, remedy in inconsistencies(config, isolate):
        problem = Problem(".".join(str(p) for p in path), what, remedy)
        problems.append(loaded.place(problem, path))
    return loaded, problems


def _with(data: Mapping[str, Any], values: Mapping[Key, Any]) -> Mapping[str, Any]:
    """Data with other values at some places."""
    changed = copy.deepcopy(dict(data)) if values else data
    for path, value in values.items():
        table: Any = changed
        for key in path[:-1]:
            table = table[key]
        table[path[-1]] = value
    return changed


def _validated(
    model: type[M], data: Mapping[str, Any], texts: Texts, origins: Origins
) -> tuple[M, list[Problem]]:
    """Data as a model, repaired until it is one; what had to be repaired."""
    rest = copy.deepcopy(dict(data))
    problems: dict[Key, Problem] = {}
    while True:
        try:
            return model.model_validate(rest), list(problems.values())[::-1]
        except ValidationError as error:
            before = copy.deepcopy(rest)
            for found in reversed(error.errors(include_url=False)):
                path = tuple(p for p in found["loc"] if p != "[key]")
                problem = _problem(dict(found), path)
                problems.setdefault(path, _place(problem, path, texts, origins))
                _repair(rest, path, missing=found["type"] == "missing")
            if rest == before:
                raise ConfigError(collapse(problems.values())) from None


def _overridden(
    data: Mapping[str, Any], overrides: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem]]:
    changed = copy.deepcopy(dict(data))
    problems = []
    for key, value in overrides.items():
        table, _, name = key.partition(".")
        if table == "repeat":
            known = changed.get("repeat")
            known = known if isinstance(known, dict) else {}
            if name not in known:
                remedy = nearest(name, known, "indices")
                problems.append(Problem(f"--set {key}", f"nothing repeats over {name}", remedy))
            elif isinstance(known[name], dict):
                known[name]["count"] = value
        elif isinstance(changed.setdefault(table, {}), dict):
            changed[table][name] = value
    return changed, problems


def _repair(data: Any, path: tuple[str | int, ...], missing: bool) -> None:
    """Take out what is wrong, or put in what is missing, so that the rest can be checked."""
    for key in path[:-1]:
        data = data[key]
    last: Any = path[-1] if path else None
    if missing and last in STOPGAPS:
        data[last] = copy.deepcopy(STOPGAPS[last])
    elif not missing and (isinstance(data, list) or last in data):
        del data[last]


def _problem(error: dict[str, Any], path: Key) -> Problem:
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
        remedy = "use letters, digits and _" + ("" if path[0] == "repeat" else " or -")
    else:
        what = error["msg"][0].lower() + error["msg"][1:]
        if not isinstance(error["input"], dict | list):
            what += f", found {error['input']!r}"
    return Problem(where, what, remedy)


def _keys_at(path: Sequence[str | int]) -> list[str]:
    model = TABLES[str(path[0])] if path else Config
    return list(model.model_fields)


def _place(
    problem: Problem, path: Sequence[str | int], texts: Texts, origins: Origins
) -> Problem:
    """Where a key (or, for a connection, its text) stands; the most derived file first.

    What a template repeats stands in the template, but a table of its own comes first.
    """
    paths = [tuple(path)]
    if (template := origins.get(tuple(path[:2]))) is not None:
        paths.append((*template, *path[2:]))
    found: list[tuple[int, str, int]] = []
    for keys in paths:
        for name, text in texts:
            place = toml_text.find(text, keys)
            if place is not None:
                found.append((len(keys) - place[1], name, place[0]))
    if not found:
        return problem.at(texts[0][0], None) if texts else problem
    best = min(found, key=lambda f: f[0])
    return problem.at(best[1], best[2])
