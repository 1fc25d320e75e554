"""An instance of an FMI 3.0 FMU."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fmpy import fmi3 as api

from .driver import Driver, EventInfo, Values, good, reals, references_of
from .subject import Array, Variable

CTYPES = {
    "Float64": ctypes.c_double, "Float32": ctypes.c_float, "Boolean": ctypes.c_bool,
    **{f"Int{n}": getattr(ctypes, f"c_int{n}") for n in (8, 16, 32, 64)},
    **{f"UInt{n}": getattr(ctypes, f"c_uint{n}") for n in (8, 16, 32, 64)},
}  # fmt: skip


class Driver3(Driver):
    """FMI 3.0."""

    prefix = "fmi3"
    state_word = "FMUState"
    decode_word = "Deserialize"
    byte = ctypes.c_uint8
    rates_function = "GetContinuousStateDerivatives"
    _experiment: tuple[float, float | None, float | None] = (0.0, None, None)
    _reached: float | None = None
    _end = False

    def _classes(self) -> tuple[Any, Any]:
        return api.FMU3Slave, api.FMU3Model

    def _instantiate(self, token: str) -> Any:
        def message(_env: Any, status: int, category: bytes, text: bytes) -> None:
            self.said(status, category, text)

        self._logger = api.fmi3LogMessageCallback(message)  # must live as long as the instance
        resources = str((self.subject.folder / "resources").resolve()) + "/"
        first = (self.name.encode(), token.encode(), resources.encode(), False, True)
        if self.interface == "me":
            return self.functions.fmi3InstantiateModelExchange(*first, None, self._logger)
        return self.functions.fmi3InstantiateCoSimulation(
            *first, False, False, None, 0, None, self._logger,
            api.fmi3IntermediateUpdateCallback(),
        )

    def _kind(self, variable: Variable) -> str:
        return "Int64" if variable.type == "Enumeration" else variable.type

    def _ctype(self, kind: str) -> Any:
        return CTYPES[kind]

    def transfer(self, function: str, references: Sequence[int], buffer: Any) -> int:
        vr = (ctypes.c_uint * len(references))(*references)
        return self.call(function, vr, len(references), buffer, len(buffer))

    def setup(
        self, start: float, stop: float | None = None, tolerance: float | None = None
    ) -> int:
        self._experiment = (start, stop, tolerance)
        return 0

    def enter_initialization(self) -> int:
        start, stop, tolerance = self._experiment
        return self.call(
            "EnterInitializationMode", tolerance is not None, tolerance or 0.0, start,
            stop is not None, stop or 0.0,
        )

    def do_step(self, time: float, h: float) -> int:
        event, end, early = (ctypes.c_bool() for _ in range(3))
        reached = ctypes.c_double()
        status = self.call(
            "DoStep", time, h, False, ctypes.byref(event), ctypes.byref(end),
            ctypes.byref(early), ctypes.byref(reached), note=f"({time:.9g}, {h:.9g})",
        )
        self._reached = reached.value if status == 0 else self._reached
        self._end = end.value
        return status

    def ended(self, status: int) -> bool:
        return good(status) and self._end

    def stepper(self, h: float) -> Callable[[float], int]:
        self.trace.call(f"fmi3DoStep of {h:.9g} s, many times")
        flags = [ctypes.c_bool() for _ in range(3)]
        reached = ctypes.c_double()
        out = (*(ctypes.byref(f) for f in flags), ctypes.byref(reached))
        function, component = self.functions.fmi3DoStep, self.component

        def step(time: float) -> int:
            status = int(function(component, time, h, True, *out))
            self._reached, self._end = reached.value, flags[1].value
            return status

        return step

    def last_time(self) -> float | None:
        return self._reached

    def directional(
        self, unknowns: Sequence[Variable], knowns: Sequence[Variable], seed: Values
    ) -> tuple[int, Array]:
        size = sum(v.size for v in unknowns)
        return self._sensitivity("GetDirectionalDerivative", unknowns, knowns, seed, size)

    def adjoint(
        self, unknowns: Sequence[Variable], knowns: Sequence[Variable], seed: Values
    ) -> tuple[int, Array]:
        """Adjoint derivative: transposed Jacobian times seed."""
        size = sum(v.size for v in knowns)
        return self._sensitivity("GetAdjointDerivative", unknowns, knowns, seed, size)

    def _sensitivity(
        self, function: str, unknowns: Sequence[Variable], knowns: Sequence[Variable],
        seed: Values, size: int,
    ) -> tuple[int, Array]:  # fmt: skip
        result = reals([0.0] * size)
        status = self.call(
            function, references_of(unknowns), len(unknowns), references_of(knowns), len(knowns),
            reals(seed), len(seed), result, size,
        )
        return status, np.array(result)

    def update_discrete(self) -> tuple[int, EventInfo]:
        again, end, _nominals, values, defined = flags = [ctypes.c_bool() for _ in range(5)]
        time = ctypes.c_double()
        status = self.call(
            "UpdateDiscreteStates", *(ctypes.byref(f) for f in flags), ctypes.byref(time)
        )
        return status, EventInfo(again.value, end.value, values.value,
                                 time.value if defined.value else None)

    def completed_step(self) -> tuple[int, bool, bool]:
        event, terminate = ctypes.c_bool(), ctypes.c_bool()
        status = self.call(
            "CompletedIntegratorStep", True, ctypes.byref(event), ctypes.byref(terminate)
        )
        return status, event.value, terminate.value
