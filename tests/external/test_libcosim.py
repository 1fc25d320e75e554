"""Example 5.1 from the same FMU files in libcosim (fixed-step algorithm)."""

import numpy as np

from .conftest import Reference
from .formation import relative_difference
from .tools import libcosim


def test_libcosim_computes_every_output_of_example_51_as_our_jacobi_run(reference: Reference):
    rows = libcosim(reference.system, reference.step, reference.count)

    assert rows.shape == (reference.count, len(reference.system.outputs))
    assert relative_difference(rows, reference.rows[1:]) <= reference.tolerance


def test_in_the_compared_run_every_output_moves(reference: Reference):
    assert np.all(np.ptp(reference.rows, axis=0) > 0.0)
