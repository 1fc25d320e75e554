"""The process in which FMUs run: takes jobs as lines of JSON, answers each with a line of JSON.

Each job is one check of one FMU, in a process of its own: a fork of this one, which has everything
imported already, or a new one where there is no fork. A fork leads a session of its own: at its
end, or when its time is over or this process is to end, everything that it started is killed. What
the FMU prints goes to a file, and so does what it is doing. Where a process is lost in one of
several trials of a check, the check runs again without that trial, so that one crash does not hide
the others.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import select
import subprocess
import sys
import tempfile
import time
import traceback
from functools import lru_cache
from pathlib import Path
from typing import Any

from ..units import unit
from .driver import NoInstance
from .findings import CheckResult, Verdict
from .lab import Lab
from .processes import adopt_orphans, die_with_parent, end_group, end_orphans
from .registry import Check, NotApplicable, Notes, checks
from .session import Ended, NotFinite, Refused
from .subject import Subject
from .trace import Trace, last

LOST = 8  # processes lost in trials of one check before it is given up
LOOK = 0.02  # s between looks whether the process of a check is still there
ANSWER = 1 << 24  # bytes; no answer is as long
GARBAGE = {"ended": "garbage"}


class Abandoned(Exception):
    """Whoever asks for jobs is gone."""


def main() -> None:
    """Serve jobs until the input ends; ``--once``: do one job in this process."""
    if sys.argv[1:] == ["--once"]:
        answer = os.dup(1)
        os.dup2(2, 1)
        _do(json.loads(sys.stdin.readline()), answer)
        return
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    die_with_parent()
    adopt_orphans()
    checks()
    _import_what_fmus_import()
    for line in sys.stdin:
        job = json.loads(line)
        _prepare(job)
        try:
            served = _serve(job)
        except Abandoned:
            return
        answers.write(json.dumps(served) + "\n")
        answers.flush()


def _import_what_fmus_import() -> None:
    """What Python FMUs and validation need: here once, not in every fork."""
    for name in ("numpy.random", "pythonfmu", "lark"):
        with contextlib.suppress(ImportError):
            importlib.import_module(name)


def _prepare(job: dict[str, Any]) -> None:
    """Read descriptions and units before forking; what goes wrong shows in the fork again."""
    if job["check"] == "description.units":
        unit("m")  # loads the table of units
    with contextlib.suppress(Exception):
        for file in (job["file"], *job["others"]):
            _subject(file["path"], file["folder"])
    gc.collect()
    gc.freeze()  # or collections in the forks would copy all of this


def _serve(job: dict[str, Any]) -> dict[str, Any]:
    """The result of a job if there is one, and how the processes ended that were lost."""
    lost: list[dict[str, Any]] = []
    deadline = time.monotonic() + 2.0 * job["seconds"]
    while len(lost) < LOST and (left := deadline - time.monotonic()) > 0.0:
        skipped = [end["trial"] for end in lost]
        answer = _attempt(job | {"lost": skipped, "seconds": min(job["seconds"], left)})
        if "result" in answer:
            return answer | {"lost": lost}
        lost.append(answer)
        if answer["trial"] in ("", *skipped) or answer["ended"] == "garbage":
            break
    return {"lost": lost}


def _attempt(job: dict[str, Any]) -> dict[str, Any]:
    """Run a job in a process of its own: its result, or how the process ended."""
    with tempfile.TemporaryDirectory(prefix="sightline-verify-") as scratch:
        job |= {"scratch": scratch}
        (Path(scratch) / "work").mkdir()
        runner = _fork if hasattr(os, "fork") else _spawn
        text, answer = runner(job, time.monotonic() + job["seconds"])
        if text and "ended" not in answer:
            try:
                return {"result": _validated(job, text)}
            except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
                answer = dict(GARBAGE)
        trial, call = last(Path(scratch) / "trace")
        output = Path(scratch) / "output"
        said = output.read_text(errors="replace")[-2000:] if output.exists() else ""
        return answer | {"trial": trial, "call": call, "output": said, "seconds": job["seconds"]}


def _validated(job: dict[str, Any], text: str) -> dict[str, Any]:
    """What the check wrote, if it is a result. Raises an error if the FMU wrote into the pipe."""
    result = CheckResult.from_json(json.loads(text))
    if result.check != job["check"]:
        raise ValueError(result.check)
    return result.to_json()


def _fork(job: dict[str, Any], deadline: float) -> tuple[str, dict[str, Any]]:
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        try:
            os.setsid()
            die_with_parent()
            _quietly(Path(job["scratch"]))
            os.closerange(3, writer)  # an FMU must not reach the pipes of this process
            os.closerange(writer + 1, writer + 64)
            _do(job, writer)
        except BaseException:
            traceback.print_exc()  # a mistake of the bench: the report ends with its last line
        finally:
            os._exit(0)
    os.close(writer)
    try:
        data, code = _await(pid, reader, deadline)
    finally:
        os.close(reader)
        end_group(pid)
        end_orphans()
    if code is None:
        return "", {"ended": "time"}
    if len(data) > ANSWER:
        return "", dict(GARBAGE)
    if not data:
        return "", {"ended": "signal" if code < 0 else "exit", "code": abs(code)}
    return data.decode(errors="replace"), {}


def _await(pid: int, reader: int, deadline: float) -> tuple[bytes, int | None]:
    """What a process writes until it ends, and its exit code; None if its time is over.

    Its own end counts, not that of the pipe, which others may hold open. Raises Abandoned.
    """
    data = bytearray()
    pipe_open, ended, status = True, 0, 0
    while (left := deadline - time.monotonic()) > 0 and len(data) <= ANSWER:
        if not ended:
            ended, status = os.waitpid(pid, os.WNOHANG)
        wait = 0.0 if ended else min(left, LOOK if pipe_open else 0.001)
        ready = select.select([reader, 0] if pipe_open else [0], [], [], wait)[0]
        if 0 in ready:  # no job comes before this one is answered: it is the end of the input
            raise Abandoned
        part = os.read(reader, 1 << 16) if ready else b""
        data += part
        pipe_open = pipe_open and not (ready and not part)
        if ended and not part:
            return bytes(data), os.waitstatus_to_exitcode(status)
    return bytes(data), 0 if len(data) > ANSWER else None


def _quietly(scratch: Path) -> None:
    """Turn input and output away from the pipes of this process; leave no core files."""
    output = os.open(scratch / "output", os.O_WRONLY | os.O_CREAT)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.dup2(output, 1)
    os.dup2(output, 2)
    os.close(nothing)
    os.close(output)
    try:
        import resource

        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    except ImportError:
        pass


def _spawn(job: dict[str, Any], deadline: float) -> tuple[str, dict[str, Any]]:
    command = [sys.executable, "-m", f"{__package__}.child", "--once"]
    try:
        done = subprocess.run(command, input=json.dumps(job) + "\n", capture_output=True,
                              text=True, timeout=max(deadline - time.monotonic(), 0.1))
    except subprocess.TimeoutExpired:
        return "", {"ended": "time"}
    if done.stdout and done.returncode == 0:
        return done.stdout, {}
    kind = "signal" if done.returncode < 0 else "exit"
    return "", {"ended": kind, "code": abs(done.returncode)}


def _do(job: dict[str, Any], writer: int) -> None:
    """Run the check here and write its result."""
    result = run(job)
    data = json.dumps(result.to_json()).encode()
    while data:
        data = data[os.write(writer, data):]


def run(job: dict[str, Any]) -> CheckResult:
    """The result of a job. Whatever goes wrong becomes a finding."""
    check = checks()[job["check"]]
    began = time.monotonic()
    os.chdir(Path(job["scratch"]) / "work")
    notes = Notes(check.name)
    verdict, reason = _judge(check, notes, job, Trace(Path(job["scratch"]) / "trace"))
    return CheckResult(check.name, verdict, tuple(notes.findings), reason, dict(notes.tried),
                       time.monotonic() - began)


def _judge(check: Check, notes: Notes, job: dict[str, Any], trace: Trace) -> tuple[Verdict, str]:
    lab: Lab | None = None
    try:
        lab = Lab(
            _subject(**job["file"]), trace, [_subject(**f) for f in job["others"]],
            Path(job["reference"]) if job["reference"] else None,
            job["seed"], job["effort"], job["lost"],
        )
        if not check.name.startswith("description"):
            lab.require_interface()
        check.function(lab, notes)
    except NotApplicable as error:
        return Verdict.NOT_APPLICABLE, str(error)
    except Ended as error:
        if not notes.findings:
            return Verdict.NOT_APPLICABLE, f"{error}, too early for this check"
    except NotFinite as error:
        notes.wrong(error.action, error.found, "finite values, or an error status")
    except Refused as error:
        notes.wrong(error.action, error.found, "status OK")
    except NoInstance as error:
        notes.wrong("instantiation", str(error), "an instance")
    except Exception as error:
        if lab is not None:
            raise
        notes.wrong("modelDescription.xml", f"cannot be read: {error}")
    if lab is not None:
        lab.close()
    return (Verdict.FAILED if notes.findings else Verdict.PASSED), ""


@lru_cache(maxsize=16)
def _subject(path: str, folder: str) -> Subject:
    return Subject(Path(path), Path(folder))


if __name__ == "__main__":
    main()
