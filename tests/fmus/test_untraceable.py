"""What cannot become native code is an error with block, place, reason and remedy; never a NaN."""

from __future__ import annotations

import math
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from sightline.fmus.build import build, describe
from sightline.fmus.errors import BuildError
from sightline.fmus.load import load_block
from sightline.fmus.traced_arrays import numpy_mode
from sightline.fmus.tracing import trace
from sightline.fmus.untraceable import SAME_IN_NUMPY

SOURCE = '''import math
import random
import time
from math import cos as cosine

import numpy as np
from sightline.components import Component, DiscreteState, Input, Output, SamplePeriod
from sightline.components.loops import repeat


class Mine(Component):
    """A user's block."""

    u = Input((), "1", 0.5, doc="number")
    v = Input(3, "1", doc="vector")
    y = Output((), "1", doc="result")
    z = Output((), "1", doc="another result")
    k = DiscreteState((), "1", doc="memory")
    sample_period = SamplePeriod(start=0.1)
    n = 0.0

    def outputs(self, u, v):
        BODY

    def update(self, k):
        self.n += CHANGE
        return {"k": k + 1.0}
'''
LINE = 1 + SOURCE[: SOURCE.index("BODY")].count("\n")
NUMBER = "takes the number of a value that is known only when the FMU runs"
BRANCH = "branches on a value that is known only when the FMU runs"
STACK = "put elements together by np.stack or np.concatenate"
NOT_TRACED = "is not among the operations of numpy that can be traced"
WHERE = ("use numpy operations without branches on values (np.where instead of if, "
         "np.logical_and instead of and)")  # fmt: skip
REFUSED = [
    ("math.sin(u)", NUMBER, "write np.sin instead of math.sin"),
    ("cosine(u)", NUMBER, "write np.cos instead of math.cos"),
    ("math.floor(u)", NUMBER, "write np.floor instead of math.floor"),
    ("math.erf(u)", NUMBER, WHERE),
    ("float(u)", NUMBER, "leave float out, numpy takes the value as it is"),
    ("int(u)", NUMBER, "write np.trunc instead of int"),
    ("bool(u)", BRANCH, "compare with a number instead of bool"),
    ("max(u, 0.0)", BRANCH, "write np.maximum or np.max instead of max"),
    ("min(v)", BRANCH, "write np.minimum or np.min instead of min"),
    ("np.array([u, u])", NUMBER, STACK),
    ("np.asarray(v)", NUMBER, "leave np.asarray out, the value is an array already"),
    ("np.full(3, u)", NUMBER, "multiply np.ones by the value"),
    ("np.isfinite(u)", NOT_TRACED, WHERE),
    ("np.expand_dims(v, 0)", NOT_TRACED, "write x[None, :] or x[:, None]"),
]


def block(folder: Path, body: str, change: str = "0.0") -> str:
    path = folder / "mine.py"
    path.write_text(SOURCE.replace("BODY", body).replace("CHANGE", change), encoding="utf-8")
    return f"{path}:Mine"


def refusal(reference: str) -> str:
    with pytest.raises(BuildError) as caught:
        build(reference, target="native")
    return str(caught.value)


@pytest.mark.parametrize(("expression", "reason", "remedy"), REFUSED, ids=[r[0] for r in REFUSED])
def test_what_needs_a_number_is_refused_with_place_and_remedy(
    tmp_path: Path, expression: str, reason: str, remedy: str
) -> None:
    reference = block(tmp_path, f'return {{"y": np.sum({expression}) + 0.0, "z": u}}')
    assert refusal(reference) == (
        f"cannot build {reference}: Mine.outputs cannot become native code: {expression} "
        f"(mine.py, line {LINE}) {reason}; {remedy}, or build a Python FMU (FMI 2.0) with "
        "--target python"
    )


@pytest.mark.parametrize(
    ("body", "expression", "reason", "remedy"),
    [
        ("return {'y': u if u > 0 else -u, 'z': u}", "u > 0", BRANCH, WHERE),
        ("a = np.zeros(3); a[0] = u; return {'y': a[0], 'z': u}", "a[0]", NUMBER, STACK),
        ("a = np.zeros(3); a += u; return {'y': a[0], 'z': u}", "a += u", NOT_TRACED,
         "write a = a + b instead of a += b"),
    ],
    ids=["if", "element", "in place"],
)  # fmt: skip
def test_a_statement_that_needs_a_number_is_refused_with_place_and_remedy(
    tmp_path: Path, body: str, expression: str, reason: str, remedy: str
) -> None:
    text = refusal(block(tmp_path, body))
    assert f"{expression} (mine.py, line {LINE}) {reason}; {remedy}, or" in text


@pytest.mark.parametrize("name", sorted(SAME_IN_NUMPY))
def test_the_namesake_that_is_offered_for_a_function_of_math_can_be_traced(name: str) -> None:
    two = name in ("atan2", "copysign", "fmod", "hypot", "pow")
    numbers = (1.5, 1.25) if two else (1.5,) if name == "acosh" else (0.5,)
    symbols = [ca.SX.sym("x") for _ in numbers]
    with numpy_mode():
        traced = ca.SX(getattr(np, name)(*(np.reshape(s, ()) for s in symbols)))
    value = float(ca.Function("f", symbols, [traced])(*numbers))
    assert value == pytest.approx(getattr(math, name)(*numbers), rel=1e-15)  # one rounding


CHANGING = ["np.random.randn()", "random.random()", "time.time()", "time.perf_counter()"]


@pytest.mark.parametrize("expression", CHANGING)
def test_what_the_build_would_freeze_is_refused(tmp_path: Path, expression: str) -> None:
    reference = block(tmp_path, f'return {{"y": u, "z": u + {expression}}}')
    assert refusal(reference) == (
        f"cannot build {reference}: Mine.outputs cannot become native code: called twice with the "
        "same values it returns different values of z, and native code would keep those of the "
        "build for ever; draw random numbers from a Noise, take the clock from the argument time, "
        "keep memory in a DiscreteState, or build a Python FMU (FMI 2.0) with --target python"
    )


@pytest.mark.parametrize("value", ["self.n", "np.where(u > 1e9, self.n, 0.0)"])
def test_memory_that_another_equation_changes_is_refused(tmp_path: Path, value: str) -> None:
    text = refusal(block(tmp_path, f'return {{"y": u + {value}, "z": u}}', change="1.0"))
    assert "Mine.outputs cannot become native code: called twice" in text
    assert "different values of y, and" in text


def test_what_is_computed_once_and_kept_is_not_refused(tmp_path: Path) -> None:
    body = ('self.m = getattr(self, "m", None) or math.sin(3.0); '
            'return {"y": self.m * u, "z": np.random.default_rng(1).random() * u}')  # fmt: skip
    assert "outputs" in trace(load_block(block(tmp_path, body))).functions


def test_a_python_fmu_of_what_cannot_be_traced_declares_what_its_outputs_use(
    tmp_path: Path,
) -> None:
    reference = block(tmp_path, 'return {"y": math.sin(u), "z": u}')
    model = describe(reference, load_block(reference), "python")
    (y,), (u,) = (model.by_name[n].references for n in ("y", "u"))
    assert u in model.dependencies[y]


def test_fmi_3_of_what_cannot_be_traced_says_why(tmp_path: Path) -> None:
    reference = block(tmp_path, 'return {"y": math.sin(u), "z": u}')
    with pytest.raises(BuildError, match=r"math\.sin\(u\) \(mine\.py, line \d+\) takes the number"):
        build(reference, fmi=3)


def test_a_step_of_repeat_that_uses_what_it_is_not_given_is_refused(tmp_path: Path) -> None:
    turn = "repeat(lambda given, x: (x[0] * u,), 3, (), (u * 1.0,))"
    text = refusal(block(tmp_path, f'return {{"y": {turn}[0], "z": u}}'))
    assert f"{turn} (mine.py, line {LINE}): its step uses u, which it is not given; " in text


def test_a_result_of_another_size_when_traced_is_refused(tmp_path: Path) -> None:
    text = refusal(block(tmp_path, 'return {"y": np.sum(u) if hasattr(u, "item") else v, "z": u}'))
    assert "Mine.outputs cannot become native code: y has 3 elements, not 1" in text
