"""Run checks on FMU files: archives looked at here, everything else in processes of its own."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..safe_archive import DESCRIPTION, ArchiveProblem, UnsafeArchiveError, extract
from ..safe_xml import Head, read_head
from .findings import CheckResult, Finding, Report, Verdict
from .registry import Check, selected

ARCHIVE = "archive"
PATIENCE = 5.0  # s until the process of the checks must have ended
OnResult = Callable[[CheckResult], None]
OnStart = Callable[[Path, str], None]  # the file, and the check that begins


@dataclass(frozen=True)
class Options:
    """How to check. ``time_limit`` in seconds stands in for that of each check.

    ``effort`` scales how much is tried; from 20 on everything is, however long it takes.
    """

    only: Sequence[str] = ()
    reference: Path | None = None
    seed: int = 0
    effort: float = 1.0
    time_limit: float | None = None


class Workshop:
    """The process that runs checks; started when first needed, again if it was lost."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def run(self, job: dict[str, Any]) -> dict[str, Any]:
        """The answer to a job; see ``child``."""
        process = self._process
        if process is None or process.poll() is not None:
            process = self._process = subprocess.Popen(
                [sys.executable, "-P", "-m", f"{__package__}.child"],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8",
                start_new_session=True,  # Ctrl-C is for the command: it ends this process
            )  # fmt: skip
        assert process.stdin is not None
        assert process.stdout is not None
        end: dict[str, Any] = {"trial": "", "call": "", "output": ""}
        try:
            process.stdin.write(json.dumps(job) + "\n")
            process.stdin.flush()
            if line := process.stdout.readline():
                answer: dict[str, Any] = json.loads(line)
                return answer
        except BrokenPipeError:
            pass  # lost between two jobs
        except ValueError:
            self.close()
            return {"lost": [end | {"ended": "garbage"}]}
        code = process.wait()
        kind = "signal" if code < 0 else "exit"
        return {"lost": [end | {"ended": kind, "code": abs(code)}]}

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            assert self._process.stdin is not None
            assert self._process.stdout is not None
            with suppress(BrokenPipeError):
                self._process.stdin.close()
            self._process.stdout.close()
            try:
                self._process.wait(PATIENCE)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
            self._process = None


@contextmanager
def workshop() -> Iterator[Workshop]:
    """A workshop that is closed at the end."""
    made = Workshop()
    try:
        yield made
    finally:
        made.close()


def planned(only: Sequence[str]) -> dict[str, Check]:
    """The checks after that of the archive. Raises KeyError for a check that there is not."""
    return {} if set(only) == {ARCHIVE} else selected([n for n in only if n != ARCHIVE])


def verify(
    files: Iterable[Path], options: Options = Options(),
    on_result: OnResult = lambda result: None, shop: Workshop | None = None,
    on_start: OnStart = lambda file, check: None,
) -> Generator[Report, None, None]:  # fmt: skip
    """Reports of FMU files, one after the other. Raises KeyError for a check that there is not.

    Files of the same model are compared with each other.
    """
    chosen = planned(options.only)
    with tempfile.TemporaryDirectory(prefix="sightline-verify-") as base, workshop() as own:
        earlier: dict[str, list[dict[str, str]]] = {}
        for number, path in enumerate(files):
            folder = Path(base) / str(number)
            on_start(path, ARCHIVE)
            result, head = _open(path, folder)
            results = [result]
            on_result(result)
            if result.verdict is Verdict.PASSED:
                file = {"path": str(path.resolve()), "folder": str(folder)}
                others = earlier.setdefault(head.model, [])
                for check in chosen.values():
                    on_start(path, check.name)
                    results.append(_run(check, file, others, options, shop or own))
                    on_result(results[-1])
                others.append(file)
            yield Report(path, head.model or path.stem, head.version, tuple(results))


def _open(path: Path, folder: Path) -> tuple[CheckResult, Head]:
    """Look at an archive and unpack it if nothing is wrong."""
    began = time.monotonic()
    problems: Sequence[ArchiveProblem] = ()
    head = Head()
    try:
        extract(path, folder)
        head = read_head((folder / DESCRIPTION).read_bytes())
    except UnsafeArchiveError as error:
        problems = error.problems
    findings = tuple(
        Finding(ARCHIVE, p.member or path.name, "", p.detail, "nothing in it was executed")
        for p in problems
    )
    verdict = Verdict.FAILED if problems else Verdict.PASSED
    seconds = time.monotonic() - began
    return CheckResult(ARCHIVE, verdict, findings, seconds=seconds), head


def _run(
    check: Check, file: dict[str, str], others: list[dict[str, str]], options: Options,
    shop: Workshop,
) -> CheckResult:  # fmt: skip
    seconds = options.time_limit or check.seconds * max(options.effort, 1.0)
    job = {
        "check": check.name, "file": file, "others": list(others), "seed": options.seed,
        "reference": str(options.reference.resolve()) if options.reference else "",
        "effort": options.effort, "seconds": seconds,
    }  # fmt: skip
    began = time.monotonic()
    answer = shop.run(job)
    lost = [_loss(check, end) for end in answer["lost"]]
    if "result" not in answer:
        rest = replace(lost[-1], remedy="what comes after that in this check was not tried")
        return CheckResult(check.name, Verdict.FAILED, (*lost[:-1], rest),
                           seconds=time.monotonic() - began)
    result = CheckResult.from_json(answer["result"])
    return result if not lost else replace(
        result, verdict=Verdict.FAILED, findings=(*lost, *result.findings)
    )  # fmt: skip


def _loss(check: Check, end: dict[str, Any]) -> Finding:
    """How a process ended, as a finding."""
    where = ", ".join(filter(None, (end["trial"], end["call"]))) or "before the first call"
    if end["ended"] == "garbage":
        where = "open files"  # which may hold the trace as well
    return Finding(check.name, where, "", _ending(end))


def _ending(end: dict[str, Any]) -> str:
    if end["ended"] == "time":
        return f"did not come back within {end['seconds']:.3g} s"
    if end["ended"] == "garbage":
        return "wrote into the bench's own channel, where only the result of the check belongs"
    output = end["output"].strip()
    said = f"; its last words: {output.splitlines()[-1][:200]}" if output else ""
    if end["ended"] == "signal":
        try:
            name = signal.Signals(end["code"]).name
        except ValueError:
            name = f"signal {end['code']}"
        return f"crashed the process ({name}){said}"
    return f"ended the process with exit code {end['code']}{said}"
