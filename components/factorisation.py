"""Factors of a small symmetric positive definite matrix, to solve with several right sides.

A = L D L^T, written out for code generation: the size is known, so no pivots and no loops remain.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .declarations import Array, Scalar
from .maths import reciprocal


class Factors(NamedTuple):
    """Columns of L below its unit diagonal, and the inverse of D's diagonal."""

    lower: tuple[tuple[Scalar, ...], ...]
    inverse: tuple[Scalar, ...]


def factorise(matrix: Array, least_pivot: float = 0.0) -> Factors:
    """L and D of a symmetric positive definite matrix.

    A row that depends on those before it has a pivot of next to nothing: where the pivot does not
    exceed ``least_pivot``, solutions leave that row out, with a zero in its place.
    """
    n = matrix.shape[0]
    rest = {(i, j): matrix[i, j] for j in range(n) for i in range(j, n)}
    lower, inverse = [], []
    for j in range(n):
        kept = rest[j, j] > least_pivot
        inverse.append(np.where(kept, 1.0 / np.where(kept, rest[j, j], 1.0), 0.0)
                       if least_pivot > 0.0 else reciprocal(rest[j, j]))
        column = [rest[i, j] * inverse[j] for i in range(j + 1, n)]
        for k in range(j + 1, n):
            for i in range(k, n):
                rest[i, k] = rest[i, k] - column[i - j - 1] * rest[k, j]
        lower.append(tuple(column))
    return Factors(tuple(lower), tuple(inverse))


def solve(factors: Factors, right: Array) -> Array:
    """The solution of A x = right, for a vector or for each column of a matrix."""
    x = [right[i] for i in range(len(factors.inverse))]
    for j, column in enumerate(factors.lower):
        for i, entry in enumerate(column, start=j + 1):
            x[i] = x[i] - entry * x[j]
    x = [value * inverse for value, inverse in zip(x, factors.inverse, strict=True)]
    for j in reversed(range(len(x))):
        for i, entry in enumerate(factors.lower[j], start=j + 1):
            x[j] = x[j] - entry * x[i]
    return np.stack(x)
