"""An instance of an FMI 2.0 co-simulation FMU, reached through its own C functions."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from fmpy import calloc, free
from fmpy import fmi2 as api

from .errors import RunError
from .graph import Node, Setting
from .log import DISCARD, FATAL, OK, WARNING, RunLog, status_name
from .plan import Array, Block

Call = Callable[[], int]


class Slave:
    """One running FMU. Every method raises RunError when the FMU refuses, unless it says else."""

    def __init__(self, node: Node, folder: Path, log: RunLog) -> None:
        self.name = node.name
        self.log = log
        self.time = 0.0
        self.dead = False  # after fatal no function may be called
        self._initialised = False
        try:
            self._fmu = api.FMU2Slave(
                instanceName=node.name,
                guid=node.fmu.token,
                modelIdentifier=node.fmu.identifier,
                unzipDirectory=str(folder),
            )
        except Exception as error:  # fmpy raises whatever the loader says
            raise RunError(self.name, 0.0, "loading", "error", str(error)) from None
        self._functions = self._fmu.dll
        self._callbacks = self._make_callbacks()
        try:
            self._fmu.instantiate(callbacks=self._callbacks, loggingOn=True)
        except Exception:
            self.dead = True
            raise RunError(
                self.name, 0.0, "instantiation", "error", log.last(self.name)
            ) from None
        self.component: int = self._fmu.component
        self._handle = ctypes.c_void_p(self.component)

    def initialise(self, settings: Iterable[Setting], start: float, stop: float) -> None:
        """Set parameters and start values, and enter initialisation mode."""
        self.time = start
        setup = self._functions.fmi2SetupExperiment
        self._must("setup", setup(self.component, 0, 0.0, start, 1, stop))
        for setting in settings:
            self._must(f"setting {setting.port.name}", self._set(setting))
        enter = self._functions.fmi2EnterInitializationMode
        self._must("initialisation", enter(self.component))

    def start(self) -> None:
        """Leave initialisation mode."""
        leave = self._functions.fmi2ExitInitializationMode
        self._must("initialisation", leave(self.component))
        self._initialised = True

    def stepper(self, clock: ctypes.c_double, step: float) -> Call:
        """The raw step from the clock's time on; it gives a status."""
        function = self._fmu.dll["fmi2DoStep"]
        return partial(function, self._handle, clock, ctypes.c_double(step), ctypes.c_int(1))

    def transfers(self, blocks: Iterable[Block], values: Array, read: bool) -> list[Call]:
        """Calls that move blocks of values between the FMU and the array; each gives a status."""
        verb = "Get" if read else "Set"
        calls: list[Call] = []
        for block, kind in zip(blocks, ("Real", "Integer", "Boolean"), strict=True):
            if not block.references:
                continue
            count = len(block.references)
            references = ctypes.byref((ctypes.c_uint * count)(*block.references))
            # a function of its own, without argument types: ready-made arguments pass unconverted
            function = self._fmu.dll[f"fmi2{verb}{kind}"]
            ready = partial(function, self._handle, references, ctypes.c_size_t(count))
            view = values[block.first:block.last]
            if kind == "Real":
                data = (ctypes.c_double * count).from_buffer(view)  # type: ignore[arg-type]
                calls.append(partial(ready, ctypes.byref(data)))
            else:
                calls.append(_through_integers(ready, view, read))
        return calls

    def check(self, action: str, status: int, time: float) -> None:
        """Raise RunError if a raw call at a time did not succeed."""
        self.time = time
        self._must(action, status)

    def free(self) -> None:
        """Terminate and free the FMU, as far as its state allows."""
        if self.dead:
            return
        self.dead = True
        if self._initialised:
            self._functions.fmi2Terminate(self.component)
        self._fmu.freeInstance()

    def _set(self, setting: Setting) -> int:
        port, values = setting.port, setting.values
        count = port.size
        references = (ctypes.c_uint * count)(*port.references)
        data: Any
        if port.kind == "real":
            function = self._functions.fmi2SetReal
            data = (ctypes.c_double * count)(*map(float, values))
        elif port.kind == "string":
            texts = [str(v).encode() for v in values]
            function, data = self._functions.fmi2SetString, (ctypes.c_char_p * count)(*texts)
        else:
            verb = "Boolean" if port.kind == "boolean" else "Integer"
            function = getattr(self._functions, f"fmi2Set{verb}")
            data = (ctypes.c_int * count)(*(int(v) for v in values))
        return function(self.component, references, count, data)  # type: ignore[no-any-return]

    def _must(self, action: str, status: int) -> None:
        if status in (OK, WARNING):
            return
        if status == FATAL:
            self.dead = True
        else:
            self._initialised = self._initialised and status == DISCARD
        raise RunError(
            self.name, self.time, action, status_name(status), self.log.last(self.name)
        )

    def _make_callbacks(self) -> Any:
        """Callbacks of our own: fmpy's logger would read messages as printf formats."""

        def message(_env: Any, _name: bytes, status: int, category: bytes, text: bytes) -> None:
            decode = partial(bytes.decode, errors="replace")
            self.log.add(self.name, status, decode(category or b""), decode(text or b""))

        callbacks = api.fmi2CallbackFunctions()
        callbacks.logger = api.fmi2CallbackLoggerTYPE(message)
        callbacks.allocateMemory = api.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = api.fmi2CallbackFreeMemoryTYPE(free)
        return callbacks


def _through_integers(ready: Callable[[Any], int], view: Array, read: bool) -> Call:
    """Integers and booleans pass through a buffer of C integers."""
    buffer = np.zeros(len(view), dtype=np.intc)
    data = ctypes.byref((ctypes.c_int * len(view)).from_buffer(buffer))  # type: ignore[arg-type]

    def transfer() -> int:
        if not read:
            buffer[:] = view
        status = ready(data)
        if read:
            view[:] = buffer
        return status

    return transfer
