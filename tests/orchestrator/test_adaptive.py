"""Steps under error control: as exact as asked, with few steps, exact where it counts."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.commands import run as command_run
from sightline.orchestrator.results.file import read
from sightline.orchestrator.run import Statistics
from sightline.orchestrator.stepping.adaptive import grid
from sightline.orchestrator.system import System

HERE = Path(__file__).parent
EXAMPLE = HERE.parents[1] / "examples" / "los_formation" / "system.toml"
Run = Callable[..., tuple[np.ndarray, Statistics]]


@pytest.fixture
def formation(tmp_path: Path) -> Run:
    """Positions and attitudes of the example after 15 s, and what the run did."""

    def run(**simulation: object) -> tuple[np.ndarray, Statistics]:
        config = tmp_path / "system.toml"
        rest = "".join(f"{k} = {v!r}\n" for k, v in simulation.items())
        config.write_text(
            f'extends = "{EXAMPLE.as_posix()}"\nplots = []\n[simulation]\nstop_time = 15.0\n{rest}'
            "[record]\nevery = 3.0\n",
            encoding="utf-8",
        )
        statistics = System.from_toml(config).execute(tmp_path)
        results = read(tmp_path / "results.h5")
        np.testing.assert_array_equal(results.time, np.arange(6) * 3.0)
        ports = [results[f"craft{i}.{p}"] for i in (1, 2) for p in ("position", "attitude")]
        return np.hstack(ports), statistics

    return run


def test_reaches_1e_6_with_far_fewer_steps_than_holding_inputs(formation: Run) -> None:
    truth, _ = formation(step=0.001, coupling="quadratic")  # error 1e-10
    adaptive, statistics = formation(
        step=0.01, coupling="quadratic", algorithm="adaptive", tolerance=2e-9
    )
    held, few = formation(step=0.01)
    assert np.max(np.abs(adaptive - truth)) < 1e-6
    held_error = np.max(np.abs(held - truth))
    needed = few.steps * held_error / 1e-6  # the error of held inputs is of order one
    assert statistics.steps + statistics.rejected < needed / 200


def test_error_falls_with_the_tolerance(formation: Run) -> None:
    truth, _ = formation(step=0.001, coupling="quadratic")
    errors = []
    for tolerance in (1e-5, 1e-7, 1e-9):
        found, statistics = formation(
            step=0.01, coupling="quadratic", algorithm="adaptive", tolerance=tolerance
        )
        errors.append(np.max(np.abs(found - truth)))
    assert errors[0] > 5 * errors[1] > 25 * errors[2]
    assert statistics.rejected < statistics.steps / 4


def test_every_accepted_step_is_recorded_unless_asked_else(write, tmp_path) -> None:
    sampled = (HERE / "sampled.py").as_posix()
    path = write(
        ["a.z[1] -> p.u", "p.x -> a.u[2]"],
        simulation='[simulation]\nstop_time = 1.0\nstep = 0.04\nalgorithm = "adaptive"\n',
        a=f'component = "{sampled}:NoisyHold"\nparameters = {{ sample_period = 0.2 }}',
        p=f'component = "{sampled}:Follower"\nstart = {{ x = 1.0 }}',
    )  # fmt: skip
    system = System.from_toml(path)
    statistics = system.execute(tmp_path)
    results = read(tmp_path / "results.h5")
    assert len(results.time) == statistics.steps + 1
    assert set(0.2 * np.arange(5)) < set(results.time)  # sample instants, exactly
    assert results.time[-1] == 1.0
    assert np.all(np.diff(results.time) > 0.0)


def test_run_is_the_same_again(formation: Run) -> None:
    options = {"step": 0.01, "coupling": "linear", "algorithm": "adaptive", "tolerance": 1e-5}
    first, again = formation(**options), formation(**options)
    np.testing.assert_array_equal(first[0], again[0])
    assert first[1].rejected == again[1].rejected


def test_grid_meets_all_instants_once() -> None:
    instants = list(grid(0.0, 1.0, [0.25], [0.1, 0.5]))
    assert [i for i, _ in instants] == pytest.approx(
        [0.1, 0.2, 0.25, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0]
    )
    assert [i for i, recorded in instants if recorded] == [0.25, 0.5, 0.75, 1.0]


@pytest.fixture
def sampled(write) -> Callable[..., Path]:
    """A sampled block and a plant under error control, whose times have no common divisor."""

    def config(record: str = "") -> Path:
        blocks = (HERE / "sampled.py").as_posix()
        return write(
            ["a.z[1] -> p.u", "p.x -> a.u[2]"],
            simulation='[simulation]\nstop_time = 1.0\nstep = 0.03\nalgorithm = "adaptive"\n',
            rest=record,
            a=f'component = "{blocks}:NoisyHold"\nparameters = {{ sample_period = 0.2 }}',
            p=f'component = "{blocks}:Follower"\nstart = {{ x = 1.0 }}',
        )

    return config


def test_stop_and_record_instants_need_not_be_multiples_of_the_step(sampled, tmp_path) -> None:
    system = System.from_toml(sampled("[record]\nevery = 0.07\n"))
    results = system.simulate(tmp_path)
    np.testing.assert_array_equal(results.time, [*(0.07 * np.arange(15)), 1.0])


def test_sample_and_stop_instants_are_met_exactly(sampled, tmp_path) -> None:
    results = System.from_toml(sampled()).simulate(tmp_path)
    assert set(0.2 * np.arange(5)) < set(results.time)
    assert results.time[-1] == 1.0


def test_session_ends_at_the_stop_time(sampled) -> None:
    with System.from_toml(sampled()).start() as running:
        times = list(running)
    assert times[:2] == [0.03, 0.06]
    assert times[-2:] == [33 * 0.03, 1.0]


def test_steps_accepted_and_rejected_are_told(sampled, tmp_path, capsys) -> None:
    assert command_run.run(sampled(), tmp_path / "out", [], csv=False) == 0
    results = read(tmp_path / "out" / "results.h5")
    assert results.steps == len(results.time) - 1
    told = f"{results.steps} steps accepted, {results.rejected} rejected\n"
    assert told in capsys.readouterr().err
