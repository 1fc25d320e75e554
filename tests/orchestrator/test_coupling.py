"""How inputs vary inside a step: the error falls with the first, second or third power of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sightline.orchestrator.errors import RunError
from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

HERE = Path(__file__).parent
EXAMPLES = HERE.parents[1] / "examples"
ORDERS = {"hold": 1.0, "linear": 2.0, "quadratic": 3.0}
Run = Callable[[float, str], Results]


def block(name: str, table: str = "", target: str = "native") -> str:
    return f'component = "{(HERE / "blocks.py").as_posix()}:{name}"\ntarget = "{target}"\n{table}'


@pytest.fixture
def oscillator(write, tmp_path: Path) -> Callable[..., Results]:
    """x'' = -x from two FMUs; x(0) = 1, x'(0) = 0.5."""

    def run(step: float, coupling: str, algorithm: str = "gauss-seidel", every: str = "",
            target: str = "native") -> Results:  # fmt: skip
        blocks = tmp_path / "oscillator.py"
        blocks.write_text(
            "from sightline.components import Component, Input, State\n"
            "class Rate(Component):\n    '''v' = -x'''\n"
            "    x = Input((), 'm', doc='position')\n"
            "    v = State((), 'm/s', output=True, doc='velocity')\n"
            "    def derivatives(self, x):\n        return {'v': -x}\n",
            encoding="utf-8",
        )
        path = write(
            ["rate.v -> place.u", "place.x -> rate.x"],
            simulation=f'[simulation]\nstop_time = 2.4\nstep = {step}\ncoupling = "{coupling}"\n'
                       f'algorithm = "{algorithm}"\n',
            rate=f'component = "oscillator.py:Rate"\ntarget = "{target}"\n'
                 f'start = {{ v = 0.5 }}\n{every}',
            place=block("Integrator", "start = { x = 1.0 }", target),
        )  # fmt: skip
        return System.from_toml(path).simulate(tmp_path / "out")

    return run


def slope(errors: list[float]) -> float:
    """The power of the step, from the last two of errors at halved steps."""
    return float(np.log2(errors[-2] / errors[-1]))


@pytest.mark.parametrize("coupling", ORDERS)
@pytest.mark.parametrize("algorithm", ["gauss-seidel", "jacobi"])
def test_error_falls_with_the_order(oscillator, coupling, algorithm) -> None:
    errors = [error(oscillator(step, coupling, algorithm)) for step in (0.04, 0.02, 0.01)]
    assert slope(errors) == pytest.approx(ORDERS[coupling], abs=0.12)  # the next order at 10 ms


@pytest.mark.parametrize("coupling", ORDERS)
def test_output_of_a_slow_fmu_is_held_whatever_the_coupling(oscillator, coupling) -> None:
    errors = [error(oscillator(step, coupling, every="every = 2")) for step in (0.02, 0.01)]
    assert slope(errors) > 0.9


def error(results: Results) -> float:
    """Of the position, at the points where both FMUs have stepped."""
    time = results.time[::2]
    truth = np.cos(time) + 0.5 * np.sin(time)
    return float(np.max(np.abs(results["place.x"][::2] - truth)))


def test_fmus_without_derivatives_of_inputs_hold_them(oscillator) -> None:
    held, linear = (oscillator(0.1, c, target="python") for c in ("hold", "linear"))
    np.testing.assert_array_equal(held["place.x"], linear["place.x"])


def test_sampled_signals_are_held(write, tmp_path) -> None:
    sampled = (HERE / "sampled.py").as_posix()
    values = []
    for coupling in ("hold", "quadratic"):
        path = write(
            ["a.z[1] -> p.u"],
            simulation=f'[simulation]\nstop_time = 1.0\nstep = 0.05\ncoupling = "{coupling}"\n',
            a=f'component = "{sampled}:NoisyHold"\nparameters = {{ sample_period = 0.2 }}',
            p=f'component = "{sampled}:Follower"',
        )  # fmt: skip
        values.append(System.from_toml(path).simulate(tmp_path / coupling)["p.x"])
    np.testing.assert_array_equal(values[0], values[1])


def final_state(
    example: str, step: float, coupling: str, folder: Path, algorithm: str = "gauss-seidel"
) -> np.ndarray:
    """All outputs that are recorded, at the last rows of a short run."""
    config = folder / "system.toml"
    config.write_text(
        f'extends = "{(EXAMPLES / example / "system.toml").as_posix()}"\nplots = []\n'
        f'[simulation]\nstop_time = 12.0\nstep = {step}\ncoupling = "{coupling}"\n'
        f'algorithm = "{algorithm}"\n'
        "[record]\nevery = 1.2\n",
        encoding="utf-8",
    )
    results = System.from_toml(config).simulate(folder / "out")
    names = [n for n in results.series if n.split(".")[1] in ("position", "velocity", "attitude")]
    assert names
    return np.hstack([results[n] for n in names])


@pytest.mark.parametrize("example", ["los_formation", "relative_attitude"])
def test_error_of_an_example_falls_with_the_order(example: str, tmp_path: Path) -> None:
    if not (EXAMPLES / example / "system.toml").exists():
        pytest.skip(f"{example} is not here yet")
    truth = final_state(example, 0.0005, "quadratic", tmp_path)  # error (1/25)³ of the smallest
    for coupling, order in ORDERS.items():
        errors = [
            float(np.max(np.abs(final_state(example, step, coupling, tmp_path) - truth)))
            for step in (0.025, 0.0125)
        ]
        assert slope(errors) == pytest.approx(order, abs=0.15), coupling


@pytest.mark.parametrize("example", ["los_formation", "relative_attitude"])
def test_extrapolated_directions_stay_directions(example: str, tmp_path: Path) -> None:
    """Under Jacobi attitudes and lines of sight are extrapolated, and their blocks accept them."""
    truth = final_state(example, 0.0005, "quadratic", tmp_path)
    errors = [
        float(np.max(np.abs(final_state(example, step, "linear", tmp_path, "jacobi") - truth)))
        for step in (0.025, 0.0125)
    ]
    assert slope(errors) == pytest.approx(2.0, abs=0.1)


def test_unstable_extrapolation_is_told_with_a_remedy(tmp_path: Path) -> None:
    with pytest.raises(RunError) as raised:
        final_state("los_formation", 0.05, "quadratic", tmp_path, "jacobi")
    assert 'set algorithm = "gauss-seidel", coupling = "hold" or a' in raised.value.__notes__[0]
