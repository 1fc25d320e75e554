"""The compiled stepper against the reference in Python: the same bits, the same errors."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.errors import RunError
from sightline.orchestrator.stepping.starting import STEPPER
from sightline.orchestrator.system import System

if find_spec("sightline.orchestrator.stepping._loop") is None:
    pytest.skip("built without a compiler", allow_module_level=True)
HERE = Path(__file__).parent
EXAMPLE = HERE.parents[1] / "examples" / "los_formation" / "system.toml"
STEPPERS = ("python", "compiled")
Both = Callable[[Path], list[bytes]]


@pytest.fixture
def both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Both:
    """The results files of both steppers."""

    def run(config: Path) -> list[bytes]:
        system = System.from_toml(config)
        files = []
        for name in STEPPERS:
            monkeypatch.setenv(STEPPER, name)
            system.simulate(tmp_path / name)
            files.append((tmp_path / name / "results.h5").read_bytes())
        return files

    return run


@pytest.mark.parametrize(
    ("algorithm", "coupling"),
    [(a, c) for a in ("gauss-seidel", "adaptive") for c in ("hold", "linear", "quadratic")]
    + [("jacobi", "hold"), ("jacobi", "linear")],
)
def test_formation_is_the_same_to_the_bit(both: Both, tmp_path, algorithm, coupling) -> None:
    config = tmp_path / "system.toml"
    config.write_text(
        f'extends = "{EXAMPLE.as_posix()}"\nplots = []\n[simulation]\nstop_time = 1.0\n'
        f'algorithm = "{algorithm}"\ncoupling = "{coupling}"\n[record]\nevery = 0.02\n',
        encoding="utf-8",
    )
    python, compiled = both(config)
    assert python == compiled


@pytest.mark.parametrize("target", ["native", "python"])
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
def test_noise_samples_rates_and_parts_are_the_same(both: Both, write, target, algorithm) -> None:
    sampled = f'component = "{(HERE / "sampled.py").as_posix()}:NoisyHold"\ntarget = "{target}"\n'
    plant = f'component = "{(HERE / "sampled.py").as_posix()}:Follower"\ntarget = "{target}"\n'
    config = write(
        ["p.x -> a.u[1]", "a.z -> b.u", "b.z[1] -> p.u"],
        simulation=f'[simulation]\nstop_time = 2.0\nstep = 0.05\nalgorithm = "{algorithm}"\n',
        a=sampled + "parameters = { sample_period = 0.1, seed = 3 }",
        b=sampled + "parameters = { sample_period = 0.2 }\nevery = 2",
        p=plant + "start = { x = 1.0 }\nmax_step = 0.02",
    )
    python, compiled = both(config)
    assert python == compiled


def test_integers_and_booleans_are_the_same(both: Both, write) -> None:
    switch = f'component = "{(HERE / "blocks.py").as_posix()}:Switch"\n'
    config = write(
        ["a.count -> b.count_in", "a.on -> b.on_in"],
        simulation="[simulation]\nstop_time = 3.0\nstep = 0.5\n", a=switch, b=switch,
    )  # fmt: skip
    python, compiled = both(config)
    assert python == compiled


def test_units_are_converted_alike(both: Both, write, tmp_path) -> None:
    (tmp_path / "far.py").write_text(
        "from sightline.components import Component, Input, Output\n"
        "class Far(Component):\n    '''y = x'''\n"
        "    x = Input((), 'km', doc='input')\n    y = Output((), 'km', doc='output')\n"
        "    def outputs(self, x):\n        return {'y': x * 1.0}\n",
        encoding="utf-8",
    )
    plant = f'component = "{(HERE / "blocks.py").as_posix()}:Integrator"\n'
    config = write(
        ["plant.x -> far.x"], far='component = "far.py:Far"',
        plant=plant + "start = { x = 0.1, u = 0.3 }",
    )  # fmt: skip
    python, compiled = both(config)
    assert python == compiled


@pytest.mark.parametrize("target", ["native", "python"])
def test_errors_read_the_same(write, tmp_path, monkeypatch, target) -> None:
    blocks = (HERE / "blocks.py").as_posix()
    system = System.from_toml(write(
        ["plant.x -> control.x"],
        plant=f'component = "{blocks}:Integrator"\ntarget = "{target}"\nstart = {{ u = 1.0 }}',
        control=f'component = "{blocks}:Gain"\ntarget = "{target}"\n'
                "parameters = { limit = 0.45 }",
    ))  # fmt: skip
    texts, rows = [], []
    for name in STEPPERS:
        monkeypatch.setenv(STEPPER, name)
        with pytest.raises(RunError) as caught:
            system.simulate(tmp_path / name)
        texts.append(str(caught.value))
        rows.append((tmp_path / name / "results.h5").read_bytes())
    assert texts[0] == texts[1]
    assert "control at t = 0.4 s: the step of 0.1 s ended with" in texts[0]
    assert rows[0] == rows[1]


def test_environment_chooses_the_stepper(monkeypatch) -> None:
    from sightline.orchestrator.stepping.compiled import CompiledStepper
    from sightline.orchestrator.stepping.starting import stepper_class
    from sightline.orchestrator.stepping.stepper import PythonStepper

    monkeypatch.delenv(STEPPER, raising=False)
    assert stepper_class() is CompiledStepper
    monkeypatch.setenv(STEPPER, "python")
    assert stepper_class() is PythonStepper


def test_types_of_numpy_have_codes() -> None:
    from sightline.orchestrator.stepping._loop import TYPES

    assert set(TYPES) == {np.dtype(t).str[1:] for t in (
        "f8", "f4", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "?",
    )}  # fmt: skip
