"""An FMU in a process of its own: what happens to it there does not happen to the run.

The process runs the same code over the FMU's functions as a run does over its own, with the values
in shared memory; so the bits are the same. Its death, or no answer in time, is a RunError.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from ctypes import c_void_p
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import RunError
from ..fmi.description import FmuDescription
from ..fmi.log import ERROR, LOST, OK, WARNING, RunLog
from ..fmi.slave import Call, Slave
from ..schedule.plan import Array, Block
from ..wiring.graph import Node, Setting
from .channel import REQUEST, STEP
from .process import Lost, Process, Refusal


def values_of(fmu: FmuDescription) -> int:
    """How many values must be shared: inputs set and read, derivatives of two orders, outputs."""
    driven = sum(port.size for port in fmu.inputs.values())
    return 4 * driven + sum(port.size for port in fmu.outputs.values()) + 1


class Isolated(Slave):
    """See :class:`..fmi.slave.Slave`."""

    isolated = True

    def __init__(self, node: Node, folder: Path, log: RunLog, process: Process) -> None:
        self.name, self.fmu, self.log = node.name, node.fmu, log
        self.time = 0.0
        self.dead = False
        self._initialised = False
        self._process = process
        self._used = 0  # of the shared memory
        self._sent: list[int] = []  # inputs that are being set
        self._refused = OK  # the status of inputs that were not
        self._refusals = 0
        self._ready: dict[tuple[str, tuple[int, ...], bool], tuple[int, Array]] = {}
        process.say = log.add
        try:
            process.await_start()
        except Lost:
            self.dead = True
            raise RunError(self.name, 0.0, "the start of its process", process.ended) from None
        self._call("loading", "load", replace(node, settings=()), folder)

    def _instantiate(self, folder: Path) -> int | None:
        raise NotImplementedError

    def initialise(self, settings: Iterable[Setting], start: float, stop: float | None) -> None:
        """See :meth:`..fmi.slave.Slave.initialise`."""
        self.time = start
        self._call("initialisation", "initialise", tuple(settings), start, stop)

    def start(self) -> None:
        """See :meth:`..fmi.slave.Slave.start`."""
        self._call("initialisation", "start")
        self._initialised = True

    def step(self, time: float, width: float) -> int:
        """See :meth:`..fmi.slave.Slave.step`."""
        return self._ask(STEP, time, width)

    def reached(self) -> float | None:
        """See :meth:`..fmi.slave.Slave.reached`."""
        return self._call("the step", "reached")  # type: ignore[no-any-return]

    def transfers(self, blocks: Iterable[Block], values: Array, read: bool) -> list[Call]:
        """See :meth:`..fmi.slave.Slave.transfers`."""
        return [self._transfer(b, values[b.first:b.last], read) for b in blocks]

    def derive(self, known: Sequence[int], orders: Sequence[int], data: Array) -> Call:
        """See :meth:`..fmi.slave.Slave.derive`."""
        first, shared = self._share(len(known))
        code = self._call("setting inputs", "derive", tuple(known), tuple(orders), first)
        return self._put(code, data[:len(known)], shared)

    def set(self, setting: Setting) -> None:
        """See :meth:`..fmi.slave.Slave.set`."""
        self._call(f"setting {setting.port.name}", "set", setting)

    def sensitivity(self, unknowns: Block, knowns: Block, seed: Array) -> Array:
        """See :meth:`..fmi.slave.Slave.sensitivity`."""
        result: Array = self._call("partial derivatives", "sensitivity", unknowns, knowns, seed)
        return result

    def save(self) -> c_void_p:
        """A number for the FMU's state, which stays in its process; to be released."""
        return c_void_p(self._call("saving its state", "save"))

    def restore(self, state: c_void_p) -> None:
        """See :meth:`..fmi.slave.Slave.restore`."""
        self._call("restoring its state", "restore", state.value)

    def release(self, state: c_void_p) -> None:
        """See :meth:`..fmi.slave.Slave.release`."""
        if not self.dead:
            self._call("releasing its state", "release", state.value)

    def serialize(self) -> bytes:
        """See :meth:`..fmi.slave.Slave.serialize`."""
        return self._call("saving its state", "serialize")  # type: ignore[no-any-return]

    def deserialize(self, data: bytes) -> None:
        """See :meth:`..fmi.slave.Slave.deserialize`."""
        self._call("reading a saved state", "deserialize", data)

    def free(self) -> None:
        """Terminate and free the FMU, and end its process."""
        if not self._process.ended:
            try:
                self._settle()
                self._process.call("free")
            except Lost:  # the results are there: no reason to fail
                what = f"being freed ended with {self._process.ended}"
                self.log.add(self.name, WARNING, "isolation", what)
        self.dead = True
        self._process.close()

    def _transfer(self, block: Block, view: Array, read: bool) -> Call:
        key = block.type, block.references, read
        if key not in self._ready:
            first, shared = self._share(len(view))
            there = replace(block, first=first, last=first + len(view))
            self._ready[key] = self._call("preparing transfers", "transfer", there, read), shared
        code, shared = self._ready[key]
        if not read:
            return self._put(code, view, shared)

        def get() -> int:
            status = self._ask(code)
            if status <= WARNING:
                np.copyto(view, shared)
            return status

        return get

    def _share(self, count: int) -> tuple[int, Array]:
        """A part of the shared memory that nothing uses yet: where it begins, and the part."""
        first, self._used = self._used, self._used + count
        assert self._used <= len(self._process.values)
        return first, self._process.values[first:self._used]

    def _put(self, code: int, view: Array, shared: Array) -> Call:
        def put() -> int:
            status = self._settle() if code in self._sent else OK
            np.copyto(shared, view)
            return status if status > WARNING else self._send(code)

        return put

    def _send(self, code: int) -> int:
        """Have inputs set, and do not wait: the next call tells if they were not."""
        try:
            self._process.send(REQUEST.pack(code, self._refusals, 0.0, 0.0))
        except Lost:
            return self._lose()
        self._sent.append(code)
        return OK

    def _settle(self) -> int:
        """Wait until all inputs are set; the status of the first that were not, if any."""
        first = OK
        try:
            for _ in self._sent:
                status = self._process.answer()
                first = status if first <= WARNING else first
        except Lost:
            return self._lose()
        finally:
            self._sent.clear()
        self._refusals += first > WARNING
        return first

    def _ask(self, code: int, time: float = 0.0, width: float = 0.0) -> int:
        try:
            self._process.send(REQUEST.pack(code, self._refusals, time, width))
            if (refused := self._settle()) > WARNING:
                self._refused = refused
            status = self._process.answer()
        except Lost:
            return self._lose()
        return ERROR if self._refused else status

    def _lose(self) -> int:
        self.dead = True
        return LOST

    def _call(self, action: str, name: str, *arguments: Any) -> Any:
        if (status := self._settle()) > WARNING:
            self._must("setting inputs", status)
        try:
            return self._process.call(name, *arguments)
        except Refusal as refusal:
            action, status, message = refusal.args
            message = self.log.complaint(self.name) or message
            raise RunError(self.name, self.time, action, status, message) from None
        except Lost:
            self.dead = True
            raise RunError(self.name, self.time, action, self._process.ended) from None

    def _must(self, action: str, status: int) -> None:
        if self._refused:
            action, status, self._refused = "setting inputs", self._refused, OK
        if self._process.ended:
            raise RunError(self.name, self.time, action, self._process.ended)
        super()._must(action, status)
