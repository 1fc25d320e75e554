"""The allocation programme of all one-sided allocators, solved by an interior-point method.

minimise    c·F + ½ F·w F + penalty(U - B F)     over 0 <= F <= limits
penalty(r): with κ = 0   M |r|_1, exact: r = 0 wherever the wrench U can be reached
            with κ = 1   ½ |r|²  while |r| < M (beyond, it grows linearly)

Every wrench has a solution, so that nothing has to be known beforehand. A fixed number of
predictor-corrector steps is taken, each with one factorisation of a 6x6 matrix; steps after
convergence change nothing. Quantities are expected to be of order 1.

Source: S. Mehrotra, On the implementation of a primal-dual interior point method, SIAM J. Optim.
2 (1992); J. Nocedal, S. Wright, Numerical Optimization, ch. 14, 16.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..declarations import Array, Scalar
from ..loops import repeat
from .factorisation import Factors, factorise, solve

NEAR = 0.995  # part of the way to the nearest bound that a step may take
SMALLEST = 1e-30
REGULARISATION = 1e-14  # of the trace: keeps the matrix invertible where solutions are degenerate


class Programme(NamedTuple):
    """B, U, c, w, limits, M for each component of the wrench, and κ; limits None: none.

    ``tolerance``: steps end where the mean product of a variable and its multiplier is below it.
    """

    sensitivity: Array
    wrench: Array
    cost: Array
    weight: Array
    limits: Array | None
    penalty: Array
    compliance: float
    tolerance: float


class _Point(NamedTuple):
    """Variables x = [F, limits - F, r+, r-] > 0, their multipliers s > 0, and y, dual to U."""

    x: Array
    s: Array
    y: Array


def minimise(programme: Programme, steps: int) -> Array:
    """F, strictly within its limits."""
    point = repeat(_step, steps, programme, _start(programme))
    return _forces(programme, point.x)


def _forces(programme: Programme, x: Array) -> Array:
    return x[: programme.sensitivity.shape[1]]


def _start(programme: Programme) -> _Point:
    m, n = programme.sensitivity.shape
    ones, M = np.ones(n), programme.penalty
    if programme.limits is None:
        forces, multipliers = [ones], [ones]
    else:
        F = np.minimum(ones, 0.5 * programme.limits)
        forces = [F, programme.limits - F]
        multipliers = [ones, 1.0 / np.maximum(programme.limits - F, 1.0)]
    x = np.concatenate([*forces, 0.3 * np.ones(2 * m)])
    return _Point(x, np.concatenate([*multipliers, M, M]), np.zeros(m))


def _step(programme: Programme, point: _Point) -> _Point:
    x, s, y = point
    gap = x @ s
    mean = gap / len(x)
    newton = _Newton(programme, point)
    dx, ds, _ = newton.direction(-x * s)
    along, across = _length(dx * newton.per_x, 1.0), _length(ds * newton.per_s, 1.0)
    predicted = (x + along * dx) @ (s + across * ds)
    centre = (predicted / gap) ** 3 * mean
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
        B, m = programme.sensitivity, len(y)
        self.m, self.n, self.B, self.x, self.s = m, B.shape[1], B, x, s
        self.limited = programme.limits is not None
        self.per_x, self.per_s = 1.0 / x, 1.0 / s
        F, p, q = x[: self.n], x[-2 * m : -m], x[-m:]
        self.p, self.q = p * self.per_s[-2 * m : -m], q * self.per_s[-m:]
        self.missing = programme.wrench - B @ F - p + q - programme.compliance * y
        ratio = s[: -2 * m] * self.per_x[: -2 * m]
        slope = s[: self.n] + B.T @ y - programme.cost - programme.weight * F
        curvature = programme.weight + ratio[: self.n]
        if self.limited:
            slope = slope - s[self.n : 2 * self.n]
            curvature = curvature + ratio[self.n :]
        self.ratio, self.slope, self.inverse = ratio, slope, 1.0 / curvature
        self.scaled = B * self.inverse
        system = self.scaled @ B.T + np.diag(self.p + self.q + programme.compliance)
        self.factors: Factors = factorise(system + REGULARISATION * np.trace(system) * np.eye(m))

    def direction(self, target: Array) -> tuple[Array, Array, Array]:
        """Changes of x, s and y for a target of x ds + s dx."""
        m, n = self.m, self.n
        to_p = target[-2 * m : -m] * self.per_s[-2 * m : -m]
        to_q = target[-m:] * self.per_s[-m:]
        aim = target[: -2 * m] * self.per_x[: -2 * m]
        push = self.slope + aim[:n]
        if self.limited:
            push = push - aim[n:]
        dy = solve(self.factors, self.missing - to_p + to_q - self.scaled @ push)
        dF = self.inverse * (push + self.B.T @ dy)
        forces = np.concatenate([dF, -dF]) if self.limited else dF
        dx = np.concatenate([forces, to_p + self.p * dy, to_q - self.q * dy])
        return dx, np.concatenate([aim - self.ratio * forces, -dy, dy]), dy
