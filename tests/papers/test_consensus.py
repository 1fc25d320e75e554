"""Examples 1 to 3 of the attitude consensus paper, co-simulated from their configs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLES = Path(__file__).parents[2] / "examples"
ANGLES = {  # computed by DOP853, rad
    "consensus": {1: 2.022402, 5: 2.294547, 10: 0.4249535, 15: 0.2609871, 30: 0.0458350,
                  60: 1.61364e-3, 100: 1.790e-5},
    "consensus_switched": {1: 2.004044, 5: 1.882201, 10: 1.862154, 15: 1.860071, 30: 1.859826,
                           60: 4.55213e-3, 100: 6.92e-6},
}  # fmt: skip
CASES = [(name, time) for name, angles in ANGLES.items() for time in angles]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Results]:
    """The runs that the examples' configs describe, at 1 ms."""
    systems = {
        name: System.from_toml(EXAMPLES / name / "system.toml")
        for name in (*ANGLES, "consensus_fixed_axis")
    }
    return {name: s.simulate(tmp_path_factory.mktemp(name)) for name, s in systems.items()}


@pytest.mark.parametrize(("name", "time"), CASES)
def test_the_relative_angle_is_within_1_percent_of_the_table(
    runs: dict[str, Results], name: str, time: float
) -> None:
    run = runs[name]
    angle = run["monitor.relative_angle"][np.argmin(np.abs(run.time - time))]
    assert angle == pytest.approx(ANGLES[name][time], rel=0.01)


def test_damping_alone_gives_the_closed_form(runs: dict[str, Results]) -> None:
    run = runs["consensus_fixed_axis"]
    decay, zero = 0.2 * np.exp(-0.45 * run.time), np.zeros_like(run.time)
    first = np.stack([3.7 / 9.0 + 4.0 / 9.0 * decay, zero, zero], axis=1)
    second = np.stack([zero, 3.7 / 9.0 - 5.0 / 9.0 * decay, zero], axis=1)
    np.testing.assert_allclose(run["craft1.angular_velocity"], first, atol=2e-5)  # held: 1e-5
    np.testing.assert_allclose(run["craft2.angular_velocity"], second, atol=2e-5)


@pytest.mark.parametrize("name", ANGLES)
def test_the_angular_momentum_stays_but_for_the_held_torques(
    runs: dict[str, Results], name: str
) -> None:
    momentum = runs[name]["monitor.angular_momentum"]
    np.testing.assert_allclose(momentum, np.broadcast_to(momentum[0], momentum.shape), atol=2e-3)


def test_the_energy_never_rises_after_the_switch(runs: dict[str, Results]) -> None:
    run = runs["consensus_switched"]
    energy = run["monitor.energy"][run.time >= 30.0]
    assert np.diff(energy).max() < 1e-6  # held torques: rounding of the order of the step squared


def test_the_attitudes_differ_until_the_switch(runs: dict[str, Results]) -> None:
    run = runs["consensus_switched"]
    assert run["monitor.relative_angle"][run.time <= 30.0].min() > 1.8


@pytest.mark.parametrize(("name", "stop_time"), [
    ("consensus", 10.0), ("consensus_fixed_axis", 10.0), ("consensus_switched", 34.0),
])
def test_halving_the_step_of_held_torques_halves_the_error(
    tmp_path: Path, name: str, stop_time: float
) -> None:
    ends = []
    for step in (0.008, 0.004, 0.002):
        settings = {"simulation.step": step, "simulation.stop_time": stop_time, "record.every": 2.0}
        run = System.from_toml(EXAMPLES / name / "system.toml", settings).simulate(tmp_path)
        ends.append(np.concatenate([run[f"craft{i}.angular_velocity"][-1] for i in (1, 2)]))
    coarse, fine = np.linalg.norm(np.diff(ends, axis=0), axis=1)
    assert coarse / fine == pytest.approx(2.0, rel=0.05)  # first order, with its h^2 remainder
