"""An instance of an FMI 2.0 FMU."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import fmpy
import numpy as np
from fmpy import fmi2 as api

from .driver import DISCARD, Driver, EventInfo, Values, reals, references_of
from .subject import Array, Variable


class Driver2(Driver):
    """FMI 2.0."""

    prefix = "fmi2"
    state_word = "FMUstate"
    decode_word = "DeSerialize"
    byte = ctypes.c_char
    rates_function = "GetDerivatives"
    _start = 0.0

    def _classes(self) -> tuple[Any, Any]:
        return api.FMU2Slave, api.FMU2Model

    def _instantiate(self, token: str) -> Any:
        def message(_env: Any, _name: bytes, status: int, category: bytes, text: bytes) -> None:
            self.said(status, category, text)

        callbacks = api.fmi2CallbackFunctions()
        callbacks.logger = api.fmi2CallbackLoggerTYPE(message)
        callbacks.allocateMemory = api.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
        callbacks.freeMemory = api.fmi2CallbackFreeMemoryTYPE(fmpy.free)
        self._callbacks = callbacks  # they must live as long as the instance
        resources = (self.subject.folder / "resources").resolve().as_uri()
        kind = api.fmi2CoSimulation if self.interface == "cs" else api.fmi2ModelExchange
        return self.functions.fmi2Instantiate(
            self.name.encode(), kind, token.encode(), resources.encode(),
            ctypes.byref(callbacks), 0, 1,
        )

    def _kind(self, variable: Variable) -> str:
        return "Integer" if variable.type == "Enumeration" else variable.type

    def _ctype(self, kind: str) -> Any:
        return ctypes.c_double if kind == "Real" else ctypes.c_int

    def transfer(self, function: str, references: Sequence[int], buffer: Any) -> int:
        vr = (ctypes.c_uint * len(references))(*references)
        return self.call(function, vr, len(references), buffer)

    def setup(
        self, start: float, stop: float | None = None, tolerance: float | None = None
    ) -> int:
        self._start = start
        return self.call(
            "SetupExperiment", int(tolerance is not None), tolerance or 0.0, start,
            int(stop is not None), stop or 0.0,
        )

    def enter_initialization(self) -> int:
        return self.call("EnterInitializationMode")

    def do_step(self, time: float, h: float) -> int:
        return self.call("DoStep", time, h, 0, note=f"({time:.9g}, {h:.9g})")

    def ended(self, status: int) -> bool:
        if status != DISCARD:
            return False
        value = ctypes.c_int()
        asked = self.call("GetBooleanStatus", api.fmi2Terminated, ctypes.byref(value))
        return asked == 0 and bool(value.value)

    def stepper(self, h: float) -> Callable[[float], int]:
        self.trace.call(f"fmi2DoStep of {h:.9g} s, many times")
        function, component = self.functions.fmi2DoStep, self.component
        return lambda time: int(function(component, time, h, 1))

    def last_time(self) -> float | None:
        value = ctypes.c_double()
        status = self.call("GetRealStatus", api.fmi2LastSuccessfulTime, ctypes.byref(value))
        return value.value if status == 0 else None

    def directional(
        self, unknowns: Sequence[Variable], knowns: Sequence[Variable], seed: Values
    ) -> tuple[int, Array]:
        result = reals([0.0] * len(unknowns))
        status = self.call(
            "GetDirectionalDerivative", references_of(unknowns), len(unknowns),
            references_of(knowns), len(knowns), reals(seed), result,
        )
        return status, np.array(result)

    def update_discrete(self) -> tuple[int, EventInfo]:
        info = api.fmi2EventInfo()
        status = self.call("NewDiscreteStates", ctypes.byref(info))
        return status, EventInfo(
            bool(info.newDiscreteStatesNeeded), bool(info.terminateSimulation),
            bool(info.valuesOfContinuousStatesChanged),
            info.nextEventTime if info.nextEventTimeDefined else None,
        )

    def completed_step(self) -> tuple[int, bool, bool]:
        event, terminate = ctypes.c_int(), ctypes.c_int()
        status = self.call(
            "CompletedIntegratorStep", 1, ctypes.byref(event), ctypes.byref(terminate)
        )
        return status, bool(event.value), bool(terminate.value)
