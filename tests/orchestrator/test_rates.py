"""FMUs that step at every n-th communication point, or in parts."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sightline.orchestrator.system import System

from .conftest import variable

HERE = Path(__file__).parent
BLOCKS = (HERE / "blocks.py").as_posix()
LOOP = ["plant.x -> control.x", "control.y -> plant.u"]


SUM = f'component = "{(HERE / "sampled.py").as_posix()}:TimeIntegral"\nevery = 2'


def block(name: str, table: str = "") -> str:
    return f'component = "{BLOCKS}:{name}"\n{table}'


def test_slow_controller_holds_its_output_between_its_steps(write, tmp_path: Path) -> None:
    path = write(
        LOOP, simulation="[simulation]\nstop_time = 0.6\nstep = 0.1\n",
        control=block("Gain", "every = 3"), plant=block("Integrator", "start = { x = 1.0 }"),
    )  # fmt: skip
    results = System.from_toml(path).simulate(tmp_path)
    x = [1.0, 0.9, 0.8, 0.7, 0.63, 0.56, 0.49]  # u = -1, then -0.7 from 0.3 s on
    np.testing.assert_allclose(results["plant.x"], x, rtol=1e-14)
    y = [-1.0, -1.0, -1.0, -0.7, -0.7, -0.7, -0.49]
    np.testing.assert_allclose(results["control.y"], y, rtol=1e-14)


def test_slow_plant_catches_up(write, tmp_path: Path) -> None:
    path = write(
        ["fast.t -> slow.u"], simulation="[simulation]\nstop_time = 0.4\nstep = 0.1\n",
        fast=block("Clock"), slow=SUM,
    )  # fmt: skip
    results = System.from_toml(path).simulate(tmp_path)
    # the slow one's input over a step is the value at its end, that of the same instant
    expected = [0.0, 0.0, 0.04, 0.04, 0.12]
    np.testing.assert_allclose(results["slow.x"], expected, atol=1e-15)


def test_parts_do_not_change_a_held_integration(write, tmp_path: Path) -> None:
    whole = write(a=block("Integrator", "start = { u = 1.0 }"), name="whole.toml")
    parts = write(a=block("Integrator", "start = { u = 1.0 }\nmax_step = 0.03"), name="parts.toml")
    results = [System.from_toml(p).simulate(tmp_path) for p in (whole, parts)]
    np.testing.assert_allclose(results[0]["a.x"], results[1]["a.x"], rtol=1e-14)
    assert System.from_toml(parts).plan.units[0].parts == 4


def test_rates_that_do_not_divide_name_the_remedy(write, problems) -> None:
    path = write(
        LOOP, simulation="[simulation]\nstop_time = 0.6\nstep = 0.1\n",
        control=block("Gain", "every = 2"), plant=block("Integrator", "every = 3"),
    )  # fmt: skip
    assert problems(path) == [
        "system.toml:15: instances.plant.every: 3 is not a multiple of control's 2; plant.x -> "
        "control.x connects them; nearest: 2 or 4"
    ]


def test_rate_that_does_not_divide_the_run_names_the_nearest_stop(write, problems) -> None:
    assert problems(write(a=block("Integrator", "every = 4"))) == [
        "system.toml:9: instances.a.every: 4 steps do not divide the run's 10; nearest stop_time: "
        "0.8"
    ]


def test_solver_of_fixed_step_needs_multiples(write, problems, make_fmu) -> None:
    head = '<CoSimulation modelIdentifier="{name}" fixedInternalStepSize="0.04"/>'
    make_fmu("stiff", [variable("y", "output")], head=head)
    assert problems(write(a='fmu = "stiff.fmu"')) == [
        "system.toml:7: instances.a: stiff steps by 0.04, of which 0.1 is no multiple; let step · "
        "every be a multiple of 0.04"
    ]


def test_adaptive_steps_need_fmus_that_go_back(write, problems, make_fmu) -> None:
    make_fmu("fixed", [variable("y", "output")])
    text = '[simulation]\nstop_time = 1.0\nstep = 0.1\nalgorithm = "adaptive"\n'
    assert problems(write(a='fmu = "fixed.fmu"', simulation=text)) == [
        "system.toml:6: simulation.algorithm: a (fixed) cannot restore its state and takes steps "
        'of one size only; set algorithm = "gauss-seidel"'
    ]
