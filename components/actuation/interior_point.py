"""The allocation programme of all one-sided allocators, solved by an interior-point method.

minimise    c·F + ½ F·w F + |r|²/2  or  M·|r|,    r = U - B F,    over 0 <= F <= limits

The penalty M·|r| is exact: where M is large, r = 0 wherever the wrench U can be reached. Every
wrench has a solution, so that nothing has to be known beforehand. A fixed number of
predictor-corrector steps is taken, each with one factorisation of a 6x6 matrix; steps after
convergence change nothing. Quantities are expected to be of order 1. The matrix becomes singular on
the way, which amplifies rounding: sums are taken in a given order.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method, SIAM J. Optim.
2 (1992); J. Nocedal, S. Wright, Numerical Optimization, ch. 14, 16.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..declarations import Array, Scalar
from ..factorisation import Factors, factorise, solve
from ..loops import repeat
from ..maths import product, reciprocal

NEAR = 0.995  # part of the way to the nearest bound that a step may take
SMALLEST = 1e-30
LEAST_PIVOT = 1e-200
REGULARISATION = 1e-14  # of the trace: keeps the matrix invertible where solutions are degenerate


class Programme(NamedTuple):
    """B, U, c, w, limits (None: none) and M for each component of the wrench (None: |r|²/2).

    ``tolerance``: steps end where the mean product of a variable and its multiplier is below it.
    """

    sensitivity: Array
    wrench: Array
    cost: Array
    weight: Array
    limits: Array | None
    penalty: Array | None
    tolerance: float


class _Point(NamedTuple):
    """Variables x > 0, their multipliers s > 0, and y, dual to U.

    x = [F, limits - F, r+, r-] with r = r+ - r-; without limits or penalty those parts are missing.
    """

    x: Array
    s: Array
    y: Array


def minimise(programme: Programme, steps: int) -> Array:
    """F, within its limits."""
    return _refined(programme, repeat(_step, steps, programme, _start(programme)))


def _refined(programme: Programme, point: _Point) -> Array:
    """F with the remainder of U = B F + r taken away, in proportion to the distance from bounds.

    Close to a solution where the matrix is singular, steps no longer reduce it.
    """
    (F, *upper), residual = _parts(programme, point.x)
    share = np.minimum(F, upper[0]) if upper else F
    scaled = programme.sensitivity * share
    factors = _regularised(product(scaled, programme.sensitivity.T))
    remainder = _remainder(programme, F, residual, point.y)
    moved = np.maximum(F + product(scaled.T, solve(factors, remainder)), 0.0)
    return moved if programme.limits is None else np.minimum(moved, programme.limits)


def _parts(programme: Programme, values: Array) -> tuple[list[Array], list[Array]]:
    """What belongs to F and limits - F, and to r+ and r-."""
    m, n = programme.sensitivity.shape
    bounds = 1 if programme.limits is None else 2
    forces = [values[k * n : (k + 1) * n] for k in range(bounds)]
    return forces, [] if programme.penalty is None else [values[-2 * m : -m], values[-m:]]


def _remainder(programme: Programme, F: Array, residual: list[Array], y: Array) -> Array:
    """U - B F - r."""
    r = residual[0] - residual[1] if residual else y
    return programme.wrench - product(programme.sensitivity, F) - r


def _regularised(matrix: Array) -> Factors:
    """Factors; of a matrix of zeros too, which is that of no thruster that works."""
    added = REGULARISATION * np.trace(matrix) + LEAST_PIVOT
    return factorise(matrix + added * np.eye(len(matrix)))


def _start(programme: Programme) -> _Point:
    m, n = programme.sensitivity.shape
    x, s = [np.ones(n)], [np.ones(n)]
    if programme.limits is not None:
        F = np.minimum(1.0, 0.5 * programme.limits)
        x = [F, programme.limits - F]
        s.append(1.0 / np.maximum(programme.limits - F, 1.0))
    if programme.penalty is not None:
        x.append(0.3 * np.ones(2 * m))
        s += [programme.penalty, programme.penalty]
    return _Point(np.concatenate(x), np.concatenate(s), np.zeros(m))


def _step(programme: Programme, point: _Point) -> _Point:
    x, s, y = point
    gap = product(x, s)
    mean = gap / len(x)
    newton = _Newton(programme, point)
    dx, ds, _ = newton.direction(-x * s)
    along, across = _length(dx * newton.per_x, 1.0), _length(ds * newton.per_s, 1.0)
    left = product(x + along * dx, s + across * ds) / gap
    centre = left * left * left * mean
    dx, ds, dy = newton.direction(centre - x * s - dx * ds)
    along, across = _length(dx * newton.per_x, NEAR), _length(ds * newton.per_s, NEAR)
    coupled = np.max(programme.weight) > 0.0  # else a linear programme, of two step lengths
    both = np.minimum(along, across)
    going = mean > programme.tolerance
    along = np.where(going, np.where(coupled, both, along), 0.0)
    across = np.where(going, np.where(coupled, both, across), 0.0)
    return _Point(x + along * dx, s + across * ds, y + across * dy)


def _length(growth: Array, part: float) -> Scalar:
    """How far to go, at most 1, so that what grows by this share of itself stays positive."""
    return np.minimum(1.0, part / np.maximum(-np.min(growth), SMALLEST))


class _Newton:
    """The linear system of one step, factorised once for predictor and corrector."""

    def __init__(self, programme: Programme, point: _Point) -> None:
        x, s, y = point
        B = programme.sensitivity
        self.B, self.programme = B, programme
        self.per_x, self.per_s = reciprocal(x), reciprocal(s)
        (F, *_), residual = _parts(programme, x)
        (multiplier, *upper), _ = _parts(programme, s)
        ratios, _ = _parts(programme, s * self.per_x)
        slope = multiplier + product(B.T, y) - programme.cost - programme.weight * F
        curvature = programme.weight + ratios[0]
        if upper:
            slope, curvature = slope - upper[0], curvature + ratios[1]
        diagonal = np.ones(len(y))
        if residual:
            _, (self.p, self.q) = _parts(programme, x * self.per_s)
            diagonal = self.p + self.q
        self.ratios, self.slope = ratios, slope
        self.remainder = _remainder(programme, F, residual, y)
        self.inverse = reciprocal(curvature)
        self.scaled = B * self.inverse
        self.factors = _regularised(product(self.scaled, B.T) + np.diag(diagonal))

    def direction(self, target: Array) -> tuple[Array, Array, Array]:
        """Changes of x, s and y for a target of x ds + s dx."""
        aims, _ = _parts(self.programme, target * self.per_x)
        _, to = _parts(self.programme, target * self.per_s)
        push, remainder = self.slope + aims[0], self.remainder
        if len(aims) > 1:
            push = push - aims[1]
        if to:
            remainder = remainder - to[0] + to[1]
        dy = solve(self.factors, remainder - product(self.scaled, push))
        dF = self.inverse * (push + product(self.B.T, dy))
        dx = [dF, -dF][: len(aims)]
        ds = [aim - ratio * d for aim, ratio, d in zip(aims, self.ratios, dx, strict=True)]
        if to:
            dx += [to[0] + self.p * dy, to[1] - self.q * dy]
            ds += [-dy, dy]
        return np.concatenate(dx), np.concatenate(ds), dy
