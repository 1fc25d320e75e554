"""One instance of an FMU, driven through its raw C functions: what FMI 2.0 and 3.0 share.

Every method gives the status that the FMU answered and never raises for it. Before each call its
name is written to the trace, which outlives a crash.
"""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, TypeAlias

import numpy as np

from .subject import Array, Subject, Variable
from .trace import Trace

MESSAGE, MESSAGES = 300, 100  # bytes of a log message, and messages, that are kept
OK, WARNING, DISCARD, ERROR, FATAL, PENDING = range(6)
STATUS = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")
Handle: TypeAlias = ctypes.c_void_p
Values: TypeAlias = Sequence[float] | Array


_libraries: dict[tuple[Path, str], Any] = {}


def good(status: int) -> bool:
    """Whether a call was done."""
    return status in (OK, WARNING)


def status_name(status: int) -> str:
    """The status in words."""
    return STATUS[status] if 0 <= status < len(STATUS) else f"status {status}, which is none"


class NoInstance(Exception):
    """The FMU cannot be loaded or gives no instance; the text says what happened."""


@dataclass(frozen=True)
class EventInfo:
    """What the FMU says after an update of its discrete states."""

    again: bool
    terminate: bool
    states_changed: bool
    next_time: float | None


@dataclass(frozen=True)
class Message:
    """One log message."""

    status: int
    category: str
    text: str


class Driver(ABC):
    """One instance. ``interface`` is ``cs`` or ``me``."""

    prefix: ClassVar[str]

    def __init__(self, subject: Subject, interface: str, name: str, trace: Trace) -> None:
        self.subject, self.interface, self.name, self.trace = subject, interface, name, trace
        self.log: list[Message] = []
        self.fatal = False
        self.freed = False
        self.functions: Any = self._load()
        self.component: Any = None

    def said(self, status: int, category: bytes | None, text: bytes | None) -> None:
        """Keep a log message; the latest if there are too many, the beginning of a long one."""
        words = ((b or b"")[:MESSAGE].decode(errors="replace") for b in (category, text))
        self.log.append(Message(status, *words))
        del self.log[:-MESSAGES]

    def call(self, function: str, *arguments: Any, note: str = "") -> int:
        """Call a function on this instance by its name without prefix; the status."""
        self.trace.call(f"{self.prefix}{function}{note}")
        status = int(getattr(self.functions, self.prefix + function)(self.component, *arguments))
        self.fatal = self.fatal or status == FATAL
        return status

    def instantiate(self, token: str | None = None) -> Driver:
        """Create the instance. Raises NoInstance; ``token`` stands in for the FMU's own."""
        self.trace.call(f"{self.prefix}Instantiate")
        self.component = self._instantiate(
            self.subject.description.guid if token is None else token
        )
        if not self.component:
            said = "; ".join(m.text for m in self.log) or "no message"
            raise NoInstance(f"{self.prefix}Instantiate gave no instance ({said})")
        return self

    def free(self) -> None:
        """Free the instance; nothing after a fatal error, which forbids it."""
        if self.component and not self.freed and not self.fatal:
            self.trace.call(f"{self.prefix}FreeInstance")
            getattr(self.functions, f"{self.prefix}FreeInstance")(self.component)
        self.freed = True

    def get(self, variables: Sequence[Variable]) -> tuple[int, Array]:
        """Worst status and the values of all scalars, in order."""
        return self._move("Get", variables, None)

    def set(self, variables: Sequence[Variable], values: Values) -> int:
        """Set all scalars."""
        return self._move("Set", variables, np.asarray(values, dtype=float))[0]

    def _move(
        self, verb: str, variables: Sequence[Variable], given: Array | None
    ) -> tuple[int, Array]:
        total = sum(v.size for v in variables)
        result = np.zeros(total) if given is None else given
        groups: dict[str, list[tuple[Variable, int]]] = {}
        at = 0
        for variable in variables:
            groups.setdefault(self._kind(variable), []).append((variable, at))
            at += variable.size
        worst = OK
        for kind, members in groups.items():
            where = np.concatenate([np.arange(a, a + v.size) for v, a in members])
            ctype = self._ctype(kind)
            references = [v.reference for v, _ in members]
            if given is None:
                buffer = (ctype * len(where))()
            else:
                convert = float if ctype in (ctypes.c_double, ctypes.c_float) else int
                buffer = (ctype * len(where))(*(convert(x) for x in given[where]))
            status = self.transfer(verb + kind, references, buffer)
            worst = max(worst, status)
            if given is None:
                result[where] = list(buffer)
        return worst, result

    @abstractmethod
    def transfer(self, function: str, references: Sequence[int], buffer: Any) -> int:
        """Call a getter or setter of one type with raw references."""

    @abstractmethod
    def _kind(self, variable: Variable) -> str:
        """Name of the type in the getter's name."""

    @abstractmethod
    def _ctype(self, kind: str) -> Any:
        """C type of a kind."""

    def _load(self) -> Any:
        """The library with typed functions. Raises NoInstance."""
        key = (self.subject.folder, self.interface)
        if key not in _libraries:
            slave, model = self._classes()
            info = self.subject.interfaces[self.interface]
            self.trace.call("loading the library")
            try:
                _libraries[key] = (slave if self.interface == "cs" else model)(
                    guid=self.subject.description.guid, instanceName=self.name,
                    modelIdentifier=info.modelIdentifier,
                    unzipDirectory=str(self.subject.folder.resolve()),
                ).dll
            except Exception as error:  # fmpy raises whatever the loader says
                raise NoInstance(str(error)) from None
        return _libraries[key]

    @abstractmethod
    def _classes(self) -> tuple[Any, Any]:
        """FMPy's classes for co-simulation and model exchange: they know the C types."""

    @abstractmethod
    def _instantiate(self, token: str) -> Any: ...

    @abstractmethod
    def setup(
        self, start: float, stop: float | None = None, tolerance: float | None = None
    ) -> int:
        """Times and tolerance, before initialisation."""

    @abstractmethod
    def enter_initialization(self) -> int:
        """Enter initialisation mode."""

    def exit_initialization(self) -> int:
        """Leave initialisation mode."""
        return self.call("ExitInitializationMode")

    def terminate(self) -> int:
        """End the simulation."""
        return self.call("Terminate")

    def reset(self) -> int:
        """Back to the state after instantiation."""
        return self.call("Reset")

    @abstractmethod
    def do_step(self, time: float, h: float) -> int:
        """One communication step."""

    @abstractmethod
    def ended(self, status: int) -> bool:
        """Whether the FMU asked, in the step that gave this status, to end the simulation."""

    @abstractmethod
    def stepper(self, h: float) -> Callable[[float], int]:
        """A lean step of fixed size from a given time on, for very many steps."""

    @abstractmethod
    def last_time(self) -> float | None:
        """The internal time, if the FMU tells it."""

    # state ---------------------------------------------------------------------------------

    state_word: ClassVar[str]
    decode_word: ClassVar[str]
    byte: ClassVar[Any]

    def save(self, handle: Handle | None = None) -> tuple[int, Handle]:
        """A copy of the complete state; an existing one is overwritten."""
        state = ctypes.c_void_p() if handle is None else handle
        return self.call(f"Get{self.state_word}", ctypes.byref(state)), state

    def restore(self, state: Handle) -> int:
        """Go back to a saved state."""
        return self.call(f"Set{self.state_word}", state)

    def drop(self, state: Handle) -> int:
        """Free a saved state."""
        return self.call(f"Free{self.state_word}", ctypes.byref(state))

    def serialize(self, state: Handle) -> tuple[int, bytes]:
        """A saved state as bytes."""
        size = ctypes.c_size_t()
        status = self.call(f"Serialized{self.state_word}Size", state, ctypes.byref(size))
        if not good(status):
            return status, b""
        buffer = (self.byte * size.value)()
        return self.call(f"Serialize{self.state_word}", state, buffer, size.value), bytes(
            memoryview(buffer).cast("B")
        )

    def deserialize(self, data: bytes) -> tuple[int, Handle]:
        """A saved state from bytes."""
        state = ctypes.c_void_p()
        buffer = (self.byte * max(len(data), 1))()
        ctypes.memmove(buffer, data, len(data))
        function = f"{self.decode_word}{self.state_word}"
        return self.call(function, buffer, len(data), ctypes.byref(state)), state

    @abstractmethod
    def directional(
        self, unknowns: Sequence[Variable], knowns: Sequence[Variable], seed: Values
    ) -> tuple[int, Array]:
        """Directional derivative: Jacobian times seed."""

    # model exchange ------------------------------------------------------------------------

    @abstractmethod
    def update_discrete(self) -> tuple[int, EventInfo]:
        """One iteration of event mode."""

    @abstractmethod
    def completed_step(self) -> tuple[int, bool, bool]:
        """Tell that an integrator step is complete; whether event mode and the end are wanted."""

    rates_function: ClassVar[str]

    def set_time(self, time: float) -> int:
        """Set the time (model exchange)."""
        return self.call("SetTime", time, note=f"({time:g})")

    def get_states(self, n: int) -> tuple[int, Array]:
        """Continuous states."""
        return self._vector("GetContinuousStates", n)

    def get_rates(self, n: int) -> tuple[int, Array]:
        """Derivatives of the continuous states."""
        return self._vector(self.rates_function, n)

    def set_states(self, x: Array) -> int:
        """Set the continuous states."""
        return self.call("SetContinuousStates", (ctypes.c_double * len(x))(*x), len(x))

    def _vector(self, function: str, n: int) -> tuple[int, Array]:
        buffer = (ctypes.c_double * n)()
        return self.call(function, buffer, n), np.array(buffer)


def reals(values: Values) -> Any:
    """A C array of doubles."""
    return (ctypes.c_double * len(values))(*map(float, values))


def references_of(variables: Sequence[Variable]) -> Any:
    """A C array of value references."""
    return (ctypes.c_uint * len(variables))(*(v.reference for v in variables))
