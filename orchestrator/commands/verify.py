"""``sightline verify``: the test bench for FMUs."""

from __future__ import annotations

import os
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import closing, contextmanager
from os.path import isdir, isfile, samefile  # which answer for whatever is no path, too
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..errors import nearest
from ..exit_codes import DONE, FAILED, MISUSED
from .terminal import console as terminal


def verify(
    files: Sequence[Path], junit: Path | None, only: Sequence[str], reference: Path | None,
    seed: int, thorough: bool,
) -> int:  # fmt: skip
    """Check FMU files and print a report of each, with progress on a terminal; the exit code."""
    from ...fmus.verify import render
    from ...fmus.verify.bench import ARCHIVE, Options, planned
    from ...fmus.verify.bench import verify as run
    from ...fmus.verify.findings import CheckResult, visible
    from ...fmus.verify.registry import FAMILIES, checks

    errors = terminal(stderr=True)
    names = [*checks(), *FAMILIES, ARCHIVE]
    problems = [f"there is no file {visible(str(f))}" for f in files if not isfile(f)]
    problems += [f"--only {n}: there is no such check; {nearest(n, names)}"
                 for n in only if n not in names]
    if reference and not isfile(reference):
        problems.append(f"--reference: there is no file {reference}")
    if reference and len(files) > 1:
        problems.append("--reference: give one FMU with it")
    if junit and not isdir(junit.parent):
        problems.append(f"--junit: there is no folder {junit.parent}")
    if junit and any(isfile(f) and isfile(junit) and samefile(f, junit) for f in files):
        problems.append(f"--junit: {junit} is an FMU to be verified")
    if problems:
        errors.print("\n".join(problems), markup=False)
        return MISUSED
    console = terminal()
    options = Options(only, reference, seed, 20.0 if thorough else 1.0)
    reports = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
               TimeElapsedColumn())
    try:
        with Progress(*columns, console=console, transient=True,
                      disable=not console.is_terminal) as progress:
            task = progress.add_task("", total=1 + len(planned(only)))

            def begin(file: Path, check: str) -> None:
                if check == ARCHIVE:
                    progress.reset(task)
                progress.update(task, description=f"{visible(file.name)}  {check:<25}")

            def show(result: CheckResult) -> None:
                _say(console, render.line(result))
                progress.advance(task)

            with _terminable(), closing(run(files, options, show, on_start=begin)) as reports_of:
                for report in reports_of:
                    _say(console, render.summary(report))
                    reports.append(report)
    except _Unwritable as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for what is left to flush
        errors.print(f"cannot write the report: {error}", markup=False)
        return FAILED
    if junit:
        try:
            junit.write_bytes(render.junit(reports))
        except OSError as error:
            errors.print(f"--junit: cannot write {junit}: {error.strerror}", markup=False)
            return FAILED
    return DONE if all(r.passed for r in reports) else FAILED


class _Unwritable(Exception):
    """The report cannot be printed; the text says why."""


def _say(console: Console, text: str) -> None:
    """Print a part of the report. Raises _Unwritable, BrokenPipeError."""
    try:
        console.print(text, markup=False)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _Unwritable(error.strerror) from None


@contextmanager
def _terminable() -> Iterator[None]:
    """Let SIGTERM and SIGHUP interrupt as Ctrl-C does, so that nothing is left behind."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    numbers = [getattr(signal, n) for n in ("SIGTERM", "SIGHUP") if hasattr(signal, n)]
    before = {n: signal.signal(n, signal.default_int_handler) for n in numbers}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
