"""Systems of real FMUs: exact order, exact time, failures, interrupted and repeated runs."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from sightline.orchestrator.errors import FmuError, RunError
from sightline.orchestrator.results.file import read
from sightline.orchestrator.run import Interrupted
from sightline.orchestrator.system import System

pytestmark = pytest.mark.usefixtures("fmu_cache")
BLOCKS = Path(__file__).with_name("blocks.py")
LOOP = ["plant.x -> control.x", "control.y -> plant.u"]


def block(name: str, table: str = "") -> str:
    return f'component = "{BLOCKS.as_posix()}:{name}"\ntarget = "python"\n{table}'


@pytest.fixture
def closed_loop(write) -> Callable[..., Path]:
    """x' = -x by a controller listed before its plant; x(0) = 1."""

    def path(
        step: float = 0.1, stop: float = 1.0, algorithm: str = "gauss-seidel", rest: str = "",
        control: str = "",
    ) -> Path:  # fmt: skip
        text = (
            f'[simulation]\nstop_time = {stop}\nstep = {step}\nalgorithm = "{algorithm}"\n'
        )
        tables = {
            "control": block("Gain", control), "plant": block("Integrator", "start = { x = 1.0 }"),
        }  # fmt: skip
        return write(LOOP, rest, simulation=text, **tables)

    return path


def test_gauss_seidel_holds_the_input_of_the_instant(closed_loop, tmp_path: Path) -> None:
    results = System.from_toml(closed_loop()).simulate(tmp_path / "out")
    expected = 0.9 ** np.arange(11)  # x_n+1 = x_n + h · (-x_n), exactly held input
    np.testing.assert_allclose(results["plant.x"], expected, rtol=1e-14)
    np.testing.assert_array_equal(results["control.y"], -results["plant.x"])


def test_jacobi_controls_on_the_instant_before(closed_loop, tmp_path: Path) -> None:
    results = System.from_toml(closed_loop(algorithm="jacobi")).simulate(tmp_path / "out")
    x = [1.0, 0.9]
    while len(x) < 11:
        x.append(x[-1] - 0.1 * x[-2])
    np.testing.assert_allclose(results["plant.x"], x, rtol=1e-14)


def test_first_row_is_consistent(closed_loop, tmp_path: Path) -> None:
    results = System.from_toml(closed_loop()).simulate(tmp_path / "out")
    assert (results["plant.x"][0], results["control.y"][0]) == (1.0, -1.0)


def test_error_halves_with_the_step(closed_loop, tmp_path: Path) -> None:
    errors = []
    for step in (0.02, 0.01, 0.005):
        results = System.from_toml(closed_loop(step)).simulate(tmp_path / "out")
        errors.append(abs(results["plant.x"][-1] - np.exp(-1.0)))
    ratios = np.array(errors[:-1]) / errors[1:]
    np.testing.assert_allclose(ratios, 2.0, rtol=0.02)  # first order, error O(h) of the ratio


def test_time_is_a_multiple_of_the_step_and_never_a_sum(write, tmp_path: Path) -> None:
    text = "[simulation]\nstart_time = 0.3\nstop_time = 300.3\nstep = 0.1\n"
    path = write(simulation=text, clock=block("Clock"))
    results = System.from_toml(path).simulate(tmp_path / "out")
    np.testing.assert_array_equal(results.time, 0.3 + np.arange(3001) * 0.1)
    # t_n + h is one rounding away from t_n+1, whatever n
    np.testing.assert_allclose(results["clock.t"], results.time, rtol=3e-16)


def test_units_of_one_dimension_convert_while_running(write, make_fmu, tmp_path: Path) -> None:
    blocks = tmp_path / "far.py"
    blocks.write_text(
        "from sightline.components import Component, Input, Output\n"
        "class Far(Component):\n    '''y = x'''\n"
        "    x = Input((), 'km', doc='input')\n    y = Output((), 'km', doc='output')\n"
        "    def outputs(self, x):\n        return {'y': x * 1.0}\n",
        encoding="utf-8",
    )
    far = 'component = "far.py:Far"\ntarget = "python"'
    path = write(["plant.x -> far.x"], plant=block("Integrator", "start = {x = 500.0}"), far=far)
    results = System.from_toml(path).simulate(tmp_path / "out")
    np.testing.assert_allclose(results["far.y"], 0.5, rtol=1e-15)


def test_recording_interval_thins_rows_only(closed_loop, tmp_path: Path) -> None:
    every = System.from_toml(closed_loop()).simulate(tmp_path / "a")
    fifth = System.from_toml(closed_loop(rest="[record]\nevery = 0.5")).simulate(tmp_path / "b")
    np.testing.assert_array_equal(fifth["plant.x"], every["plant.x"][::5])
    np.testing.assert_array_equal(fifth.time, every.time[::5])


def test_long_runs_are_written_in_parts(closed_loop, tmp_path: Path) -> None:
    results = System.from_toml(closed_loop(0.001, 2.5)).simulate(tmp_path / "out")  # 2501 > buffer
    np.testing.assert_array_equal(results.time, np.arange(2501) * 0.001)
    np.testing.assert_allclose(results["plant.x"], 0.999 ** np.arange(2501), rtol=1e-12)


def test_results_tell_units_frames_and_the_config(closed_loop, tmp_path: Path) -> None:
    System.from_toml(closed_loop()).simulate(tmp_path)
    with h5py.File(tmp_path / "results.h5") as file:
        assert dict(file["plant/x"].attrs) == {
            "unit": "m", "frame": "", "description": "integral",
        }  # fmt: skip
        assert file["time"].attrs["unit"] == "s"
        assert 'stop_time = 1.0' in file["config"].asstr()[()]
        assert file.attrs["sightline_version"]
        assert bool(file.attrs["complete"])


def test_same_config_gives_the_same_file(closed_loop, tmp_path: Path) -> None:
    System.from_toml(closed_loop()).simulate(tmp_path / "a")
    time.sleep(1.1)  # a time stamp would differ
    System.from_toml(closed_loop()).simulate(tmp_path / "b")
    files = [(tmp_path / name / "results.h5").read_bytes() for name in "ab"]
    assert files[0] == files[1]


def test_failed_step_names_instance_time_and_reason(write, tmp_path: Path) -> None:
    path = write(
        ["plant.x -> control.x"],
        plant=block("Integrator", "start = { u = 1.0 }"),
        control=block("Gain", "parameters = { limit = 0.45 }"),
    )
    with pytest.raises(RunError) as caught:
        System.from_toml(path).simulate(tmp_path)
    error = caught.value
    assert (error.instance, error.time) == ("control", pytest.approx(0.4))
    assert "the step of 0.1 s ended with discard: x must stay below the limit" in str(error)
    results = read(tmp_path / "results.h5")
    assert not results.complete
    np.testing.assert_allclose(results.time, [0.0, 0.1, 0.2, 0.3, 0.4])
    assert "control: error" in (tmp_path / "log.txt").read_text(encoding="utf-8")


def test_all_that_a_failing_call_said_is_quoted(write, tmp_path: Path) -> None:
    starts = "start = { line_of_sight = [2.0, 0.0, 0.0], target_line_of_sight = [0.0, 3.0, 0.0] }"
    path = write(control=f'component = "LineOfSightFormationController"\n{starts}')
    with pytest.raises(RunError) as raised:
        System.from_toml(path).simulate(tmp_path)
    assert "; ".join(
        f"{name} must be a unit vector (time 0 s)"
        for name in ("line_of_sight", "target_line_of_sight")
    ) in str(raised.value)


def test_failed_initialisation_gives_the_reason_of_the_fmu(write, tmp_path: Path) -> None:
    singular = "parameters = { inertia = [[1, 0, 0], [0, 0, 0], [0, 0, 1]] }"
    path = write(craft1=f'component = "FreeRigidBody"\ntarget = "python"\n{singular}')
    with pytest.raises(RunError, match="craft1 at t = 0 s: initialisation ended with") as e:
        System.from_toml(path).simulate(tmp_path)
    assert e.value.message == "inertia must be positive definite"


def test_all_instances_that_refuse_their_start_are_named(write, tmp_path: Path) -> None:
    bad = 'component = "FreeRigidBody"\nstart = { attitude = [1.0, 1.0, 0.0, 0.0] }'
    good = 'component = "FreeRigidBody"'
    with pytest.raises(RunError, match="craft1 at t = 0 s: initialisation ended") as raised:
        System.from_toml(write(craft1=bad, craft2=good, craft3=bad)).simulate(tmp_path)
    (other,) = raised.value.__notes__
    assert other.startswith("craft3 at t = 0 s: initialisation ended with error: attitude must be")


def test_instances_of_one_fmu_are_apart(write, tmp_path: Path) -> None:
    tables = {f"p{i}": block("Integrator", f"start = {{ x = {i}.0, u = {i}.0 }}") for i in (1, 2)}
    results = System.from_toml(write(**tables)).simulate(tmp_path)
    np.testing.assert_allclose(results["p2.x"], 2 * results["p1.x"], rtol=1e-15)


def test_damaged_binary_in_a_sound_listing_is_an_fmu_error(closed_loop, tmp_path: Path) -> None:
    system = System.from_toml(closed_loop())
    path = tmp_path / "broken.fmu"
    content = bytearray(system.graph.nodes[0].fmu.path.read_bytes())
    content[len(content) // 4 : len(content) // 2] = bytes(len(content) // 2 - len(content) // 4)
    path.write_bytes(content)
    object.__setattr__(system.graph.nodes[0].fmu, "path", path)
    with pytest.raises(FmuError, match=r"broken\.fmu is a damaged archive"):
        system.simulate(tmp_path / "out")


def test_interrupt_leaves_a_readable_file(closed_loop, tmp_path: Path) -> None:
    system = System.from_toml(closed_loop(1e-4, 1000.0))
    timer = threading.Timer(1.0, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    with pytest.raises(Interrupted, match=r"stopped at t = "):
        system.simulate(tmp_path)
    timer.join()
    results = read(tmp_path / "results.h5")
    assert not results.complete
    assert len(results.time) > 100
    np.testing.assert_allclose(results["plant.x"], 0.9999 ** np.arange(len(results.time)),
                               rtol=1e-9)  # the rounding of some ten thousand products


def test_no_temporary_files_stay(closed_loop, tmp_path: Path, monkeypatch) -> None:
    folder = tmp_path / "tmp"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    System.from_toml(closed_loop()).simulate(tmp_path / "out")
    assert list(folder.iterdir()) == []


def test_python_is_left_as_it_was(closed_loop, tmp_path: Path) -> None:
    path = list(sys.path)
    System.from_toml(closed_loop()).simulate(tmp_path / "out")
    assert sys.path == path
    strays = [n for n in sys.modules if n.startswith("sightline_gain_")]
    assert strays == []


def test_integers_and_booleans_pass(write, tmp_path: Path) -> None:
    text = "[simulation]\nstop_time = 3.0\nstep = 1.0\n"
    path = write(
        ["a.count -> b.count_in", "a.on -> b.on_in"], simulation=text,
        a=block("Switch"), b=block("Switch"),
    )  # fmt: skip
    results = System.from_toml(path).simulate(tmp_path)
    np.testing.assert_array_equal(results["a.count"], [0, 1, 2, 3])
    np.testing.assert_array_equal(results["a.on"], [0, 0, 1, 1])
    np.testing.assert_array_equal(results["b.echo"], [0, 1, 102, 103])
    assert (results["a.count"].dtype, results["a.on"].dtype) == (np.int32, np.uint8)


def test_killed_run_leaves_a_readable_file(closed_loop, tmp_path: Path) -> None:
    path = closed_loop(1e-4, 1000.0)
    System.from_toml(path)  # builds the FMUs
    command = [sys.executable, "-m", "sightline.orchestrator.cli", "run", str(path), "--out"]
    with subprocess.Popen([*command, str(tmp_path)], stderr=subprocess.DEVNULL) as process:
        time.sleep(4.0)  # s: start, and some flushes
        process.kill()
    results = read(tmp_path / "results.h5")
    assert not results.complete
    assert len(results.time) > 1000
    np.testing.assert_allclose(results["plant.x"], 0.9999 ** np.arange(len(results.time)),
                               rtol=1e-9)  # the rounding of some ten thousand products
