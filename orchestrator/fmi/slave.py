"""A running FMU, whatever its version of FMI: life cycle, values, states, partial derivatives.

:mod:`.fmi2` and :mod:`.fmi3` say how each version names and calls its functions.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import c_double, c_size_t, c_uint, c_void_p
from functools import partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ..errors import RunError
from ..schedule.plan import Array, Block
from ..wiring.graph import Node, Setting
from .archive import PLATFORMS
from .library import load, references
from .log import DISCARD, FATAL, OK, TRAP, WARNING, RunLog, status_name

Call = Callable[[], int]
UNSIGNED = ctypes.POINTER(c_uint)
DOUBLES = ctypes.POINTER(c_double)


class Slave(ABC):
    """One instance. Every method raises RunError when the FMU refuses, unless it says else."""

    isolated: ClassVar[bool] = False  # whether it runs in a process of its own
    prefix: ClassVar[str]
    state_word: ClassVar[str]  # how the names of functions of states spell "state"
    dtypes: ClassVar[Mapping[str, Any]]  # numpy's type for each type of variable

    def __init__(self, node: Node, folder: Path, log: RunLog) -> None:
        self.name = node.name
        self.fmu = node.fmu
        self.log = log
        self.time = 0.0
        self.dead = False  # after fatal, or a trap, no function may be called
        self._initialised = False
        self.final = not node.fmu.can_restore  # whether no state of before will be restored
        try:
            self.library = load(folder, node.fmu.identifier, PLATFORMS[node.fmu.version])
            component = self._instantiate(folder)
        except (OSError, AttributeError) as error:
            self.dead = True
            raise RunError(self.name, 0.0, "loading", "error", str(error)) from None
        if not component:
            self.dead = True
            raise RunError(self.name, 0.0, "instantiation", "error", log.complaint(self.name))
        self.component: int = component
        self.handle = c_void_p(component)

    @abstractmethod
    def _instantiate(self, folder: Path) -> int | None:
        """The component. Raises AttributeError if the binary lacks a function."""

    @abstractmethod
    def initialise(self, settings: Iterable[Setting], start: float, stop: float | None) -> None:
        """Set parameters and start values, and enter initialisation mode."""

    @abstractmethod
    def step(self, time: float, width: float) -> int:
        """Step; a status."""

    @abstractmethod
    def reached(self) -> float | None:
        """The time that a discarded step reached; None if the FMU asks to end, or cannot say."""

    def derive(self, known: Sequence[int], orders: Sequence[int], data: Array) -> Call:
        """A call that sets derivatives of inputs from an array, for FMUs that interpolate."""
        raise NotImplementedError

    def start(self) -> None:
        """Leave initialisation mode."""
        self._must("initialisation", self.call("ExitInitializationMode")(self.handle))
        self._initialised = True

    def call(self, name: str, *types: Any, result: Any = ctypes.c_int) -> Any:
        """A function of the FMU, bound with the component and these types."""
        return self.library.bind(f"{self.prefix}{name}", c_void_p, *types, result=result)

    def transfers(self, blocks: Iterable[Block], values: Array, read: bool) -> list[Call]:
        """Calls that move blocks of values between the FMU and the array; each gives a status."""
        calls: list[Call] = []
        for block in blocks:
            view = values[block.first:block.last]
            # a function of its own, without argument types: ready-made arguments pass unconverted
            function = self.library.raw(self.function(block.type, read))
            ready = partial(
                function, self.handle, ctypes.byref(references(block.references)),
                c_size_t(len(block.references)),
            )  # fmt: skip
            dtype = np.dtype(self.dtypes[block.type])
            if dtype == np.float64:
                calls.append(partial(ready, *self._data(view)))
            else:
                buffer = np.zeros(len(view), dtype=dtype)
                calls.append(_converting(partial(ready, *self._data(buffer)), buffer, view, read))
        return calls

    def function(self, type_: str, read: bool) -> str:
        """The name of the function that gets or sets values of a type."""
        return f"{self.prefix}{'Get' if read else 'Set'}{type_}"

    def _data(self, array: NDArray[Any]) -> tuple[Any, ...]:
        """The arguments that pass values: a pointer, and in FMI 3.0 their number."""
        return (c_void_p(array.ctypes.data),)

    def set(self, setting: Setting) -> None:
        """Set a parameter or start value."""
        port, values = setting.port, setting.values
        known = tuple(dict.fromkeys(port.references))
        data: Any
        if port.kind == "string":
            data = (ctypes.c_char_p * port.size)(*(str(v).encode() for v in values))
        else:
            data = np.array(values, dtype=self.dtypes[port.type]).reshape(-1)
        pointer = self._data(data) if port.kind != "string" else self._texts(data)
        function = self.library.raw(self.function(port.type, read=False))
        status = function(self.handle, references(known), c_size_t(len(known)), *pointer)
        self._must(f"setting {port.name}", status)

    def _texts(self, data: Any) -> tuple[Any, ...]:
        return (data,)

    def check(self, action: str, status: int, time: float) -> None:
        """Raise RunError if a raw call at a time did not succeed."""
        self.time = time
        self._must(action, status)

    @abstractmethod
    def sensitivity(self, unknowns: Block, knowns: Block, seed: Array) -> Array:
        """The derivatives of real unknowns along a direction of real knowns."""

    def save(self) -> c_void_p:
        """The FMU's state; to be released."""
        state = c_void_p()
        function = self.call(f"GetFMU{self.state_word}", ctypes.POINTER(c_void_p))
        self._must("saving its state", function(self.handle, ctypes.byref(state)))
        return state

    def restore(self, state: c_void_p) -> None:
        """Go back to a saved state."""
        function = self.call(f"SetFMU{self.state_word}", c_void_p)
        self._must("restoring its state", function(self.handle, state))
        self._initialised = True

    def release(self, state: c_void_p) -> None:
        """Forget a saved state."""
        if not self.dead:
            function = self.call(f"FreeFMU{self.state_word}", ctypes.POINTER(c_void_p))
            function(self.handle, ctypes.byref(state))

    def serialize(self) -> bytes:
        """The FMU's state as bytes."""
        state, size = self.save(), c_size_t()
        try:
            sizes = self.call(
                f"SerializedFMU{self.state_word}Size", c_void_p, ctypes.POINTER(c_size_t)
            )
            self._must("saving its state", sizes(self.handle, state, ctypes.byref(size)))
            data = ctypes.create_string_buffer(size.value)
            write = self.call(f"SerializeFMU{self.state_word}", c_void_p, ctypes.c_char_p, c_size_t)
            self._must("saving its state", write(self.handle, state, data, size))
            return data.raw
        finally:
            self.release(state)

    def deserialize(self, data: bytes) -> None:
        """Go to a state that was written as bytes, by this or another process."""
        state = c_void_p()
        read = self.call(
            self._deserialize, ctypes.c_char_p, c_size_t, ctypes.POINTER(c_void_p)
        )
        status = read(self.handle, data, len(data), ctypes.byref(state))
        self._must("reading a saved state", status)
        try:
            self.restore(state)
        finally:
            self.release(state)

    _deserialize: ClassVar[str]

    def free(self) -> None:
        """Terminate and free the FMU, as far as its state allows."""
        if self.dead:
            return
        self.dead = True
        if self._initialised:
            self.call("Terminate")(self.handle)
        self.call("FreeInstance", result=None)(self.handle)

    def _must(self, action: str, status: int) -> None:
        if status in (OK, WARNING):
            return
        if status == FATAL or status >= TRAP:
            self.dead = True
        else:
            self._initialised = self._initialised and status == DISCARD
        raise RunError(
            self.name, self.time, action, status_name(status), self.log.complaint(self.name)
        )

    def _said(self, status: int, category: bytes | None, text: bytes | None) -> None:
        """Take a message of the FMU."""
        words = ((t or b"").decode(errors="replace") for t in (category, text))
        self.log.add(self.name, status, *words)


def _converting(
    ready: Call, buffer: NDArray[Any], view: Array, read: bool
) -> Call:
    """Values that are no doubles pass through a buffer of their own type."""

    def transfer() -> int:
        if not read:
            buffer[:] = view
        status = ready()
        if read:
            view[:] = buffer
        return status

    return transfer
