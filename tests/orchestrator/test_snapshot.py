"""Checkpoints and resumed runs: the same bits as the run that nothing interrupted."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from sightline.fmus.native.target import compiler_available
from sightline.orchestrator.errors import ConfigError
from sightline.orchestrator.results.file import read
from sightline.orchestrator.stepping.snapshot import Snapshot
from sightline.orchestrator.system import System

from .conftest import variable
from .test_run import block

pytestmark = pytest.mark.usefixtures("fmu_cache")
TARGETS = ["python", *(["native"] if compiler_available() else [])]
ALGORITHMS = [
    'algorithm = "gauss-seidel"', 'algorithm = "jacobi"',
    'algorithm = "gauss-seidel"\ncoupling = "linear"',
    'algorithm = "adaptive"\ntolerance = 1e-6',
]  # fmt: skip


@pytest.fixture
def formation(tmp_path: Path) -> Callable[..., Path]:
    """A turning craft, a noisy sampled gyro, and an integrator fed back."""

    def write(simulation: str = ALGORITHMS[0], target: str = "python", stop: float = 2.0) -> Path:
        path = tmp_path / "system.toml"
        path.write_text(f"""
connections = [
  "craft.angular_velocity -> gyro.angular_velocity",
  "plant.x -> control.x", "control.y -> plant.u",
]
[simulation]
stop_time = {stop}
step = 0.05
{simulation}
[record]
every = 0.1
[instances.craft]
component = "FreeRigidBody"
target = "{target}"
parameters = {{ inertia = [[1, 0, 0], [0, 2, 0], [0, 0, 3]] }}
start = {{ angular_velocity = [0.3, 2.0, 0.1] }}
[instances.gyro]
component = "Gyro"
target = "{target}"
parameters = {{ noise_density = 0.01, sample_period = 0.2, seed = 5 }}
[instances.plant]
{block("Integrator", "start = { x = 1.0 }").replace('"python"', f'"{target}"')}
[instances.control]
{block("Gain").replace('"python"', f'"{target}"')}
""", encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("simulation", ALGORITHMS)
def test_resumed_run_gives_the_same_bytes(
    formation, tmp_path: Path, simulation: str, target: str
) -> None:
    whole, part, rest = (tmp_path / n for n in ("whole", "part", "rest"))
    system = System.from_toml(formation(simulation, target))
    system.execute(whole)
    system.execute(part, checkpoint_every=0.7)
    snapshot = Snapshot.read(part / "checkpoint.h5")
    assert snapshot.time == pytest.approx(1.4)
    system.execute(rest, resume=part / "checkpoint.h5")
    assert (rest / "results.h5").read_bytes() == (whole / "results.h5").read_bytes()


def test_checkpoints_change_nothing_but_the_checkpoint(formation, tmp_path: Path) -> None:
    system = System.from_toml(formation())
    system.execute(tmp_path / "a")
    system.execute(tmp_path / "b", checkpoint_every=0.3)
    contents = [(tmp_path / n / "results.h5").read_bytes() for n in "ab"]
    assert contents[0] == contents[1]


@pytest.mark.parametrize("target", TARGETS)
def test_resume_goes_on_in_the_same_folder_and_longer(
    formation, tmp_path: Path, target: str
) -> None:
    out = tmp_path / "out"
    System.from_toml(formation(target=target, stop=1.0)).execute(out, checkpoint_every=0.4)
    longer = System.from_toml(formation(target=target, stop=2.0))
    longer.execute(out, resume=out / "checkpoint.h5")
    longer.execute(tmp_path / "whole")
    np.testing.assert_array_equal(
        read(out / "results.h5")["gyro.measured_angular_velocity"],
        read(tmp_path / "whole" / "results.h5")["gyro.measured_angular_velocity"],
    )
    assert sorted(p.name for p in out.iterdir()) == ["checkpoint.h5", "results.h5"]


def test_killed_run_is_resumed_to_the_same_bytes(closed_loop_file, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sightline.orchestrator.cli", "run", str(closed_loop_file)]
    killed = [*command, "--out", str(tmp_path / "killed"), "--checkpoint-every", "1"]
    with subprocess.Popen(killed, stderr=subprocess.DEVNULL) as process:
        checkpoint = tmp_path / "killed" / "checkpoint.h5"
        deadline = time.monotonic() + 60.0  # s
        while not checkpoint.is_file() and time.monotonic() < deadline:
            time.sleep(0.05)
        process.kill()
    assert not read(tmp_path / "killed" / "results.h5").complete
    resume = [*command, "--out", str(tmp_path / "killed"), "--resume", str(checkpoint)]
    assert subprocess.run(resume, capture_output=True, check=False).returncode == 0
    System.from_toml(closed_loop_file).execute(tmp_path / "whole")
    contents = [(tmp_path / n / "results.h5").read_bytes() for n in ("killed", "whole")]
    assert contents[0] == contents[1]


def test_interrupt_keeps_a_last_checkpoint(closed_loop_file, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sightline.orchestrator.cli", "run", str(closed_loop_file)]
    with subprocess.Popen(
        [*command, "--out", str(tmp_path), "--checkpoint-every", "1000"],
        stderr=subprocess.PIPE, text=True,
    ) as process:  # fmt: skip
        while not (tmp_path / "results.h5").is_file():
            time.sleep(0.05)
        time.sleep(1.0)  # s: into the loop
        os.kill(process.pid, signal.SIGINT)
        said = process.stderr.read() if process.stderr else ""
    assert process.returncode == 130
    stopped = Snapshot.read(tmp_path / "checkpoint.h5")
    assert f"stopped at t = {stopped.time:.6g} s" in said
    assert stopped.rows == len(read(tmp_path / "results.h5").time)


@pytest.fixture
def closed_loop_file(write) -> Path:
    tables = {
        "control": block("Gain"), "plant": block("Integrator", "start = { x = 1.0 }"),
    }  # fmt: skip
    text = "[simulation]\nstop_time = 4.0\nstep = 1e-4\n"
    path = write(["plant.x -> control.x", "control.y -> plant.u"], simulation=text, **tables)
    System.from_toml(path)  # builds the FMUs
    return path


def test_checkpoint_of_another_system_is_refused(formation, tmp_path: Path) -> None:
    System.from_toml(formation()).execute(tmp_path / "out", checkpoint_every=1.0)
    other = System.from_toml(formation(), {"craft.mass": 2.0})
    with pytest.raises(ConfigError, match="is of another system; only stop_time and plots may"):
        other.execute(tmp_path / "new", resume=tmp_path / "out" / "checkpoint.h5")


def test_checkpoint_of_after_the_stop_time_is_refused(formation, tmp_path: Path) -> None:
    System.from_toml(formation()).execute(tmp_path / "out", checkpoint_every=1.5)
    shorter = System.from_toml(formation(stop=1.0))
    with pytest.raises(ConfigError, match=r"is of t = 1\.5 s, after the stop time 1 s; give a"):
        shorter.execute(tmp_path / "new", resume=tmp_path / "out" / "checkpoint.h5")


@pytest.mark.parametrize(
    ("name", "message"), [("none.h5", "is not a snapshot: "), ("system.toml", "is not a snapshot")]
)
def test_file_that_is_no_checkpoint_is_refused(
    formation, tmp_path: Path, name: str, message: str
) -> None:
    system = System.from_toml(formation())
    with pytest.raises(ConfigError, match=message):
        system.execute(tmp_path / "out", resume=tmp_path / name)
    assert not (tmp_path / "out").exists()


def flip(path: Path, name: str) -> None:
    """Turn one bit of a dataset round, its lowest one of a number's mantissa."""
    with h5py.File(path, "r+") as file:
        content = bytearray(file[name][()].tobytes())
        content[len(content) // 16 * 8] ^= 1
        file[name][...] = np.frombuffer(content, dtype=file[name].dtype)


def forget(path: Path) -> None:
    """Take out what a checkpoint says of itself."""
    with h5py.File(path, "r+") as file:
        del file.attrs["sha256"]


def shift(path: Path) -> None:
    """Change the time by its last digit."""
    with h5py.File(path, "r+") as file:
        file.attrs["time"] = np.nextafter(file.attrs["time"], 0.0)


@pytest.mark.parametrize(
    "damage",
    [lambda p: flip(p, "values"), lambda p: flip(p, "states/craft"), shift, forget],
    ids=["values", "state", "time", "no digest"],
)
def test_damaged_checkpoint_is_refused(
    formation, tmp_path: Path, damage: Callable[[Path], None]
) -> None:
    system, path = System.from_toml(formation()), tmp_path / "out" / "checkpoint.h5"
    system.execute(tmp_path / "out", checkpoint_every=1.0)
    damage(path)
    with pytest.raises(ConfigError, match=r"--resume .*checkpoint\.h5: is damaged"):
        system.execute(tmp_path / "new", resume=path)
    assert not (tmp_path / "new").exists()


def test_checkpoint_without_its_results_is_refused(formation, tmp_path: Path) -> None:
    system = System.from_toml(formation())
    system.execute(tmp_path / "out", checkpoint_every=1.0)
    (tmp_path / "out" / "results.h5").unlink()
    with pytest.raises(ConfigError, match=r"no results\.h5 with 21 rows is beside it"):
        system.execute(tmp_path / "new", resume=tmp_path / "out" / "checkpoint.h5")


def test_fmu_that_cannot_write_its_state_is_named(write, make_fmu, tmp_path: Path) -> None:
    make_fmu("plant", [variable("y", "output")])
    system = System.from_toml(write(p='fmu = "plant.fmu"'))
    with pytest.raises(ConfigError, match=r"p \(plant\) cannot write its state"):
        system.execute(tmp_path / "out", checkpoint_every=1.0)


def test_session_branches_from_a_saved_state(formation) -> None:
    system = System.from_toml(formation())
    with system.start() as running:
        running.step(10)
        saved = running.save()
        running.step(10)
        first = running.values()
        running.restore(saved)
        assert running.time == pytest.approx(0.5)
        running.set("craft.torque", [1.0, 0.0, 0.0])
        running.step(10)
        branch = running.values()
        running.restore(saved)
        running.step(10)
        again = running.values()
    with system.start() as other:
        other.restore(saved)
        other.step(10)
        elsewhere = other.values()
    for name in first:
        np.testing.assert_array_equal(again[name], first[name])
        np.testing.assert_array_equal(elsewhere[name], first[name])
    assert not np.array_equal(branch["craft.angular_velocity"], first["craft.angular_velocity"])
