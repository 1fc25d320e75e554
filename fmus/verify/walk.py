"""Calls in the order that the standards allow: what may be called in a mode, and where it leads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .driver import Driver, good
from .lab import Lab
from .subject import Array

INSTANTIATED, INITIALIZATION, STEP = "instantiated", "initialisation", "step"
EVENT, CONTINUOUS, TERMINATED = "event", "continuous time", "terminated"


@dataclass(frozen=True)
class Move:
    """One legal call: its name, what it does (giving a status), the mode that it leads to."""

    name: str
    do: Callable[[], int]
    to: str = ""  # empty: the same mode


class Walk:
    """An instance in a mode, with the legal moves from there. States saved are kept by mode."""

    def __init__(self, lab: Lab, driver: Driver, rng: np.random.Generator) -> None:
        self.lab, self.driver, self.rng = lab, driver, rng
        self.subject = lab.subject
        self.mode = INSTANTIATED
        self.k = 0
        self.saved: dict[str, tuple[Any, int]] = {}
        self.unsound = ""  # what was read that is not finite

    def moves(self) -> list[Move]:
        """Legal moves of the present mode."""
        info = self.subject.interfaces[self.driver.interface]
        found = [Move("reset", self.driver.reset, INSTANTIATED)]
        if info.canGetAndSetFMUstate:
            found.append(Move("save", self._save))
            if self.mode in self.saved:
                found.append(Move("restore", self._restore))
        if self.mode != TERMINATED:
            found.append(Move("set inputs", self._set))
        if self.mode != INSTANTIATED:
            found.append(Move("get", self._get))
        return found + {
            INSTANTIATED: self._instantiated, INITIALIZATION: self._initialization,
            STEP: self._step, EVENT: self._event, CONTINUOUS: self._continuous,
            TERMINATED: list,
        }[self.mode]()  # fmt: skip

    def go(self, move: Move) -> int:
        """Make a move; the status."""
        before = self.mode
        status = move.do()
        if good(status) and move.to and self.mode == before:
            self.mode = move.to
        if move.name == "reset":
            self.k = 0
        return status

    def _instantiated(self) -> list[Move]:
        return [Move("set start values", self._set_start),
                *[Move("enter initialisation", self._enter, INITIALIZATION)] * 3]

    def _initialization(self) -> list[Move]:
        running = STEP if self.driver.interface == "cs" else EVENT
        return [Move("exit initialisation", self.driver.exit_initialization, running)] * 3

    def _step(self) -> list[Move]:
        return [*[Move("step", self._do_step)] * 6,
                Move("terminate", self.driver.terminate, TERMINATED)]

    def _event(self) -> list[Move]:
        return [Move("update discrete states", self._update),
                *[Move("enter continuous time", self._enter_continuous, CONTINUOUS)] * 3,
                Move("terminate", self.driver.terminate, TERMINATED)]

    def _continuous(self) -> list[Move]:
        return [Move("advance", self._advance), Move("derivatives", self._rates),
                Move("completed step", self._complete),
                Move("enter event mode", lambda: self.driver.call("EnterEventMode"), EVENT),
                Move("terminate", self.driver.terminate, TERMINATED)]

    def _enter(self) -> int:
        status = self.driver.setup(self.subject.start_time)
        return self.driver.enter_initialization() if good(status) else status

    def _inputs(self) -> Array:
        return self.lab.excitation.at(self.k)

    def _set(self) -> int:
        variables, values = self.subject.inputs, self._inputs()
        if self.mode == CONTINUOUS:  # discrete ones change at events only
            values = values[[v.continuous for v in variables for _ in range(v.size)]]
            variables = [v for v in variables if v.continuous]
        return self.driver.set(variables, values) if variables else 0

    def _set_start(self) -> int:
        variables = [v for v in self.subject.settable_at_start()
                     if v.start is not None and v.causality != "input"]
        if not variables:
            return 0
        chosen = variables[int(self.rng.integers(len(variables)))]
        assert chosen.start is not None
        return self.driver.set([chosen], chosen.start)

    def _get(self) -> int:
        status, values = self.driver.get(self.lab.watched)
        if good(status) and not np.all(np.isfinite(values)):
            self.unsound = "values that are not finite, with status OK"
        return status

    def _time(self) -> float:
        return self.subject.start_time + self.k * self.subject.step

    def _do_step(self) -> int:
        status = self.driver.do_step(self._time(), self.subject.step)
        if self.driver.ended(status):
            return self._end()
        self.k += good(status)
        return status

    def _update(self) -> int:
        status, info = self.driver.update_discrete()
        return self._end() if good(status) and info.terminate else status

    def _complete(self) -> int:
        status, _, end = self.driver.completed_step()
        return self._end() if good(status) and end else status

    def _end(self) -> int:
        """Do as the FMU asks."""
        self.mode = TERMINATED
        return self.driver.terminate()

    def _save(self) -> int:
        status, state = self.driver.save()
        if good(status):
            self.saved[self.mode] = (state, self.k)
        return status

    def _restore(self) -> int:
        state, k = self.saved[self.mode]
        status = self.driver.restore(state)
        if good(status):
            self.k = k
        return status

    def _enter_continuous(self) -> int:
        for _ in range(50):
            status, info = self.driver.update_discrete()
            if good(status) and info.terminate:
                return self._end()
            if not good(status) or not info.again:
                break
        return self.driver.call("EnterContinuousTimeMode") if good(status) else status

    def _advance(self) -> int:
        # less than a step, so that no event is passed over
        return self.driver.set_time(self._time() + 1e-6 * self.subject.step)

    def _rates(self) -> int:
        n = sum(v.size for v in self.subject.states)
        status, x = self.driver.get_states(n)
        status = max(status, self.driver.set_states(x)) if n else status
        return max(status, self.driver.get_rates(n)[0])
