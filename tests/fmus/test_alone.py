"""Each FMU, run alone by FMPy, gives what its block gives."""

from __future__ import annotations

import fmpy
import numpy as np
import pytest

from sightline.components import Output
from sightline.components.catalogue import blocks
from sightline.fmus.build import build

from .valid_values import by_scalar, valid_inputs

TARGETS = ("python", "native")
COMPUTING = sorted(n for n, b in blocks().items() if b().of_type(Output))


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("name", COMPUTING)
def test_outputs_of_the_fmu_are_those_of_the_block(
    name: str, target: str, fmu_cache: None
) -> None:
    block = blocks()[name]()
    inputs = valid_inputs(block, seed=1)
    expected = by_scalar(block.evaluate("outputs", block.start_values() | inputs))
    result = fmpy.simulate_fmu(
        str(build(name, target=target)), stop_time=0.1, step_size=0.1, output_interval=0.1,
        start_values=by_scalar(inputs), output=list(expected), fmi_type="CoSimulation",
    )
    np.testing.assert_allclose(
        [result[n][0] for n in expected], list(expected.values()), rtol=1e-12, atol=1e-12
    )
