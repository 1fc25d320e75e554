"""One simulated instance of a block: values, time, ticks and steps. No FMI here.

All values stand in one array in the order of the FMU's layout. Ticks of a sampled block fall on
start_time + k * sample_period. A tick that falls on the present instant is *pending*: it is
evaluated when an output is read, again if inputs were set and outputs are read once more, and
becomes final when the next step departs. Outputs hold from tick to tick.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...components.component import TIME, Component
from ...components.declarations import Array, Input, Noise
from . import solvers
from .noise import fnv1a, normal_draws

TICK_TOLERANCE = 1e-9  # of the sample period
SHORTEST_PERIOD = 1e-6  # s; shorter ones would tick for ever


class InstanceError(Exception):
    """The instance cannot go on; ``problems`` name the variables concerned."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("; ".join(problems))
        self.problems = tuple(problems)


class Slot(NamedTuple):
    """A variable's place in the array of values, and its limits."""

    name: str
    kind: str
    shape: tuple[int, ...]
    reference: int
    min: float | None
    max: float | None
    start: list[float] | None
    is_output: bool
    tunable: bool

    @property
    def size(self) -> int:
        """Number of scalars."""
        return math.prod(self.shape)


def read_layout(path: Path) -> list[Slot]:
    """The layout that the FMU carries."""
    rows = json.loads(path.read_text(encoding="utf-8"))
    return [Slot(**(row | {"shape": tuple(row["shape"])})) for row in rows]


class Instance:
    """Values of one instance of a block. References are those of the FMU's layout."""

    def __init__(self, block: Component, layout: Sequence[Slot], name: str) -> None:
        self.block, self.layout = block, layout
        self.stream = fnv1a(name)
        self.values = np.zeros(1 + sum(s.size for s in layout))
        self.named: dict[str, Array] = {TIME: self.values[0:1].reshape(())}
        self._slot_of: list[Slot] = [Slot(TIME, "time", (), 0, None, None, None, False, False)]
        for slot in layout:
            view = self.values[slot.reference : slot.reference + slot.size]
            view[:] = 0.0 if slot.start is None else slot.start
            self.named[slot.name] = view.reshape(slot.shape)
            self._slot_of += [slot] * slot.size
        self._noises = block.of_type(Noise)
        for noise in self._noises.values():
            self.named[noise.name] = np.zeros(noise.dimensions)
        states = [s for s in layout if s.kind == "state"]
        self._states = slice(states[0].reference, states[-1].reference + states[-1].size) \
            if states else slice(0, 0)
        self._inputs_checked = block.has("requirements") and not set(
            block.of_type(Input)
        ).isdisjoint(block.arguments("requirements"))
        self.start_time = 0.0
        self.tick = 0  # index of the next tick, or of the pending one
        self.pending = self.evaluated = False
        self.dirty = True
        self.next_discrete: dict[str, Array] = {}
        self.proposal = 0.0
        self.refused: dict[str, str] = {}

    @property
    def time(self) -> float:
        """Internal time, s."""
        return float(self.values[0])

    @property
    def period(self) -> float:
        """Sample period, s; 0 if the block acts continuously."""
        return float(self.named["sample_period"]) if self.block.sampled else 0.0

    def set(
        self, references: Sequence[int], values: Sequence[float], running: bool = False
    ) -> None:
        """Set scalars; ``running``: after initialisation, when only some may be set.

        A value that is not finite, out of range or not to be set now is refused and remembered.
        """
        for reference, value in zip(references, values, strict=True):
            slot = self._slot_of[reference]
            name = element_name(slot, reference)
            if problem := _not_settable(slot, running) or _out_of_range(slot, value):
                self.refused[name] = f"{name} = {value:g}: {problem}"
            else:
                self.refused.pop(name, None)
                self.values[reference] = value
        self.dirty = True

    def get(self, references: Sequence[int]) -> Array:
        """Values of the present instant. Raises InstanceError if an output is not finite."""
        if self.dirty and any(self._slot_of[r].is_output for r in references):
            self._refresh()
        return self.values[list(references)]

    def initialise(self, start_time: float) -> None:
        """Set the start time; the first tick, if the block is sampled, is pending then."""
        self.start_time = self.values[0] = start_time
        self.tick, self.pending, self.evaluated = 0, self.period > 0, False
        self.proposal = float(self.named.get("solver_step", np.array(0.0)))
        self.dirty = True

    def require(self) -> None:
        """Check values and the block's requirements. Raises InstanceError with all violations."""
        problems = list(self.refused.values())
        if 0.0 < self.period < SHORTEST_PERIOD:
            limit = f"must be 0 or at least {SHORTEST_PERIOD:g}"
            problems.append(f"sample_period = {self.period:g}: {limit}")
        if self.block.has("requirements"):
            with np.errstate(all="ignore"):
                held = self.block.evaluate("requirements", self.named)
            problems += [message for message, holds in held.items() if not holds]
        if problems:
            raise InstanceError(problems)

    def step(self, time: float, h: float) -> None:
        """Go from ``time`` to ``time + h`` with held inputs. Raises InstanceError."""
        on_time = math.isclose(time, self.time, rel_tol=1e-9, abs_tol=1e-9)
        if not 0.0 <= h < math.inf or not on_time:
            problem = f"step from {time:g} s by {h:g} s, but the internal time is {self.time:g} s"
            raise InstanceError([problem])
        if self.refused:
            raise InstanceError(list(self.refused.values()))
        end = time + h
        self._depart()
        if (period := self.period) > 0.0:
            near = TICK_TOLERANCE * period + 4.0 * math.ulp(end)
            while (at := self.start_time + self.tick * period) < end - near:
                self._integrate(at)
                self.pending = True
                self._depart()
            self.pending = at <= end + near
            self.evaluated = False
        self._integrate(end)
        self.dirty = True
        if self._inputs_checked:
            self.require()

    def _depart(self) -> None:
        """Make a pending tick final."""
        if not self.pending:
            return
        if not self.evaluated:
            self._evaluate_tick()
        for name, value in self.next_discrete.items():
            self.named[name][...] = value
        self.tick += 1
        self.pending = self.evaluated = False

    def _evaluate_tick(self) -> None:
        seed = int(self.named.get("seed", np.array(0.0)))
        for channel, noise in enumerate(self._noises.values()):
            draws = normal_draws(seed, self.stream, self.tick, channel, noise.size)
            self.named[noise.name][...] = draws.reshape(noise.dimensions)
        self._outputs()
        with np.errstate(all="ignore"):
            update = self.block.evaluate("update", self.named) if self.block.has("update") else {}
        _require_finite(update)
        self.next_discrete = {n: np.array(v, dtype=float) for n, v in update.items()}
        self.evaluated = True

    def _refresh(self) -> None:
        if self.pending:
            self._evaluate_tick()
        elif not self.period > 0.0:
            self._outputs()
        self.dirty = False

    def _outputs(self) -> None:
        if not self.block.has("outputs"):
            return
        with np.errstate(all="ignore"):
            outputs = self.block.evaluate("outputs", self.named)
        _require_finite(outputs)
        for name, value in outputs.items():
            self.named[name][...] = value

    def _integrate(self, end: float) -> None:
        start, h = self.time, end - self.time
        if self._states.stop and h > 0.0:
            x = self.values[self._states].copy()
            if int(self.named["solver"]) == 1:
                step = float(self.named["solver_step"])
                x = solvers.rk4(self._rate, self._project, start, x, h, step)
            else:
                relative, absolute = (
                    float(self.named[f"{n}_tolerance"]) for n in ("relative", "absolute")
                )
                try:
                    x, self.proposal = solvers.dormand_prince(
                        self._rate, self._project, start, x, h, self.proposal, relative, absolute
                    )
                except solvers.StepUnderflow as underflow:
                    raise InstanceError([f"tolerances cannot be met: {underflow}"]) from None
            self.values[self._states] = x
            if not np.all(np.isfinite(x)):
                _require_finite({s.name: self.named[s.name] for s in self.layout
                                 if s.kind == "state"})
        self.values[0] = end

    def _rate(self, t: float, x: Array) -> Array:
        self.values[0], self.values[self._states] = t, x
        with np.errstate(all="ignore"):
            rates = self.block.evaluate("derivatives", self.named)
        return np.concatenate([np.ravel(rates[n]) for n in self.block.expected("derivatives")])

    def _project(self, t: float, x: Array) -> Array:
        if not self.block.has("project"):
            return x
        self.values[0], self.values[self._states] = t, x
        with np.errstate(all="ignore"):
            projected = self.block.evaluate("project", self.named)
        for name, value in projected.items():
            self.named[name][...] = value
        return self.values[self._states].copy()

    def state(self) -> dict[str, Any]:
        """Everything that later steps depend on, as plain numbers that JSON keeps to the bit."""
        return {
            "values": self.values.tolist(),
            "next_discrete": {n: v.tolist() for n, v in self.next_discrete.items()},
            "refused": dict(self.refused),
            **{n: getattr(self, n) for n in HIDDEN},
        }

    def restore(self, state: Mapping[str, Any]) -> None:
        """Continue from a saved state. Raises InstanceError if it is another block's."""
        if len(state["values"]) != self.values.size:
            raise InstanceError(["the saved state belongs to another FMU"])
        self.values[:] = state["values"]
        self.next_discrete = {n: np.array(v) for n, v in state["next_discrete"].items()}
        self.refused = dict(state["refused"])
        for name in HIDDEN:
            setattr(self, name, state[name])


HIDDEN = ("stream", "start_time", "tick", "pending", "evaluated", "dirty", "proposal")


def element_name(slot: Slot, reference: int) -> str:
    """The FMI 2.0 name of one scalar: ``force[2]``, ``inertia[1,3]``."""
    if not slot.shape:
        return slot.name
    index = np.unravel_index(reference - slot.reference, slot.shape)
    return f"{slot.name}[{','.join(str(int(i) + 1) for i in index)}]"


def _not_settable(slot: Slot, running: bool) -> str:
    if slot.kind in ("time", "output", "derivative"):
        return "is calculated and cannot be set"
    if running and slot.kind != "input" and not slot.tunable:
        return "cannot be set after initialisation"
    return ""


def _out_of_range(slot: Slot, value: float) -> str:
    if not math.isfinite(value):
        return "must be finite"
    if slot.min is not None and value < slot.min:
        return f"must be at least {slot.min:g}"
    if slot.max is not None and value > slot.max:
        return f"must be at most {slot.max:g}"
    return ""


def _require_finite(values: Mapping[str, Any]) -> None:
    problems = [f"{n} is not finite" for n, v in values.items() if not np.all(np.isfinite(v))]
    if problems:
        raise InstanceError(problems)
