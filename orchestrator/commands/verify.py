"""``sightline verify``: the test bench for FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from os.path import isdir, isfile  # which answer for whatever is no path, too
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from ..errors import nearest
from ..exit_codes import DONE, FAILED, MISUSED


def verify(
    files: Sequence[Path], junit: Path | None, only: Sequence[str], reference: Path | None,
    seed: int, thorough: bool,
) -> int:  # fmt: skip
    """Check FMU files and print a report of each, with progress on a terminal; the exit code."""
    from ...fmus.verify import render
    from ...fmus.verify.bench import ARCHIVE, Options, planned
    from ...fmus.verify.bench import verify as run
    from ...fmus.verify.findings import CheckResult
    from ...fmus.verify.registry import FAMILIES, checks

    errors = Console(stderr=True, highlight=False, soft_wrap=True)
    names = [*checks(), *FAMILIES, ARCHIVE]
    problems = [f"there is no file {f}" for f in files if not isfile(f)]
    problems += [f"--only {n}: there is no such check; {nearest(n, names)}"
                 for n in only if n not in names]
    if reference and not isfile(reference):
        problems.append(f"--reference: there is no file {reference}")
    if reference and len(files) > 1:
        problems.append("--reference: give one FMU with it")
    if junit and not isdir(junit.parent):
        problems.append(f"--junit: there is no folder {junit.parent}")
    if problems:
        errors.print("\n".join(problems), markup=False)
        return MISUSED
    console = Console(highlight=False, soft_wrap=True)
    options = Options(only, reference, seed, 20.0 if thorough else 1.0)
    reports = []
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(),
               TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True,
                  disable=not console.is_terminal) as progress:
        task = progress.add_task("", total=1 + len(planned(only)))

        def begin(file: Path, check: str) -> None:
            if check == ARCHIVE:
                progress.reset(task)
            progress.update(task, description=f"{file.name}  {check:<25}")

        def show(result: CheckResult) -> None:
            console.print(render.line(result), markup=False)
            progress.advance(task)

        for report in run(files, options, show, on_start=begin):
            console.print(render.summary(report), markup=False)
            reports.append(report)
    if junit:
        try:
            junit.write_bytes(render.junit(reports))
        except OSError as error:
            errors.print(f"--junit: cannot write {junit}: {error.strerror}", markup=False)
            return FAILED
    return DONE if all(r.passed for r in reports) else FAILED
