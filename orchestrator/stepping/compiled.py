"""Steps a plan over the FMUs' own C functions: the same bits as the reference, in C's time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..fmi.slave import Slave
from ..schedule.plan import Act, Array, Block, Plan
from ._loop import TYPES, Loop
from .loops import Tolerance
from .moves import Moves
from .stepper import PythonStepper

Transfer = tuple[int, object, int, int, int]
NO_EVENTS = (0, 0, 0)
NOTHING = np.empty(0, dtype=np.intp)


class CompiledStepper(PythonStepper):
    """Runs in :mod:`._loop`; what is rare happens in Python, as in the reference."""

    def __init__(
        self, plan: Plan, slaves: Sequence[Slave], start: float, step: float,
        tolerance: Tolerance | None = None,
    ) -> None:  # fmt: skip
        super().__init__(plan, slaves, start, step, tolerance)
        blocks = [b for u in plan.units for s in (u.inputs, u.outputs) for b in s.blocks]
        widest = max((b.last - b.first for b in blocks), default=0)
        links = sum(len(u.sources) for u in plan.units)
        self._loop = Loop(len(plan.units), len(blocks), links, widest)
        self._known: dict[tuple[int, ...], NDArray[np.uintc]] = {}
        program = enumerate(zip(plan.acts, self._program(), strict=True))
        self._left = {i: does for i, (act, does) in program if self._is_left(*act)}
        halts = (int(Act.SOLVE), 0)
        marked = [halts if i in self._left else act for i, act in enumerate(plan.acts)]
        acts = np.array(marked, dtype=np.intc).reshape(-1)
        self._loop.prepare(self.values, plan.recorded, acts, start, step)
        for move in self.moves:
            self._add(move)

    def advance(self, first: int, last: int, stride: int, buffer: Array) -> None:
        """See :meth:`.stepper.Stepper.advance`."""
        loop, act = self._loop, 0
        try:
            while not loop.advance(first, last, stride, buffer, act, self.free):
                self._attend(loop.act, loop.number, loop.status)
                first, act = loop.number, loop.act + 1
        finally:
            self.rows = loop.rows

    def _is_left(self, act: Act, which: int) -> bool:
        """Whether the loop halts at an act and leaves it to Python."""
        if act is Act.SOLVE or self.moves[which].slave.isolated:
            return True
        sets = act in (Act.WRITE, Act.UPDATE)
        return sets and any(b.events for b in self.moves[which].unit.inputs.blocks)

    def _attend(self, position: int, number: int, status: int) -> None:
        """Do what made the loop halt at an act, or raise its error."""
        if position in self._left:
            every, does = self._left[position]
            if (number + 1) % every == 0 or self.free is not None:
                does(number)
            return
        act, which = self.plan.acts[position]
        move = self.moves[which]
        time, width = self.span(move, number)
        if act is Act.STEP:
            self._resume(move, number, status)
        elif act is Act.WRITE:
            move.slave.check("setting inputs", status, time)
        else:
            action = "getting outputs" if act is Act.READ else "setting inputs"
            move.slave.check(action, status, time + width)

    def _resume(self, move: Moves, number: int, status: int) -> None:
        """Finish a step of which a part was not taken."""
        time, width = self.span(move, number)
        part = width / move.unit.parts
        i = self._loop.part
        self.refuse(move, status, time + i * part, part)
        self._step(move, number, i + 1)

    def _add(self, move: Moves) -> None:
        unit, slave = move.unit, move.slave
        if slave.isolated:  # takes its place, and no part
            none = (0, *NO_EVENTS)
            first = unit.inputs.first
            self._loop.add(0, none, False, False, 1, 1, first, NOTHING, None, None, [], [])
            return
        prefix, library = slave.prefix, slave.library
        step = library.address(f"{prefix}DoStep")
        names = ("EnterEventMode", "UpdateDiscreteStates", "EnterStepMode")
        events = [library.address(f"{prefix}{n}") for n in names] if prefix == "fmi3" else NO_EVENTS
        sources, sets = unit.sources, [self._transfer(slave, b, False) for b in unit.inputs.blocks]
        if direct := self._direct(move):
            sources = NOTHING
            sets = [(*s[:2], d, *s[3:]) for s, d in zip(sets, direct, strict=True)]
        self._loop.add(
            slave.component, (step, *events), prefix == "fmi3", slave.final, unit.every,
            unit.parts, unit.inputs.first, sources, unit.gain, unit.shift, sets,
            [self._transfer(slave, b, True) for b in unit.outputs.blocks],
        )  # fmt: skip
        if (course := unit.course) is not None:
            count = len(course.inputs)
            self._loop.follow(
                library.address("fmi2SetRealInputDerivatives"), course.inputs,
                np.array(course.references * course.order, dtype=np.uintc),
                np.repeat(np.arange(1, course.order + 1, dtype=np.intc), count),
                np.array(course.directions, dtype=np.intc).reshape(-1),
                move.weights, move.polynomial, move.derivatives, course.history,
            )  # fmt: skip

    def _direct(self, move: Moves) -> list[int]:
        """Where each block of inputs stands side by side as outputs, to be set without a copy.

        Empty if some do not, or if the copies are needed.
        """
        unit = move.unit
        solved = any(move in loop.moves for loop in self.loops)
        if unit.gain is not None or unit.course is not None or solved:
            return []
        found = []
        for block in unit.inputs.blocks:
            sources = unit.sources[block.first - unit.inputs.first:block.last - unit.inputs.first]
            if np.any(np.diff(sources) != 1):
                return []
            found.append(int(sources[0]))
        return found

    def _transfer(self, slave: Slave, block: Block, read: bool) -> Transfer:
        dtype = np.dtype(slave.dtypes[block.type])
        return (
            slave.library.address(slave.function(block.type, read)),
            self._references(block.references), block.first, block.last - block.first,
            TYPES[dtype.str[1:]],
        )  # fmt: skip

    def _references(self, values: tuple[int, ...]) -> NDArray[np.uintc]:
        """Value references, the same array for all FMUs of one kind."""
        if values not in self._known:
            self._known[values] = np.array(values, dtype=np.uintc)
        return self._known[values]
