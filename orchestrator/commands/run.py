"""``sightline run`` and ``sightline demo``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib.resources import as_file, files
from pathlib import Path
from textwrap import shorten
from typing import Any

from rich.console import Console

from ..alike import few
from ..config.parsing import parse
from ..errors import ConfigError, FmuError, Problem, RunError
from ..exit_codes import DONE, FAILED, MISUSED, STOPPED
from ..progress import bar
from ..results.file import FILE, read
from ..results.table import TABLE, UNITS, write_csv
from ..run import Interrupted, Statistics
from ..system import System
from .terminal import console as terminal
from .terminal import unwritable

FIGURES = ".png"  # what figures are that are named after their titles
EXAMPLE = ("los_formation", "system.toml")
LONGEST = 240  # characters of a note; matrices make longer ones
CUT = " ...; sightline explain tells all of it"


@dataclass(frozen=True)
class Checkpoints:
    """How often the system's state is kept, simulated s, and the file to go on from."""

    every: float = 0.0
    resume: Path | None = None


def run(
    config: Path, out: Path, settings: Sequence[str], csv: bool,
    checkpoints: Checkpoints = Checkpoints(), isolate: bool = False,
) -> int:  # fmt: skip
    """Run a system; the exit code."""
    console = terminal(stderr=True)

    def say(text: str) -> None:
        console.print(text, markup=False)

    try:
        system = System.from_toml(config, overrides(settings), say, isolate)
        _say_if_slow(system, say)
        graph = system.graph
        told = [f"note: {n}" for n in graph.notes] + [f"warning: {w}" for w in graph.warnings]
        for line in few(told):
            say(shorten(line, LONGEST, placeholder=CUT))
        code, left = _simulate(system, out, csv, checkpoints, console)
    except ConfigError as error:
        say(str(error))
        return MISUSED
    except FmuError as error:
        say(str(error))
        return FAILED
    except OSError as error:
        say(unwritable(out, error))
        return FAILED
    if left:
        terminal().print(left, markup=False)
    return code


def demo(out: Path, settings: Sequence[str], csv: bool) -> int:
    """Run the packaged example; the exit code."""
    with as_file(files("sightline.examples").joinpath(EXAMPLE[0])) as folder:
        return run(folder / EXAMPLE[1], out, settings, csv)


def overrides(settings: Sequence[str]) -> dict[str, Any]:
    """Values of ``--set``. Raises ConfigError for text that is not ``instance.name=value``."""
    values: dict[str, Any] = {}
    problems = []
    for setting in settings:
        key, equals, text = (part.strip() for part in setting.partition("="))
        where = f"--set {setting}"
        if not equals or "." not in key:
            problems.append(Problem(where, "is not of the form instance.name=value"))
            continue
        try:
            (values[key],) = parse(f"value = {text}").values()
        except ValueError:
            remedy = 'write numbers 1.5, arrays [1, 2], true, false, or "text"'
            problems.append(Problem(where, f"{text!r} is not a value", remedy))
    if problems:
        raise ConfigError(problems)
    return values


def _simulate(
    system: System, out: Path, csv: bool, checkpoints: Checkpoints, console: Console
) -> tuple[int, str]:
    """The exit code, and the line that says what there is now."""
    simulation = system.loaded.config.simulation
    ending, code, writable = "", DONE, True
    statistics: Statistics | None = None
    try:
        with bar(simulation.start_time, simulation.stop_time, console) as show:
            statistics = system.execute(
                out, show, checkpoint_every=checkpoints.every, resume=checkpoints.resume
            )
    except RunError as error:
        ending, code = "\n".join([str(error), *getattr(error, "__notes__", ())]), FAILED
    except Interrupted as error:
        ending, code = f"interrupted: {error}", STOPPED
    except BlockingIOError:
        raise  # what is there is another run's
    except OSError as error:
        ending, code, writable = unwritable(out, error), FAILED, False
    if ending:
        console.print(ending, markup=False)
    if statistics is not None and not statistics.rested:
        console.print(
            "warning: outputs did not come to rest at the start; the system may have an "
            "algebraic loop", markup=False,
        )
    if statistics is not None and simulation.adaptive:
        taken = f"{statistics.steps} steps accepted, {statistics.rejected} rejected"
        console.print(taken, markup=False)
    if writable:
        return code, _report(system, out, csv, code, console)
    if (samples := _samples(out)) > 0:
        console.print(f"results until then in {out}: {FILE} ({samples} samples)", markup=False)
    return code, ""


def _samples(out: Path) -> int:
    """How many samples a run left that did not reach its end."""
    try:
        results = read(out / FILE)
    except OSError:
        return 0
    return 0 if results.complete else len(results.time)


def _report(system: System, out: Path, csv: bool, code: int, console: Console) -> str:
    """Draw and tabulate what there is; the line that says where it is."""
    plots = system.loaded.config.plots
    for earlier in (TABLE, UNITS, *(plot.file_name(FIGURES) for plot in plots)):
        (out / earlier).unlink(missing_ok=True)  # of a run whose results are gone
    results = read(out / FILE)
    if not len(results.time):
        console.print(f"nothing recorded; messages in {out / 'log.txt'}", markup=False)
        return ""
    parts = [f"{FILE} ({len(results.time)} samples of {len(results.series)} signals)"]
    if csv:
        parts += [p.name for p in write_csv(out / FILE, system.selection.recorded)]
    if plots and len(results.time) > 1:
        from ..results.plots import draw

        parts += [p.name for p in draw(out, plots, results, FIGURES)]
    if (out / "log.txt").exists():
        parts.append("log.txt")
    state = "results" if code == DONE else "results until then"
    return f"{state} in {out}: {', '.join(parts)}"


def _say_if_slow(system: System, say: Any) -> None:
    instances = system.loaded.config.instances.values()
    if not any(i.component is not None and i.target is None for i in instances):
        return
    from ..building import compiler_missing

    if compiler_missing():
        say("no C compiler found: the FMUs run in Python, correct but slower")
