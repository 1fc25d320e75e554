"""The pythonfmu slave that runs a block: FMI calls in, :class:`~.runtime.Instance` behind.

An exception that leaves a slave's method makes pythonfmu answer fmi2Fatal and drop its references
once too often; so only what pythonfmu cannot express otherwise is raised, and a failed step is
answered with fmi2Discard and log messages.
"""

from __future__ import annotations

import atexit
import ctypes
import sys
from functools import cache
from pathlib import Path
from typing import Any, ClassVar, NoReturn

from pythonfmu import Fmi2Slave
from pythonfmu.enums import Fmi2Status

from ...components.component import Component
from .runtime import Instance, InstanceError, read_layout

LAYOUT_FILE = "layout.json"
INSTANTIATED, INITIALIZATION, STEP, TERMINATED = (
    "instantiated", "initialization mode", "step mode", "terminated",
)  # fmt: skip


class BlockSlave(Fmi2Slave):  # type: ignore[misc]  # pythonfmu is untyped
    """Base of the slave that an FMU defines; it names its block and the block's structure."""

    block_class: ClassVar[type[Component]]
    structure: ClassVar[dict[str, int]]

    def __init__(self, **arguments: Any) -> None:
        super().__init__(**arguments)
        self.modelName = self.block_class.__name__
        layout = read_layout(Path(arguments["resources"]) / LAYOUT_FILE)
        self._instance = Instance(
            self.block_class(**self.structure), layout, arguments["instance_name"]
        )
        self._start_time = 0.0
        self._mode = INSTANTIATED
        release_at_exit(self.modelName, Path(arguments["resources"]).parent)
        search_once(arguments["resources"])

    def setup_experiment(
        self, start_time: float, stop_time: float | None, tolerance: float | None
    ) -> None:
        self._require_mode("fmi2SetupExperiment", INSTANTIATED)
        self._start_time = start_time
        if tolerance and "relative_tolerance" in self._instance.named:
            self._instance.named["relative_tolerance"][...] = tolerance

    def enter_initialization_mode(self) -> None:
        self._require_mode("fmi2EnterInitializationMode", INSTANTIATED)
        self._mode = INITIALIZATION
        self._instance.initialise(self._start_time)

    def exit_initialization_mode(self) -> None:
        self._require_mode("fmi2ExitInitializationMode", INITIALIZATION)
        self._mode = STEP
        self._instance.initialise(self._start_time)
        try:
            self._instance.require()
        except InstanceError as error:
            self._fail(error)

    def do_step(self, current_time: float, step_size: float) -> bool:
        if self._mode != STEP:
            self._report(self._not_allowed("fmi2DoStep"))
            return False
        try:
            self._instance.step(current_time, step_size)
        except InstanceError as error:
            self._report(error)
            return False
        return True

    def terminate(self) -> None:
        self._require_mode("fmi2Terminate", STEP)
        self._mode = TERMINATED

    def get_real(self, vrs: list[int]) -> list[float]:
        try:
            values: list[float] = self._instance.get(vrs).tolist()
        except InstanceError as error:
            self._fail(error)
        return values

    def get_integer(self, vrs: list[int]) -> list[int]:
        return [int(v) for v in self.get_real(vrs)]

    def get_boolean(self, vrs: list[int]) -> list[bool]:
        return [bool(v) for v in self.get_real(vrs)]

    def set_real(self, vrs: list[int], values: list[float]) -> None:
        running = self._mode not in (INSTANTIATED, INITIALIZATION)
        self._instance.set(vrs, values, running)

    set_integer = set_boolean = set_real

    def _get_fmu_state(self) -> dict[str, Any]:
        return self._instance.state() | {"mode": self._mode, "start": self._start_time}

    def _set_fmu_state(self, state: dict[str, Any]) -> None:
        try:
            self._instance.restore(state)
            self._mode, self._start_time = state["mode"], state["start"]
        except (InstanceError, KeyError, TypeError):
            self._fail(InstanceError(["the saved state belongs to another FMU"]))

    def _require_mode(self, function: str, mode: str) -> None:
        if self._mode != mode:
            self._fail(self._not_allowed(function))

    def _not_allowed(self, function: str) -> InstanceError:
        state = f"the instance is in state: {self._mode}"
        return InstanceError([f"{function} is not allowed here ({state})"])

    def _report(self, error: InstanceError) -> None:
        for problem in error.problems:
            self.log(problem.replace("%", "%%"), Fmi2Status.error)

    def _fail(self, error: InstanceError) -> NoReturn:
        self._report(error)
        for released_twice in (self, type(self), self.log_queue):
            keep(released_twice)
        raise error


@cache
def release_at_exit(name: str, folder: Path) -> None:
    """Have pythonfmu's binary let go of its interpreter before the process ends.

    Left to itself it does so twice, the second time on freed memory. Only where the host is a
    Python process: elsewhere the binary owns the interpreter and ends it.
    """
    binary = folder / "binaries" / "linux64" / f"{name}.so"
    if sys.orig_argv and binary.is_file():
        atexit.register(ctypes.CDLL(str(binary)).finalizePythonInterpreter)


def search_once(folder: str) -> None:
    """Drop the folder from the search path's front, where every new instance puts it once more."""
    if sys.path[0] == folder and folder in sys.path[1:]:
        del sys.path[0]


def keep(thing: object) -> None:
    """Add a reference for one that pythonfmu's binary releases without owning it."""
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
