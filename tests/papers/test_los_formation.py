"""Example 5.1 of the line-of-sight paper, co-simulated from its config with real FMUs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "los_formation"
TABLE = {  # computed by DOP853 at 1e-11: t -> (Ψ1, d)
    0: (1.999507, 25.0), 1: (1.999213, 25.165745), 5: (1.988074, 28.181139),
    10: (1.665095, 33.831457), 15: (0.1799513, 38.889653), 30: (1.034881e-3, 45.155941),
    60: (1.560903e-4, 32.762045), 100: (3.1013e-5, 18.022270), 200: (6.7e-10, 20.349935),
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    """The run that the example's config describes: 200 s at 10 ms."""
    system = System.from_toml(EXAMPLE / "system.toml")
    return system.simulate(tmp_path_factory.mktemp("los_formation"))


def variant(folder: Path, base: str, **simulation: object) -> Results:
    """A run of one of the example's configs with other simulation settings."""
    lines = [f"extends = '{EXAMPLE / base}'", "[simulation]"]
    lines += [f"{name} = {value!r}" for name, value in simulation.items()]
    config = folder / "variant.toml"
    config.write_text("\n".join(lines), encoding="utf-8")
    return System.from_toml(config).simulate(folder)


def at(results: Results, time: float, signal: str) -> np.ndarray:
    return results[signal][np.argmin(np.abs(results.time - time))]


@pytest.mark.parametrize("time", TABLE)
def test_the_attitude_error_is_within_2_percent_of_the_table(
    results: Results, time: float
) -> None:
    assert at(results, time, "monitor.alignment_error") == pytest.approx(TABLE[time][0], rel=0.02)


@pytest.mark.parametrize("time", TABLE)
def test_the_distance_is_within_5_cm_of_the_table(results: Results, time: float) -> None:
    assert at(results, time, "range12.range") == pytest.approx(TABLE[time][1], abs=0.05)


def test_halving_the_step_halves_the_error(tmp_path: Path) -> None:
    errors = []
    for step in (0.02, 0.01, 0.005):
        run = variant(tmp_path, "system.toml", stop_time=30.0, step=step)
        errors.append([at(run, 10, "monitor.alignment_error") - TABLE[10][0],
                       at(run, 30, "range12.range") - TABLE[30][1]])
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    np.testing.assert_allclose(ratios, 2.0, rtol=0.05)  # first order, with its h^2 remainder


def test_the_lyapunov_function_falls_at_the_rate_of_its_formula(results: Results) -> None:
    V, rate = results["monitor.lyapunov"], results["monitor.lyapunov_rate"]
    slope = np.gradient(V, results.time, edge_order=2)
    # held forces and 0.1 s between samples: 0.2 % of the largest rate
    np.testing.assert_allclose(slope, rate, rtol=0, atol=2e-3 * np.max(np.abs(rate)))
    assert np.all(rate <= 0.0)


def test_the_largest_torques_are_those_computed(results: Results) -> None:
    peaks = np.max(np.abs(results["control1.torque"]), axis=0)
    np.testing.assert_allclose(peaks, [2.71e-3, 2.67e-3, 3.5e-4], rtol=0.01)


def test_attitudes_stay_unit_quaternions(results: Results) -> None:
    norms = np.linalg.norm(results["craft2.attitude"], axis=1)
    np.testing.assert_allclose(norms, 1.0, rtol=0, atol=1e-15)


def test_allocation_and_thrusters_give_the_same_trajectory(tmp_path: Path) -> None:
    names = ("direct", "thrusters")
    direct, thrusters = (
        variant(tmp_path / name, base, stop_time=20.0)
        for name, base in zip(names, ("system.toml", "thrusters.toml"), strict=True)
        if (tmp_path / name).mkdir() is None
    )
    for port in ("position", "velocity", "attitude", "angular_velocity"):
        np.testing.assert_allclose(
            thrusters[f"craft2.{port}"], direct[f"craft2.{port}"], rtol=0, atol=1e-11
        )


def test_jacobi_has_more_delay_and_so_more_error(tmp_path: Path) -> None:
    jacobi = variant(tmp_path, "system.toml", stop_time=15.0, algorithm="jacobi")
    error = abs(at(jacobi, 15, "monitor.alignment_error") / TABLE[15][0] - 1.0)
    assert 0.0027 < error < 0.05  # Gauss-Seidel has 0.27 %; two more steps of delay
