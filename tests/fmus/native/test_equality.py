"""Every block's native FMU computes what its numpy equations compute."""

from __future__ import annotations

import numpy as np
import pytest

from sightline.components.declarations import Noise
from sightline.fmus.python.noise import fnv1a, normal_draws

from .driver import Native
from .samples import acceptable, random_values

STATE_KINDS = ("input", "parameter", "state", "discrete")
EXACT = 1e-12  # of the largest element: the same operations, a few of them in another order


def close(
    native: Native, found: np.ndarray, expected: np.ndarray, scale: float = 1e-300
) -> bool:
    scale = np.max(np.abs(expected), initial=scale)
    return bool(np.all(np.abs(found - expected) <= EXACT * scale))


def settings(native: Native, period: float) -> dict[str, float]:
    """A sample period, and a seed where there is noise."""
    wanted = {"sample_period": period, "seed": 7}
    return {n: v for n, v in wanted.items() if n in native.model.by_name}


@pytest.mark.parametrize("period", [0.0, 0.25], ids=["continuous", "sampled"])
def test_outputs_and_rates_equal_numpy_at_random_values(
    block_fmu: Native, period: float
) -> None:
    rng = np.random.default_rng(3)
    block, model = block_fmu.model.block, block_fmu.model
    for trial in range(5):
        name = f"instance {trial}"
        values = random_values(rng, model, *STATE_KINDS) | settings(block_fmu, period)
        fmu = block_fmu.instance(name)
        fmu.set(**values)
        fmu.enter(start=3.0)
        noises = block.of_type(Noise).values()
        draws = {
            n.name: normal_draws(7, fnv1a(name), 0, channel, n.size).reshape(n.dimensions)
            if period else np.zeros(n.dimensions) for channel, n in enumerate(noises)
        }  # fmt: skip
        known = {n: np.asarray(v, dtype=float) for n, v in values.items()}
        known |= draws | {"time": np.array(3.0)}
        for equation, form in (("outputs", "{}"), ("derivatives", "der({})")):
            if block.has(equation):
                with np.errstate(all="ignore"):
                    expected = block.evaluate(equation, known)
                for port, value in expected.items():
                    found = fmu.get(form.format(port))
                    assert close(block_fmu, found, np.asarray(value)), port
        fmu.fmu.freeInstance()


def test_a_thousand_random_steps_equal_the_python_target(block_fmu: Native) -> None:
    rng = np.random.default_rng(5)
    model = block_fmu.model
    ours, reference = block_fmu.instance("näme"), block_fmu.reference("näme")

    def set_both(values: dict[str, np.ndarray]) -> None:
        ours.set(**values)
        for name, value in values.items():
            reference.set(list(model.by_name[name].references), np.ravel(value).tolist())

    start = random_values(rng, model, "parameter", "state", "discrete")
    start |= {n: np.array(v) for n, v in settings(block_fmu, 0.07).items()}
    if acceptable(block_fmu, start):
        set_both(start)
    else:
        set_both({n: np.array(v) for n, v in settings(block_fmu, 0.07).items()})
    reference.initialise(0.3)
    reference.initialise(0.3)
    ours.initialise(0.3)
    time = 0.3
    largest: dict[str, float] = {}  # an error made while a value was large stays when it is small
    ports = [v for v in model.variables if v.is_output or v.kind in ("state", "discrete")]
    for _ in range(1000 if block_fmu.fmi == 2 else 100):
        set_both(random_values(rng, model, "input"))
        h = float(rng.choice([0.01, 0.03, 0.07, 0.2]))
        for phase in range(2):
            if rng.integers(2):
                for port in ports:
                    expected = reference.get(list(port.references)).reshape(port.shape)
                    largest[port.name] = np.max(np.abs(expected),
                                                initial=largest.get(port.name, 1e-300))
                    assert close(block_fmu, ours.get(port.name), expected,
                                 largest[port.name]), port.name  # fmt: skip
            if phase == 0:
                ours.step(time, h)
                reference.step(time, h)
                time += h
