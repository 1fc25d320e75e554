"""FMI 3.0: arrays, event mode and all types, against the same blocks in FMI 2.0."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.orchestrator.fmi.archive import read
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

HERE = Path(__file__).parent
VERSIONS = (2, 3)


@pytest.fixture
def fmu(fmu_cache: None):
    """The table of an instance of a test block in one version of FMI."""

    def table(name: str, fmi: int, rest: str = "") -> str:
        file = HERE / ("blocks.py" if name in ("Integrator", "Switch") else "sampled.py")
        path = build(f"{file}:{name}", target="native", fmi=fmi)
        return f'fmu = "{path.as_posix()}"\n{rest}'

    return table


def test_arrays_and_scalars_are_ports_of_one_shape(fmu) -> None:
    two, three = (read(Path(fmu("NoisyHold", v).split('"')[1])) for v in VERSIONS)
    assert three.version == "3.0"
    assert {n: p.shape for n, p in two.outputs.items()} == {
        n: p.shape for n, p in three.outputs.items()
    }
    assert len(set(three.ports["u"].references)) == 1
    assert three.event_mode


@pytest.mark.parametrize("version", VERSIONS)
def test_fmu_tells_frames_and_which_inputs_are_optional(fmu_cache: None, version: int) -> None:
    fmu = read(build("FreeRigidBody", target="native", fmi=version))
    told = {name: (port.frame, port.optional) for name, port in fmu.inputs.items()}
    assert told == {
        "force": ("body", False), "torque": ("body", False),
        "disturbance_force": ("inertial", True), "disturbance_torque": ("body", True),
    }  # fmt: skip
    assert fmu.ports["attitude"].frame == "body"


@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
@pytest.mark.parametrize("step", [0.05, 0.07])  # samples at the points, and between them
@pytest.mark.parametrize("stepper", ["python", "compiled"])
def test_both_versions_compute_the_same(
    write, fmu, tmp_path, monkeypatch, algorithm, step, stepper
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    results = []
    for version in VERSIONS:
        sampled = "parameters = { sample_period = 0.1, seed = 3 }"
        config = write(
            ["p.x -> a.u[1]", "a.z[1] -> p.u"],
            simulation=f'[simulation]\nstop_time = {40 * step}\nstep = {step}\n'
                       f'algorithm = "{algorithm}"\n',
            a=fmu("NoisyHold", version, sampled + "\nstart = { u = [0.5, 2.0] }"),
            p=fmu("Follower", version, "start = { x = 1.0 }"),
        )  # fmt: skip
        results.append(System.from_toml(config).simulate(tmp_path / str(version)))
    for name in ("a.z", "p.x"):
        np.testing.assert_array_equal(results[0][name], results[1][name], err_msg=name)


def test_discrete_state_is_that_after_the_event(write, fmu, tmp_path) -> None:
    sampled = "parameters = { sample_period = 0.1 }"
    config = write(a=fmu("NoisyHold", 2, sampled), b=fmu("NoisyHold", 3, sampled))
    results = System.from_toml(config).simulate(tmp_path)
    # without event mode a sample at the present instant stands only when time goes on
    np.testing.assert_array_equal(results["a.count"], np.arange(11))
    np.testing.assert_array_equal(results["b.count"], np.arange(11) + 1)


@pytest.mark.parametrize("stepper", ["python", "compiled"])
def test_integers_and_booleans_pass_between_versions(
    write, fmu, tmp_path, monkeypatch, stepper
) -> None:
    monkeypatch.setenv(STEPPER, stepper)
    config = write(
        ["a.count -> b.count_in", "a.on -> b.on_in"],
        simulation="[simulation]\nstop_time = 3.0\nstep = 1.0\n",
        a=fmu("Switch", 2), b=fmu("Switch", 3),
    )  # fmt: skip
    results = System.from_toml(config).simulate(tmp_path)
    np.testing.assert_array_equal(results["b.echo"], [0, 1, 102, 103])
    assert (results["b.count"].dtype, results["b.on"].dtype) == (np.int32, np.uint8)


def test_idle_elements_of_a_driven_array_keep_their_start(write, fmu, tmp_path) -> None:
    config = write(
        ["p.y1 -> a.u[1]"], p=fmu("Crossed", 2), a=fmu("Affine", 3, "start = { u = [0.0, 1.0] }"),
    )  # fmt: skip
    results = System.from_toml(config).simulate(tmp_path)
    idle = np.array([1.0 - 0.5, 2.0 + 0.2])
    y = np.outer(results.time, [0.3, 0.4]) + idle  # k u + c with u = (t, 1)
    np.testing.assert_allclose(results["a.y"], y, rtol=1e-15)


def test_loop_of_arrays_is_solved_with_their_derivatives(write, fmu, tmp_path) -> None:
    config = write(["a.y -> b.u", "b.y -> a.u"], a=fmu("Affine", 3), b=fmu("Affine", 3))
    results = System.from_toml(config).simulate(tmp_path)
    k, c = np.array([[0.3, -0.5], [0.4, 0.2]]), np.array([1.0, 2.0])
    y = np.linalg.solve(np.eye(2) - k, c)
    np.testing.assert_allclose(results["a.y"], np.tile(y, (11, 1)), rtol=1e-8)  # loop tolerance
