"""Every equation of every block traces to CasADi and gives there what it gives in numpy."""

import casadi as ca
import numpy as np
import pytest

from sightline.components import catalogue
from sightline.components.component import EQUATIONS

CASES = [
    pytest.param(block, equation, seed, id=f"{name}.{equation}-{seed}")
    for name, block in catalogue.blocks().items()
    for equation in EQUATIONS
    if block().has(equation)
    for seed in (0, 1)
]


@pytest.fixture(autouse=True, scope="module")
def _numpy_mode():
    before = ca.GlobalOptions.getNumpyMode()
    ca.GlobalOptions.setNumpyMode(1)
    yield
    ca.GlobalOptions.setNumpyMode(before)


def random_values(block, seed):
    """Values near the start values, where every block is well conditioned; booleans of both."""
    rng = np.random.default_rng(seed)
    values = {
        name: np.full(q.dimensions, float(seed)) if q.type == "boolean"
        else q.value + 0.1 * rng.random(q.dimensions)
        for name, q in block.quantities.items()
    }
    return values | {"time": rng.random(())}


def evaluate_traced(block, equation, values):
    """The equation's results through a CasADi function of symbols, by name."""
    symbols = {
        name: np.reshape(ca.SX.sym(name, value.size), value.shape)
        for name, value in values.items()
    }
    results = block.evaluate(equation, symbols)
    function = ca.Function(
        "f", [ca.vec(ca.SX(s.T)) for s in symbols.values()],
        [ca.vec(ca.SX(r.T)) for r in results.values()],
    )
    numbers = function.call([ca.DM(value.ravel()) for value in values.values()])
    return {
        name: np.reshape(np.array(number), np.shape(result))
        for (name, result), number in zip(results.items(), numbers, strict=True)
    }


@pytest.mark.parametrize(("block", "equation", "seed"), CASES)
def test_a_traced_equation_agrees_with_numpy(block, equation, seed):
    values = random_values(block(), seed)
    expected = block().evaluate(equation, values)
    traced = evaluate_traced(block(), equation, values)
    assert list(traced) == list(expected)
    np.testing.assert_allclose(
        np.concatenate([np.ravel(traced[name]) for name in expected]),
        np.concatenate([np.ravel(expected[name]) for name in expected]),
        rtol=1e-13, atol=1e-13,  # roundings in another order
    )
