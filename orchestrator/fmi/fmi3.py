"""An instance of an FMI 3.0 co-simulation FMU, reached through its own C functions."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Iterable
from ctypes import c_bool, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..schedule.plan import Array, Block
from ..wiring.graph import Setting
from .library import references
from .log import ENDED, OK, STUCK, WARNING
from .slave import DOUBLES, UNSIGNED, Call, Slave

BOOL = ctypes.POINTER(c_bool)
ROUNDS = 100  # of event iteration

_Logger = ctypes.CFUNCTYPE(None, c_void_p, c_int, c_char_p, c_char_p)


class Slave3(Slave):
    """See :class:`.slave.Slave`. Event mode is used where the FMU has it."""

    prefix = "fmi3"
    state_word = "State"
    _deserialize = "DeserializeFMUState"
    dtypes = {  # noqa: RUF012
        "Float64": np.float64, "Float32": np.float32, "Int8": np.int8, "UInt8": np.uint8,
        "Int16": np.int16, "UInt16": np.uint16, "Int32": np.int32, "UInt32": np.uint32,
        "Int64": np.int64, "UInt64": np.uint64, "Boolean": np.bool_,
    }  # fmt: skip

    def _instantiate(self, folder: Path) -> int | None:
        def message(_env: Any, status: int, category: bytes, text: bytes) -> None:
            self._said(status, category, text)

        self._logger = _Logger(message)
        instantiate = self.library.bind(
            "fmi3InstantiateCoSimulation", c_char_p, c_char_p, c_char_p, c_bool, c_bool, c_bool,
            c_bool, c_void_p, c_size_t, c_void_p, _Logger, c_void_p, result=c_void_p,
        )  # fmt: skip
        events = self.fmu.event_mode
        resources = str(folder / "resources") + os.path.sep
        component: int | None = instantiate(
            self.name.encode(), self.fmu.token.encode(), resources.encode(), False, True, events,
            events, None, 0, None, self._logger, None,
        )  # fmt: skip
        self._known: list[Array] = []  # discrete inputs as the FMU has them
        self._event, self._end, self._early = c_bool(), c_bool(), c_bool()
        self._last = c_double()
        self._final = c_bool(self.final)
        if component:
            self._step = partial(self.library.raw("fmi3DoStep"), c_void_p(component))
        return component

    def initialise(self, settings: Iterable[Setting], start: float, stop: float | None) -> None:
        """See :meth:`.slave.Slave.initialise`."""
        self.time = start
        for setting in settings:
            self.set(setting)
        enter = self.call(
            "EnterInitializationMode", c_bool, c_double, c_double, c_bool, c_double
        )
        status = enter(self.handle, False, 0.0, start, stop is not None, stop or 0.0)
        self._must("initialisation", status)

    def start(self) -> None:
        """Leave initialisation mode, and the event mode that follows it."""
        super().start()
        if self.fmu.event_mode:
            self._must("its initial events", self._update())

    def step(self, time: float, width: float) -> int:
        """Step, handling events and going on after an early return; a status."""
        end = time + width
        near = 1e-12 * max(abs(end), width)
        for _ in range(ROUNDS):
            status: int = self._step(
                c_double(time), c_double(end - time), self._final, ctypes.byref(self._event),
                ctypes.byref(self._end), ctypes.byref(self._early), ctypes.byref(self._last),
            )  # fmt: skip
            if status > WARNING:
                return status
            if self._end.value:
                return ENDED
            if self._event.value and (status := self._events()) > WARNING:
                return status
            if not self._early.value or self._last.value >= end - near:
                return status
            time = self._last.value
        return STUCK

    def transfers(self, blocks: Iterable[Block], values: Array, read: bool) -> list[Call]:
        """See :meth:`.slave.Slave.transfers`. Discrete inputs change in event mode."""
        blocks = list(blocks)
        calls = super().transfers(blocks, values, read)
        return [
            self._changing(call, values[block.first:block.last]) if block.events and not read
            else call for block, call in zip(blocks, calls, strict=True)
        ]  # fmt: skip

    def _changing(self, ready: Call, view: Array) -> Call:
        """A call that sets inputs in event mode, if they have changed since it was last made."""
        known = np.full(len(view), np.nan)
        self._known.append(known)

        def transfer() -> int:
            if np.array_equal(known, view):
                return OK
            known[:] = view
            if not self._initialised:
                return ready()
            status: int = self.call("EnterEventMode")(self.handle)
            status = status if status > WARNING else ready()
            return status if status > WARNING else self._update()

        return transfer

    def restore(self, state: c_void_p) -> None:
        """See :meth:`.slave.Slave.restore`."""
        super().restore(state)
        for known in self._known:
            known[:] = np.nan  # what the state holds is not known

    def reached(self) -> float | None:
        """See :meth:`.slave.Slave.reached`."""
        return self._last.value

    def sensitivity(self, unknowns: Block, knowns: Block, seed: Array) -> Array:
        """See :meth:`.slave.Slave.sensitivity`."""
        result = np.zeros(unknowns.last - unknowns.first)
        function = self.call(
            "GetDirectionalDerivative", UNSIGNED, c_size_t, UNSIGNED, c_size_t, DOUBLES, c_size_t,
            DOUBLES, c_size_t,
        )  # fmt: skip
        status = function(
            self.handle, references(unknowns.references), len(unknowns.references),
            references(knowns.references), len(knowns.references),
            seed.ctypes.data_as(DOUBLES), len(seed),
            result.ctypes.data_as(DOUBLES), len(result),
        )  # fmt: skip
        self._must("partial derivatives", status)
        return result

    def _events(self) -> int:
        status: int = self.call("EnterEventMode")(self.handle)
        return status if status > WARNING else self._update()

    def _update(self) -> int:
        """Update discrete states until they rest, then go back to step mode; a status."""
        update = self.call("UpdateDiscreteStates", BOOL, BOOL, BOOL, BOOL, BOOL, DOUBLES)
        flags, time = [c_bool() for _ in range(5)], c_double()
        for _ in range(ROUNDS):
            status: int = update(
                self.handle, *(ctypes.byref(f) for f in flags), ctypes.byref(time)
            )
            if status > WARNING:
                return status
            if flags[1].value:
                return ENDED
            if not flags[0].value:
                return int(self.call("EnterStepMode")(self.handle))
        return STUCK

    def _data(self, array: NDArray[Any]) -> tuple[Any, ...]:
        return c_void_p(array.ctypes.data), c_size_t(len(array))

    def _texts(self, data: Any) -> tuple[Any, ...]:
        return data, c_size_t(len(data))
