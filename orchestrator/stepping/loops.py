"""Algebraic loops: inputs of a cluster of FMUs such that they agree with its outputs.

Unknown are the inputs z that the cluster's own outputs drive; g(z) is what they become when the
FMUs are given z and asked for their outputs. Newton's method on g(z) - z = 0 with the FMUs' own
partial derivatives, where all have them; else Anderson's acceleration of z <- g(z), which is exact
for linear loops after as many iterations as there are unknowns.

Source: Walker, Ni, Anderson acceleration for fixed-point iterations, 2011.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..errors import LoopError
from ..schedule.plan import Array, Block, Loop, Unit
from .moves import Moves

MEMORY = 8  # iterations that Anderson's acceleration combines
REALS = ("Real", "Float64")
PROBE = 1e-3  # relative change of inputs that shows whether outputs respond


@dataclass(frozen=True)
class Tolerance:
    """A loop is solved when |g(z) - z| <= relative · (1 + |z|) for each unknown."""

    relative: float = 1e-9
    iterations: int = 50


class LoopSolver:
    """Solves one loop."""

    def __init__(
        self, loop: Loop, moves: Sequence[Moves], values: Array, tolerance: Tolerance
    ) -> None:
        self.loop = loop
        self.moves = [moves[u] for u in loop.units]
        self.values = values
        self.tolerance = tolerance
        self.smooth = all(
            any(p in range(b.first, b.last) for m in self.moves for b in _reals(m.unit)[0])
            for p in loop.inputs
        )
        self.has_derivatives = self.smooth and all(
            m.slave.fmu.has_derivatives for m in self.moves
        )

    def solve(self, time: float) -> None:
        """Bring inputs and outputs into agreement. Raises LoopError, RunError."""
        for move in self.moves:
            move.read(time)
        for move in self.moves:
            move.copy()
        guess = self.values[self.loop.inputs]
        history = _Anderson() if self.smooth else None
        for _ in range(self.tolerance.iterations):
            answer = self._respond(guess, time)
            residual = answer - guess
            if np.all(np.abs(residual) <= self.tolerance.relative * (1.0 + np.abs(guess))):
                return
            if self.has_derivatives:
                slope = self._jacobian() - np.eye(len(guess))
                guess = guess - np.linalg.lstsq(slope, residual, rcond=None)[0]
            elif history is not None:
                guess = history.next(guess, answer)
            else:
                guess = answer
            if not np.all(np.isfinite(guess)):
                break
        raise self._failure(time, "does not converge", residual)

    def responds(self, time: float) -> list[bool]:
        """For each FMU whether its outputs follow a change of its inputs at once."""
        guess = self.values[self.loop.inputs].copy()
        before = [self._outputs(m) for m in self.moves]
        self._respond(guess + PROBE * (1.0 + np.abs(guess)) if self.smooth else 1 - guess, time)
        changed = [
            not np.array_equal(b, self._outputs(m))
            for b, m in zip(before, self.moves, strict=True)
        ]
        self._respond(guess, time)
        return changed

    def refuse(self, number: int, time: float) -> LoopError:
        """The error of an FMU whose outputs do not follow its inputs between steps."""
        name = self.moves[number].slave.name
        what = f"cannot be solved: the outputs of {name} do not follow its inputs between steps"
        return self._failure(time, what, np.zeros(0))

    def _respond(self, guess: Array, time: float) -> Array:
        self.values[self.loop.inputs] = guess
        for move in self.moves:
            move.put(time)
        for move in self.moves:
            move.read(time)
        for move in self.moves:
            move.copy()
        return self.values[self.loop.inputs]

    def _outputs(self, move: Moves) -> Array:
        return self.values[move.unit.outputs.first:move.unit.outputs.last].copy()

    def _jacobian(self) -> Array:
        """∂g/∂z from the FMUs' partial derivatives and the connections."""
        result = np.zeros((len(self.loop.inputs),) * 2)
        for move in self.moves:
            (inputs, *_), (outputs, *_) = _reals(move.unit)
            for column, position in enumerate(self.loop.inputs):
                if inputs.first <= position < inputs.last:
                    seed = np.zeros(inputs.last - inputs.first)
                    seed[position - inputs.first] = 1.0
                    change = move.slave.sensitivity(outputs, inputs, seed)
                    self._add(result[:, column], outputs, change)
        return result

    def _add(self, column: Array, outputs: Block, change: Array) -> None:
        """What a change of outputs does to the unknowns."""
        for move in self.moves:
            unit = move.unit
            for row, position in enumerate(self.loop.inputs):
                if unit.inputs.first <= position < unit.inputs.last:
                    k = position - unit.inputs.first
                    source = unit.sources[k]
                    if outputs.first <= source < outputs.last:
                        gain = 1.0 if unit.gain is None else unit.gain[k]
                        column[row] += gain * change[source - outputs.first]

    def _failure(self, time: float, what: str, residual: Array) -> LoopError:
        residuals = dict(zip(self.loop.names, residual.tolist(), strict=False))
        return LoopError(tuple(m.slave.name for m in self.moves), time, what, residuals)


class _Anderson:
    """The next guess from the latest guesses and answers."""

    def __init__(self) -> None:
        self.answers: list[Array] = []
        self.residuals: list[Array] = []

    def next(self, guess: Array, answer: Array) -> Array:
        self.answers = [*self.answers[-MEMORY:], answer]
        self.residuals = [*self.residuals[-MEMORY:], answer - guess]
        if len(self.answers) == 1:
            return answer
        steps = np.diff(np.array(self.residuals), axis=0).T
        weights = np.linalg.lstsq(steps, self.residuals[-1], rcond=None)[0]
        moved: Array = answer - np.diff(np.array(self.answers), axis=0).T @ weights
        return moved


def _reals(unit: Unit) -> tuple[list[Block], list[Block]]:
    none = [Block("Real", (), unit.inputs.first, unit.inputs.first)]
    inputs, outputs = (
        [b for b in s.blocks if b.type in REALS and not b.events] or none
        for s in (unit.inputs, unit.outputs)
    )
    return inputs, outputs
