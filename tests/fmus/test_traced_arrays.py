"""Indices of traced arrays select what they select in numpy."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import fmpy
import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.fmus.native.target import compiler_available
from sightline.fmus.traced_arrays import SYMBOLIC, NeedsNumberError, numpy_mode

ALL = slice(None)
VECTOR = [
    (None, ALL), (ALL, None), None, ..., (..., None), (None, None), -1, (), np.array([2, 0]),
    [0, -1], np.array([True, False, True]), (slice(None, None, -1), None), (0, None),
    np.array([[0, 1], [2, 0]]), np.int64(1),
]  # fmt: skip
MATRIX = [
    (None, ALL), (ALL, None, 0), (0, None, ALL), (..., 0), ([0, 1], [2, 0]), (ALL, [0, 2]),
    (ALL, -1), np.ix_([1, 0], [0, 2]), np.arange(6).reshape(2, 3) % 2 == 0, (ALL, None, ALL),
]  # fmt: skip
CASES = [(3, key) for key in VECTOR] + [((2, 3), key) for key in MATRIX]
OUTER = '''import numpy as np
from sightline.components import Component, Input, Output


class Outer(Component):
    """Products of all elements, and some of them."""

    v = Input(3, "1", doc="vector")
    product = Output((3, 3), "1", doc="v v^T")
    chosen = Output(2, "1", doc="first and last element")

    def outputs(self, v):
        return {"product": v[:, None] * v[None, :], "chosen": v[np.array([True, False, True])]}
'''


@pytest.mark.parametrize(("shape", "key"), CASES, ids=[f"{s} {k}" for s, k in CASES])
def test_an_index_selects_what_it_selects_in_numpy(shape: Any, key: Any) -> None:
    numbers = np.reshape(np.arange(np.prod(shape)) + 10.0, shape)
    symbol = ca.SX.sym("x", numbers.size)
    with numpy_mode():
        selected: Any = np.reshape(symbol, numbers.shape)[key]
        flat = ca.densify(ca.SX(np.reshape(selected, (-1,))))
    values = ca.Function("f", [symbol], [flat])(numbers.ravel()).full()
    assert selected.shape == numbers[key].shape
    np.testing.assert_array_equal(values.reshape(selected.shape), numbers[key])


def test_an_index_that_is_a_traced_value_is_an_error() -> None:
    with numpy_mode():
        x: Any = np.reshape(ca.SX.sym("x", 3), (3,))
        with pytest.raises(NeedsNumberError):
            x[x > 0.0]


def test_casadi_is_as_before_after_tracing() -> None:
    before = dict(vars(SYMBOLIC))
    with numpy_mode():
        assert dict(vars(SYMBOLIC)) != before
    assert dict(vars(SYMBOLIC)) == before


@pytest.mark.skipif(not compiler_available(), reason="builds a native FMU")
def test_new_axes_and_masks_give_the_same_in_native_and_python_fmus(tmp_path: Path) -> None:
    path = tmp_path / "outer.py"
    path.write_text(OUTER, encoding="utf-8")
    v = [1.5, -2.0, 3.25]
    start = {f"v[{i + 1}]": value for i, value in enumerate(v)}
    for target in ("native", "python"):
        fmu = build(f"{path}:Outer", target=target)  # type: ignore[arg-type]
        row = fmpy.simulate_fmu(str(fmu), stop_time=0.1, start_values=start)[-1]
        product = [[row[f"product[{i},{j}]"] for j in (1, 2, 3)] for i in (1, 2, 3)]
        np.testing.assert_array_equal(product, np.outer(v, v), err_msg=target)
        assert [row["chosen[1]"], row["chosen[2]"]] == [v[0], v[2]]
