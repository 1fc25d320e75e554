"""Where commands write, and what files are called: refusals by their text, nothing left over."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.fmus.build import build

from .test_run import BLOCKS, block

pytestmark = pytest.mark.usefixtures("fmu_cache")
GAIN = f"{BLOCKS}:Gain"
LONG = "x" * 300  # longer than any file system takes
BLOCK = '''
from sightline.components import Component, Input, Output
class Twice(Component):
    """Twice its input."""
    u = Input((), "1", 1.5, doc="input")
    y = Output((), "1", doc="output")
    def outputs(self, u):
        return {"y": 2.0 * u}
'''


def small_files() -> None:
    """Lets files grow to some bytes only, as a full disk would."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))


def sightline(
    *args: str | Path, folder: Path, full: bool = False, variables: Mapping[str, str] | None = None,
    stdout: int = subprocess.PIPE,
) -> subprocess.CompletedProcess[str]:  # fmt: skip
    done = subprocess.run(
        [sys.executable, "-m", "sightline.orchestrator.cli", *map(str, args)], cwd=folder,
        stdout=stdout, stderr=subprocess.PIPE, text=True, check=False,
        env={**os.environ, **(variables or {})}, preexec_fn=small_files if full else None,
    )  # fmt: skip
    assert "Traceback" not in f"{done.stdout}{done.stderr}"
    return done


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of its own to run a command in, with a file in it."""
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "file").write_text("mine", encoding="utf-8")
    return tmp_path / "here"


def contents(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.rglob("*") if p.is_file()}


# --- folders that cannot be written to -----------------------------------------------------------


@pytest.mark.parametrize(
    ("out", "why"),
    [
        ("file", "it is a file, not a folder"),
        ("file/below", "Not a directory"),
        ("/proc/x", "No such file or directory"),
        (LONG, "File name too long"),
    ],
)
def test_build_says_why_a_folder_cannot_be_written_to(folder: Path, out: str, why: str) -> None:
    build(GAIN, target="python")
    done = sightline("build", GAIN, "--target", "python", "--out", out, folder=folder)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == f"cannot write to {out}: {why}\n"
    assert contents(folder) == {"file": b"mine"}


def test_build_on_a_full_disk_leaves_the_fmu_of_before(folder: Path) -> None:
    build(GAIN, target="python")
    (folder / "Gain.fmu").write_text("of before", encoding="utf-8")
    done = sightline("build", GAIN, "--target", "python", "--out", ".", folder=folder, full=True)
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == "cannot write to .: File too large\n"
    assert contents(folder) == {"file": b"mine", "Gain.fmu": b"of before"}


def test_run_says_that_a_name_is_too_long(write, folder: Path) -> None:
    path = write(plant=block("Integrator"))
    done = sightline("run", path, "--out", LONG, folder=folder)
    assert done.returncode == 1
    assert done.stderr.endswith(f"\ncannot write to {LONG}: File name too long\n")


@pytest.mark.parametrize("target", ["python", None])
def test_cache_that_cannot_be_written_to_is_named(folder: Path, target: str | None) -> None:
    asked = [] if target is None else ["--target", target]
    cache = {"SIGHTLINE_CACHE": str(folder / "file" / "cache")}
    done = sightline("build", GAIN, *asked, "--out", "out", folder=folder, variables=cache)
    assert done.returncode == 1
    assert done.stderr == (
        f"cannot build {GAIN}: cannot write to the cache of FMUs, {folder}/file/cache: "
        "Not a directory; SIGHTLINE_CACHE and TMPDIR name other folders\n"
    )
    assert contents(folder) == {"file": b"mine"}


def test_run_names_the_cache_that_cannot_be_written_to(write, folder: Path) -> None:
    path, cache = write(plant=block("Integrator")), folder / "file"
    done = sightline(
        "run", path, "--out", "out", folder=folder, variables={"SIGHTLINE_CACHE": str(cache)}
    )
    assert done.returncode == 2
    assert "instances.plant.component: cannot be built: cannot write to the cache of FMUs, " \
        f"{cache}: " in done.stderr
    assert "cannot write to out" not in done.stderr


def test_run_names_the_cache_that_nothing_can_be_unpacked_to(write, folder: Path) -> None:
    built = build(f"{BLOCKS}:Integrator", target="python")
    path, cache = write(plant=f'fmu = "{built}"'), folder / "file"
    done = sightline(
        "run", path, "--out", "out", folder=folder, variables={"SIGHTLINE_CACHE": str(cache)}
    )
    assert done.returncode == 1
    assert done.stderr.endswith(
        f"cannot be unpacked to {cache}/unpacked: Not a directory; SIGHTLINE_CACHE names another "
        "folder\n"
    )


# --- a full disk behind the standard output ------------------------------------------------------


@pytest.mark.parametrize("command", ["list", "info", "explain", "build", "plot", "run", "--help"])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_output_to_a_full_disk_is_told(
    write, folder: Path, command: str, unbuffered: str
) -> None:
    path = write(plant=block("Integrator"))
    if command == "plot":
        sightline("run", path, "--out", "out", folder=folder)
    arguments = {
        "info": ["Gyro"], "explain": [path], "build": [GAIN, "--target", "python"],
        "plot": ["out/results.h5"], "run": [path, "--out", "out"],
    }.get(command, [])  # fmt: skip
    build(GAIN, target="python")
    with Path("/dev/full").open("w") as full:
        done = sightline(
            command, *arguments, folder=folder, stdout=full.fileno(),
            variables={"PYTHONUNBUFFERED": unbuffered},
        )  # fmt: skip
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1:] == ["cannot write: No space left on device"]
    assert "cannot write to" not in done.stderr


def test_closed_pipe_is_no_matter(folder: Path) -> None:
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = sightline("list", folder=folder, stdout=writer)
    finally:
        os.close(writer)
    assert done.stderr == ""


# --- names ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["my-block", "1st", "class", "a b", "__init__", "x.y"])
def test_file_whose_name_is_no_identifier_gives_an_fmu_that_runs(tmp_path: Path, name: str) -> None:
    (tmp_path / f"{name}.py").write_text(BLOCK, encoding="utf-8")
    built = build(f"{tmp_path}/{name}.py:Twice", target="python")
    result = fmpy.simulate_fmu(str(built), stop_time=0.1, output_interval=0.1)
    np.testing.assert_array_equal(result["y"], 3.0)


def test_messages_are_printed_as_they_are(folder: Path) -> None:
    done = sightline("build", "cfgs.txt:x:", folder=folder)
    assert done.stderr.startswith("cannot build cfgs.txt:x:: ")


def test_time_limit_is_allowed_where_all_are_isolated(write, folder: Path) -> None:
    path = write(plant=block("Integrator", "time_limit = 30.0"))
    assert "add isolate = true" in sightline("run", path, "--out", "out", folder=folder).stderr
    done = sightline("run", path, "--out", "out", "--isolate", folder=folder)
    assert done.returncode == 0
    assert "time_limit" not in done.stderr
