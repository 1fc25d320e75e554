"""From a config to what runs: FMUs built and read, values from outside put into their tables."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .config.loading import Loaded, check
from .errors import FmuError, Problem, nearest
from .fmi import archive
from .fmi.description import FmuDescription
from .wiring.values import names_of, table_of

Say = Callable[[str], None]


def fmus_of(loaded: Loaded, say: Say) -> tuple[dict[str, FmuDescription], list[Problem]]:
    """Each instance's FMU, read once per file; and what is wrong with those that are lacking."""
    files: dict[str, Path] = {}
    problems: list[Problem] = []
    instances = loaded.config.instances
    if any(i.builds is not None for i in instances.values()):
        from .building import build_all

        files, problems = build_all(loaded, say)
    files |= {n: loaded.folder / i.file for n, i in instances.items() if i.file is not None}
    known: dict[Path, FmuDescription | FmuError] = {}
    fmus = {}
    for name in (n for n in instances if n in files):
        path = files[name]
        if path not in known:
            known[path] = _read(path)
        found = known[path]
        if isinstance(found, FmuDescription):
            fmus[name] = found
        else:
            where = ("instances", name, "fmu")
            what = Problem(".".join(where), f"{found.file} {found.problem}", found.remedy)
            problems.append(loaded.place(what, where))
    return fmus, problems


def _read(path: Path) -> FmuDescription | FmuError:
    try:
        return archive.read(path)
    except FmuError as error:
        return error


def override(
    loaded: Loaded, fmus: Mapping[str, FmuDescription], overrides: Mapping[str, Any]
) -> tuple[Loaded, list[Problem]]:
    """The config with values put into ``parameters`` or ``start``, whichever has the name."""
    problems = []
    own = loaded.data.get("instances", {})
    known = loaded.config.instances
    instances = {n: dict(table) for n, table in own.items() if isinstance(table, dict)}
    for key, value in overrides.items():
        where = f"--set {key}"
        instance, _, name = key.partition(".")
        if instance not in known:
            what = f"there is no instance {instance}"
            problems.append(Problem(where, what, nearest(instance, known, "instances")))
        elif instance in fmus:
            table = table_of(fmus[instance], name)
            if table is None:
                what = f"{instance} has no parameter or start value {name}"
                names = [n for t in ("parameters", "start") for n in names_of(fmus[instance], t)]
                problems.append(Problem(where, what, nearest(name, names, "valid")))
            else:
                mine = instances.setdefault(instance, {})  # a copy gets a table of its own
                held = mine.get(table)
                mine[table] = {**(held if isinstance(held, dict) else {}), name: value}
    checked, _ = check({**loaded.data, "instances": instances}, loaded.folder, loaded.texts)
    return checked, problems  # what else is wrong has been found before
