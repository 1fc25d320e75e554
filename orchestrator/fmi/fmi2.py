"""An instance of an FMI 2.0 co-simulation FMU, reached through its own C functions."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Sequence
from ctypes import c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import calloc, free

from ..schedule.plan import Array, Block
from ..wiring.graph import Setting
from .library import references
from .log import OK
from .slave import DOUBLES, UNSIGNED, Call, Slave

TERMINATED, LAST_SUCCESSFUL_TIME = 3, 2  # fmi2StatusKind
CO_SIMULATION = 1  # fmi2Type

_Logger = ctypes.CFUNCTYPE(None, c_void_p, c_char_p, c_int, c_char_p, c_char_p)
_Allocate = ctypes.CFUNCTYPE(c_void_p, c_size_t, c_size_t)
_Free = ctypes.CFUNCTYPE(None, c_void_p)
_Finished = ctypes.CFUNCTYPE(None, c_void_p, c_int)


class _Callbacks(ctypes.Structure):
    """fmi2CallbackFunctions"""

    _fields_ = (
        ("logger", _Logger),
        ("allocateMemory", _Allocate),
        ("freeMemory", _Free),
        ("stepFinished", _Finished),
        ("componentEnvironment", c_void_p),
    )


class Slave2(Slave):
    """See :class:`.slave.Slave`."""

    prefix = "fmi2"
    state_word = "state"
    _deserialize = "DeSerializeFMUstate"
    dtypes = {"Real": np.float64, "Integer": np.intc, "Boolean": np.intc}  # noqa: RUF012

    def _instantiate(self, folder: Path) -> int | None:
        self._callbacks = self._make_callbacks()
        instantiate = self.library.bind(
            "fmi2Instantiate", c_char_p, c_int, c_char_p, c_char_p, ctypes.POINTER(_Callbacks),
            c_int, c_int, result=c_void_p,
        )  # fmt: skip
        resources = (folder / "resources").as_uri()
        component: int | None = instantiate(
            self.name.encode(), CO_SIMULATION, self.fmu.token.encode(), resources.encode(),
            ctypes.byref(self._callbacks), 0, 1,
        )  # fmt: skip
        if component:
            handle = c_void_p(component)
            self._final = c_int(self.final)
            self._step = partial(self.library.raw("fmi2DoStep"), handle)
        return component

    def initialise(self, settings: Iterable[Setting], start: float, stop: float | None) -> None:
        """See :meth:`.slave.Slave.initialise`."""
        self.time = start
        setup = self.call("SetupExperiment", c_int, c_double, c_double, c_int, c_double)
        defined = stop is not None
        self._must("setup", setup(self.handle, 0, 0.0, start, defined, stop if defined else 0.0))
        for setting in settings:
            self.set(setting)
        self._must("initialisation", self.call("EnterInitializationMode")(self.handle))

    def step(self, time: float, width: float) -> int:
        """See :meth:`.slave.Slave.step`."""
        return self._step(c_double(time), c_double(width), self._final)  # type: ignore[no-any-return]

    def reached(self) -> float | None:
        """See :meth:`.slave.Slave.reached`."""
        ended, time = c_int(0), c_double(self.time)
        asks = self.call("GetBooleanStatus", c_int, ctypes.POINTER(c_int))
        if asks(self.handle, TERMINATED, ctypes.byref(ended)) == OK and ended.value:
            return None
        tells = self.call("GetRealStatus", c_int, DOUBLES)
        status = tells(self.handle, LAST_SUCCESSFUL_TIME, ctypes.byref(time))
        return time.value if status == OK else None

    def derive(self, known: Sequence[int], orders: Sequence[int], data: Array) -> Call:
        """See :meth:`.slave.Slave.derive`."""
        count = len(known)
        return partial(
            self.library.raw("fmi2SetRealInputDerivatives"), self.handle,
            ctypes.byref(references(tuple(known))), c_size_t(count),
            ctypes.byref((c_int * count)(*orders)), c_void_p(data.ctypes.data),
        )  # fmt: skip

    def sensitivity(self, unknowns: Block, knowns: Block, seed: Array) -> Array:
        """See :meth:`.slave.Slave.sensitivity`."""
        result = np.zeros(unknowns.last - unknowns.first)
        function = self.call(
            "GetDirectionalDerivative", UNSIGNED, c_size_t, UNSIGNED, c_size_t, DOUBLES, DOUBLES
        )
        status = function(
            self.handle, references(unknowns.references), len(unknowns.references),
            references(knowns.references), len(knowns.references),
            seed.ctypes.data_as(DOUBLES), result.ctypes.data_as(DOUBLES),
        )  # fmt: skip
        self._must("partial derivatives", status)
        return result

    def _make_callbacks(self) -> _Callbacks:
        def message(_env: Any, _name: Any, status: int, category: bytes, text: bytes) -> None:
            self._said(status, category, (text or b"").replace(b"%%", b"%"))

        allocate, release = ctypes.cast(calloc, _Allocate), ctypes.cast(free, _Free)
        return _Callbacks(_Logger(message), allocate, release, _Finished(), None)
