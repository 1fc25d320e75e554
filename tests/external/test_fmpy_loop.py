"""Example 5.1 from the same FMU files in a loop written with FMPy."""

import numpy as np

from .conftest import Reference
from .tools import fmpy_loop


def test_a_loop_over_fmpy_slaves_computes_example_51_to_the_last_bit(reference: Reference):
    rows = fmpy_loop(reference.system, reference.step, reference.count)

    assert np.array_equal(rows, reference.rows)
