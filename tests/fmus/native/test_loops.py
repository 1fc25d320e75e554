"""`repeat` in an equation: the numbers of the loop, without unrolling it."""

from __future__ import annotations

import numpy as np

from sightline.fmus.native.codegen import generate

from .blocks import Iterating
from .driver import Native, native_model


def test_a_loop_is_one_function_that_is_called() -> None:
    model = native_model(Iterating())
    assert model.trace is not None
    assert model.trace.functions["outputs"].n_instructions() < 150
    source = generate(model, 2).equations
    assert source.count("/(") + source.count("(1./") + source.count("/a") < 60  # 8 times 3 times


def test_dependencies_are_seen_through_the_loop() -> None:
    model = native_model(Iterating())
    u, root = model.by_name["u"], model.by_name["root"]
    for element in range(3):
        known = model.dependencies[root.references[element]]
        assert u.references[element] in known


def test_a_loop_computes_what_numpy_computes(native) -> None:  # type: ignore[no-untyped-def]
    built: Native = native("Iterating", 2)
    fmu = built.instance()
    fmu.initialise()
    fmu.set(u=[4.0, 9.0, 2.0])
    np.testing.assert_allclose(fmu.get("root"), [2.0, 3.0, np.sqrt(2.0)], rtol=1e-12)
    assert fmu.get("turns") == 8
