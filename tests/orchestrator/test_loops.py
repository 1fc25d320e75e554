"""Algebraic loops of real FMUs: solved, broken where asked, refused with names and residuals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.errors import LoopError
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

HERE = Path(__file__).parent
K1, C1 = np.array([[0.3, -0.5], [0.4, 0.2]]), np.array([1.0, 2.0])
SIMULATION = "[simulation]\nstop_time = 0.3\nstep = 0.1\n"
PAIR = ["a.y -> b.u", "b.y -> a.u"]


def block(name: str, table: str = "", target: str = "native") -> str:
    path = (HERE / "sampled.py").as_posix()
    return f'component = "{path}:{name}"\ntarget = "{target}"\n{table}'


@pytest.mark.parametrize("target", ["native", "python"])  # Newton; Anderson
@pytest.mark.parametrize("stepper", ["python", "compiled"])
def test_linear_loop_is_solved_exactly(write, tmp_path, monkeypatch, target, stepper) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    path = write(PAIR, a=block("Affine", target=target), b=block("Affine", target=target),
                 simulation=SIMULATION)  # fmt: skip
    results = System.from_toml(path).simulate(tmp_path)
    y = np.linalg.solve(np.eye(2) - K1, C1)  # both FMUs are alike: y = K y + c
    # the tolerance of loops is 1e-9 of 1 + |u|
    np.testing.assert_allclose(results["a.y"], np.tile(y, (4, 1)), rtol=1e-8)
    np.testing.assert_allclose(results["b.y"], np.tile(y, (4, 1)), rtol=1e-8)


@pytest.mark.parametrize("target", ["native", "python"])
def test_nonlinear_loop_follows_its_solution(write, tmp_path, target) -> None:
    path = write(["a.y -> a.u"], a=block("Cosine", target=target), simulation=SIMULATION)
    results = System.from_toml(path).simulate(tmp_path)
    np.testing.assert_allclose(results["a.y"], 0.7390851332151607, rtol=1e-8)  # cos y = y


def test_fmu_after_the_loop_sees_its_solution(write, tmp_path) -> None:
    path = write(
        ["a.y -> a.u", "a.y -> f.u1"], f=block("Crossed"), a=block("Cosine"),
        simulation=SIMULATION,
    )  # fmt: skip
    results = System.from_toml(path).simulate(tmp_path)
    np.testing.assert_array_equal(results["f.y2"], 2.0 * results["a.y"])


def test_loop_without_solution_is_an_error_with_residuals(write, tmp_path) -> None:
    stiff = "parameters = { k = [[1.0, 0.0], [0.0, 1.0]], c = [1.0, 0.0] }"
    path = write(["a.y -> a.u"], a=block("Affine", stiff), simulation=SIMULATION)  # y = y + 1
    with pytest.raises(LoopError, match=r"a at t = 0 s: the algebraic loop does not converge") as e:
        System.from_toml(path).simulate(tmp_path)
    assert set(e.value.residuals) == {"a.u[1]", "a.u[2]"}
    assert abs(e.value.residuals["a.u[1]"]) == pytest.approx(1.0)
    assert "let one connection be a step late: simulation.delay" in str(e.value)


def test_broken_loop_is_one_step_late(write, tmp_path) -> None:
    text = SIMULATION + 'delay = ["a.y -> a.u"]\n'
    path = write(["a.y -> a.u"], a=block("Cosine"), simulation=text)
    y = System.from_toml(path).simulate(tmp_path)["a.y"]
    np.testing.assert_allclose(y[1:], np.cos(y[:-1]), rtol=1e-15)


@pytest.mark.parametrize("stepper", ["python", "compiled"])
def test_crossed_fmus_pass_values_of_one_instant(write, tmp_path, monkeypatch, stepper) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    crossed = ["a.y2 -> b.u1", "b.y1 -> a.u1"]
    path = write(crossed, a=block("Crossed"), b=block("Crossed"), simulation=SIMULATION)
    results = System.from_toml(path).simulate(tmp_path)
    np.testing.assert_allclose(results["b.y2"], 4.0 * results.time, rtol=1e-15)


def test_mutual_feeding_is_resolved_variable_by_variable(write, tmp_path) -> None:
    crossed = ["a.y2 -> b.u1", "b.y1 -> a.u1", "b.y2 -> c.u1", "a.y1 -> c.u2", "c.y1 -> b.u2"]
    tables = {name: block("Crossed") for name in "abc"}
    results = System.from_toml(write(crossed, simulation=SIMULATION, **tables)).simulate(tmp_path)
    np.testing.assert_allclose(results["c.y2"], 8.0 * results.time, rtol=1e-15)
