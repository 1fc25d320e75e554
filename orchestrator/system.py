"""A system from its config to its results: load, build, check, schedule, run.

>>> system = System.from_toml("system.toml")            # raises ConfigError with all problems
>>> results = system.simulate()                         # raises RunError
>>> results["craft1.position"]                          # array over results.time
>>> results.unit("craft1.position")
'm'
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from . import run as runner
from .assembly import Say, fmus_of, override
from .config import toml_text
from .config.loading import Loaded, check, load
from .config.model import LARGEST
from .config.repeat import collapse
from .errors import ConfigError, Problem
from .fmi.log import RunLog
from .results import file as results_file
from .results.file import Results
from .schedule.order import Schedule, schedule
from .schedule.plan import Plan
from .schedule.planning import compile_plan
from .schedule.rates import DEGREES, rates_of
from .session import Parts, Session
from .stepping.keeper import Keeper, resumed
from .stepping.snapshot import identity, require_serializable
from .wiring.graph import SystemGraph
from .wiring.signals import Selection, select
from .wiring.wiring import wire

SETTABLE = ("simulation", "record", "repeat")  # tables of the config besides instances
CHECKPOINT = "checkpoint.h5"
BEFORE = "results-before.h5"  # the results of a run that is resumed in the same folder


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
        isolate: bool = False,
    ) -> System:
        """Read, build and check a system.

        ``overrides``: ``instance.name``, ``simulation.step`` or the count ``repeat.i`` -> value.
        ``isolate``: every FMU in a process of its own, as :meth:`isolated`.
        Raises ConfigError with every problem that can be found.
        """
        asked = overrides or {}
        tables = {k: v for k, v in asked.items() if k.partition(".")[0] in SETTABLE}
        loaded, problems = load(Path(path), tables, isolate)
        rest = {k: v for k, v in asked.items() if k not in tables}
        system = cls._checked(loaded, problems, rest, say)
        return system.isolated() if isolate else system

    @classmethod
    def from_data(
        cls, data: Mapping[str, Any], folder: str | Path = ".", say: Say = lambda _: None
    ) -> System:
        """Build and check a system that is given as the data of a TOML file.

        Raises ConfigError with every problem that can be found.
        """
        loaded, problems = check(data, Path(folder))
        return cls._checked(loaded, problems, {}, say)

    @classmethod
    def _checked(
        cls, loaded: Loaded, problems: list[Problem], overrides: Mapping[str, Any], say: Say
    ) -> System:
        fmus, lacking = fmus_of(loaded, say)
        if overrides:
            loaded, wrong = override(loaded, fmus, overrides)
            problems += wrong
        graph, wrong = wire(loaded, fmus)
        problems += lacking + wrong
        selection, wrong = select(loaded, graph)
        problems += [] if lacking else wrong  # a glob may mean what is lacking
        rates, wrong = rates_of(loaded, graph)
        problems += wrong
        if problems:
            raise ConfigError(collapse(problems))
        simulation = loaded.config.simulation
        order = schedule(graph, simulation.algorithm, simulation.delay)
        degree = DEGREES[simulation.coupling]
        plan = compile_plan(graph, order, selection.recorded, rates, degree)
        return cls(loaded, graph, order, selection, plan)

    def isolated(self) -> System:
        """The same system with every FMU in a process of its own."""
        nodes = tuple(replace(node, isolated=True) for node in self.graph.nodes)
        return replace(self, graph=replace(self.graph, nodes=nodes))

    def simulate(
        self,
        out: str | Path | None = None,
        *,
        checkpoint_every: float = 0.0,
        resume: str | Path | None = None,
    ) -> Results:
        """Run; the results as arrays. Without a folder nothing is left on disk.

        Raises what :meth:`execute` raises, and ValueError for checkpoints without a folder.
        """
        if out is None and checkpoint_every:
            raise ValueError("checkpoints need a folder")
        if out is None:
            with tempfile.TemporaryDirectory(prefix="sightline-") as folder:
                return self.simulate(folder, resume=resume)
        self.execute(out, checkpoint_every=checkpoint_every, resume=resume)
        return results_file.read(Path(out) / results_file.FILE)

    def execute(
        self,
        out: str | Path,
        show: Callable[[float], None] = lambda _: None,
        *,
        checkpoint_every: float = 0.0,
        resume: str | Path | None = None,
    ) -> runner.Statistics:
        """Run and write ``results.h5`` (and ``log.txt`` if an FMU says something) to a folder.

        ``checkpoint_every``: simulated seconds from one ``checkpoint.h5`` to the next; ``resume``:
        such a file, beside its results, to go on from.
        Raises ConfigError if the system cannot be saved or resumed so; RunError, FmuError,
        Interrupted, OSError; rows until then are in the results.
        """
        folder = Path(out)
        if checkpoint_every and not 1 / LARGEST <= checkpoint_every <= LARGEST:
            what = f"{checkpoint_every:g} is not from {1 / LARGEST:g} to {LARGEST:g}"
            raise ConfigError([Problem("--checkpoint-every", what)])
        keeper = self._keeper(folder, checkpoint_every, None if resume is None else Path(resume))
        config = self.loaded.config
        with results_file.ResultsWriter(
            folder, self.graph, self.selection.recorded, self.loaded.text, config.rows
        ) as writer:
            log = RunLog(folder / "log.txt")
            statistics = runner.run(
                self.graph, self.plan, config, writer, log, show, keeper
            )
        (folder / BEFORE).unlink(missing_ok=True)
        return statistics

    def start(self) -> Session:
        """A running system that the caller steps, to be used in a ``with`` statement."""
        simulation = self.loaded.config.simulation
        return Session(Parts(self.graph, self.plan, self.selection, simulation))

    def to_toml(self, path: str | Path) -> None:
        """Write the system's config. Raises OSError."""
        Path(path).write_text(self.loaded.text, encoding="utf-8")

    def _keeper(self, out: Path, every: float, resume: Path | None) -> Keeper:
        if every > 0:
            require_serializable(self.graph, "--checkpoint-every")
        system = self._identity() if every > 0 or resume else ""
        keeper = Keeper(out / CHECKPOINT, every, system=system)
        if resume is not None:
            stop = self.loaded.config.simulation.stop_time
            keeper.resumed = resumed(resume, system, self.graph.index, self.plan.size, stop)
            keeper.recorded = results_file.holding(
                [resume.parent / n for n in (results_file.FILE, BEFORE)], keeper.resumed.rows
            )
            if keeper.recorded is None:
                what = f"no {results_file.FILE} with {keeper.resumed.rows} rows is beside it"
                raise ConfigError([Problem(f"--resume {resume}", what)])
            if keeper.recorded.resolve() == (out / results_file.FILE).resolve():
                keeper.recorded = keeper.recorded.replace(out / BEFORE)
        return keeper

    def _identity(self) -> str:
        """What must not change from a checkpoint to the run that resumes it."""
        data = {k: v for k, v in self.loaded.data.items() if k != "plots"}
        simulation = dict(data.get("simulation", {}))
        simulation.pop("stop_time", None)
        return identity(self.graph, toml_text.dump({**data, "simulation": simulation}))
