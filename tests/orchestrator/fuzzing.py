"""One command in this process, and what every command must keep to however wrong its input is."""

from __future__ import annotations

import signal
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, settings
from typer.testing import CliRunner, Result

from sightline.orchestrator.cli import app
from sightline.orchestrator.results.file import FILE, read

EVERY_EXAMPLE = settings(deadline=None, suppress_health_check=[*HealthCheck])
LIMIT = 60  # s, that a command may take on a busy machine before it hangs
Tree = Mapping[Path, tuple[int, int]]


class Hanging(BaseException):
    """A command that does not come to an end."""


@contextmanager
def time_limit(seconds: int = LIMIT) -> Iterator[None]:
    """Raises Hanging in what takes longer."""

    def hang(number: int, frame: Any) -> None:
        raise Hanging

    before = signal.signal(signal.SIGALRM, hang)
    signal.alarm(seconds)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def invoke(*arguments: object) -> Result:
    """Run a command line that must end in a message and an exit code, not in a traceback."""
    with time_limit():
        done = CliRunner().invoke(app, [str(a) for a in arguments])
    error = done.exception
    if error is not None and not isinstance(error, SystemExit):
        raise error
    assert "Traceback" not in done.output
    assert done.exit_code in (0, 1, 2), done.output
    assert done.exit_code == 0 or done.output.strip(), "failed without a word"
    return done


def tree(folder: Path, but: Path) -> Tree:
    """All files below a folder, apart from those below another, with their sizes and times."""
    found = (p for p in folder.rglob("*") if but not in (p, *p.parents))
    return {p: (s.st_size, s.st_mtime_ns) for p in found if (s := p.lstat())}


def run(config: Path, out: Path, *more: object) -> Result:
    """``sightline run``, whose files must be all in ``out`` and tell how it ended."""
    before = tree(config.parent, out)
    done = invoke("run", config, "--out", out, *more)
    assert tree(config.parent, out) == before
    if done.exit_code == 2:
        check_report(done.stderr, config.parent)
        assert not out.exists()
    elif (out / FILE).exists():
        check_results(out / FILE, complete=done.exit_code == 0)
    return done


def check_results(file: Path, complete: bool) -> None:
    """Rows in order, all numbers finite, and whether the run was complete."""
    results = read(file)
    assert results.complete == complete
    assert np.all(np.diff(results.time) > 0.0)
    for series in results.series.values():
        assert len(series.values) == len(results.time)
        assert np.all(np.isfinite(series.values))


def check_report(text: str, folder: Path) -> None:
    """A count, then as many problems, each with the file or the setting that it is about."""
    lines = text.splitlines()
    heads = [i for i, line in enumerate(lines) if line.endswith((" problem", " problems"))]
    assert heads, text
    count, problems = int(lines[heads[0]].split()[0]), lines[heads[0] + 1:]
    assert count == len(problems), text
    for problem in problems:
        assert str(folder) in problem or "--set " in problem, problem


def toml(data: Mapping[str, Any]) -> str:
    """Data as TOML, a line for each table of a table: written apart from what is under test."""
    lines = [f"{_key(k)} = {_value(v)}" for k, v in data.items() if not _is_table(v)]
    for key, table in data.items():
        if isinstance(table, dict):
            plain = {k: v for k, v in table.items() if not isinstance(v, dict)}
            lines += [f"[{_key(key)}]", *(f"{_key(k)} = {_value(v)}" for k, v in plain.items())]
            for inner, value in table.items():
                if isinstance(value, dict):
                    lines.append(f"[{_key(key)}.{_key(inner)}]")
                    lines += [f"{_key(k)} = {_value(v)}" for k, v in value.items()]
        elif _is_table(table):
            for row in table:
                lines.append(f"[[{_key(key)}]]")
                lines += [f"{_key(k)} = {_value(v)}" for k, v in row.items()]
    return "\n".join(lines) + "\n"


def _is_table(value: Any) -> bool:
    rows = isinstance(value, list) and bool(value) and all(isinstance(v, dict) for v in value)
    return isinstance(value, dict) or rows


def _key(name: str) -> str:
    return _text(name)


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, Sequence):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, int) and value > 10**4000:
        return hex(value)  # which takes any length
    return repr(value)


def _text(text: str) -> str:
    escaped = (
        c if c.isprintable() and c not in '"\\' and ord(c) < 0xD800 else f"\\U{ord(c):08X}"
        for c in text
    )
    return f'"{"".join(escaped)}"'
