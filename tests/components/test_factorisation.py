"""Factors of small symmetric matrices against numpy's solver."""

import numpy as np
import pytest

from sightline.components.factorisation import factorise, solve

RNG = np.random.default_rng(2)
HALF = RNG.standard_normal((6, 6))
MATRIX = HALF @ HALF.T + np.eye(6)


@pytest.mark.parametrize("shape", [(6,), (6, 4)], ids=["vector", "matrix"])
def test_a_solution_is_that_of_numpy(shape):
    right = RNG.standard_normal(shape)
    expected = np.linalg.solve(MATRIX, right)
    np.testing.assert_allclose(solve(factorise(MATRIX), right), expected, rtol=1e-12)


def test_a_dependent_row_is_left_out():
    rows = np.concatenate([HALF[:2], HALF[:1] + HALF[1:2]])
    found = solve(factorise(rows @ rows.T, 1e-9), np.ones(3))
    expected = np.linalg.solve(rows[:2] @ rows[:2].T, np.ones(2))
    np.testing.assert_allclose(found, [*expected, 0.0], rtol=1e-9)


def test_the_last_pivot_of_an_indefinite_matrix_has_no_inverse():
    assert factorise(np.diag([1.0, 2.0, -1.0]), 1e-9).inverse[-1] == 0.0
