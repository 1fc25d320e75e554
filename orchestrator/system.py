"""A system from its config to its results: load, build, check, schedule, run.

>>> system = System.from_toml("system.toml")            # raises ConfigError with all problems
>>> results = system.run("out")                         # raises RunError
>>> results["craft1.position"]                          # array over results.time
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import archive
from . import results as results_file
from . import run as runner
from .description import FmuDescription
from .errors import ConfigError, FmuError, Problem, nearest
from .graph import SystemGraph
from .loading import Loaded, check, load
from .log import RunLog
from .plan import Plan, compile_plan
from .schedule import Schedule, schedule
from .signals import Selection, select
from .values import names_of, table_of
from .wiring import wire

Say = Callable[[str], None]


@dataclass(frozen=True)
class System:
    """A checked, scheduled system, ready to run any number of times."""

    loaded: Loaded
    graph: SystemGraph
    schedule: Schedule
    selection: Selection
    plan: Plan

    @classmethod
    def from_toml(
        cls,
        path: str | Path,
        overrides: Mapping[str, Any] | None = None,
        say: Say = lambda _: None,
    ) -> System:
        """Read, build and check a system. ``overrides``: ``instance.name`` -> value.

        Raises ConfigError with every problem that can be found.
        """
        loaded, problems = load(Path(path))
        fmus, lacking = _fmus(loaded, say)
        if overrides:
            loaded, wrong = _override(loaded, fmus, overrides)
            problems += wrong
        graph, wrong = wire(loaded, fmus)
        problems += lacking + wrong
        selection, wrong = select(loaded, graph)
        problems += [] if lacking else wrong  # a glob may mean what is lacking
        if problems:
            raise ConfigError(problems)
        order = schedule(graph, loaded.config.simulation.algorithm)
        plan = compile_plan(graph, order, selection.recorded)
        return cls(loaded, graph, order, selection, plan)

    def simulate(
        self, out: str | Path, show: Callable[[float], None] = lambda _: None
    ) -> runner.Statistics:
        """Run and write ``results.h5`` (and ``log.txt`` if an FMU says something) to a folder.

        Raises RunError, FmuError, Interrupted, OSError; rows until then are in the results.
        """
        folder = Path(out)
        config = self.loaded.config
        rows = config.simulation.steps // config.record_stride + 1
        with results_file.ResultsWriter(
            folder, self.graph, self.selection.recorded, self.loaded.text, rows
        ) as writer:
            log = RunLog(folder / "log.txt")
            return runner.run(
                self.graph, self.plan, config.simulation, config.record_stride, writer, log, show
            )

    def run(self, out: str | Path) -> results_file.Results:
        """Run, and read the results as arrays. Raises what :meth:`simulate` raises."""
        self.simulate(out)
        return results_file.read(Path(out) / results_file.FILE)


def _fmus(loaded: Loaded, say: Say) -> tuple[dict[str, FmuDescription], list[Problem]]:
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


def _override(
    loaded: Loaded, fmus: Mapping[str, FmuDescription], overrides: Mapping[str, Any]
) -> tuple[Loaded, list[Problem]]:
    """The config with values put into ``parameters`` or ``start``, whichever has the name."""
    problems = []
    instances = {n: dict(loaded.data["instances"][n]) for n in loaded.config.instances}
    for key, value in overrides.items():
        where = f"--set {key}"
        instance, _, name = key.partition(".")
        if instance not in instances:
            what = f"there is no instance {instance}"
            problems.append(Problem(where, what, nearest(instance, instances, "instances")))
        elif instance in fmus:
            table = table_of(fmus[instance], name)
            if table is None:
                what = f"{instance} has no parameter or start value {name}"
                names = [n for t in ("parameters", "start") for n in names_of(fmus[instance], t)]
                problems.append(Problem(where, what, nearest(name, names, "valid")))
            else:
                old = instances[instance].get(table, {})
                instances[instance][table] = {**old, name: value}
    checked, _ = check({**loaded.data, "instances": instances}, loaded.folder, loaded.texts)
    return checked, problems  # what else is wrong has been found before
