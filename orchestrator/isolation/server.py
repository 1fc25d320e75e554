"""The process of an isolated FMU, seen from inside: takes requests, answers each.

    python -m sightline.orchestrator.isolation.server REQUESTS ANSWERS MEMORY

with the numbers of open files. It ends with its requests; if the run dies while the FMU does not
return, a thread notices and ends the process.
"""

from __future__ import annotations

import os
import select
import sys
import threading
import time
from contextlib import suppress
from ctypes import c_void_p
from pathlib import Path
from typing import Any

from ..errors import RunError
from ..fmi.fmi2 import Slave2
from ..fmi.fmi3 import Slave3
from ..fmi.log import ERROR, WARNING, RunLog
from ..fmi.slave import Call, Slave
from ..schedule.plan import Block
from ..wiring.graph import Node
from .channel import (
    ANSWER,
    CALL,
    MESSAGE,
    REFUSAL,
    REQUEST,
    RESULT,
    STEP,
    TRANSFERS,
    framed,
    mapped,
    unframed,
    write,
)

ORPHANED = 1  # exit status
END = 2.0  # s that the FMU may take to return when the run has died


class Server:
    """Serves one FMU."""

    def __init__(self, requests: int, answers: int, memory: int) -> None:
        self._requests, self._answers = requests, answers
        self._values = mapped(memory)
        self._transfers: dict[int, Call] = {}  # by the code of a request
        self._inputs: set[int] = set()  # those that set inputs
        self._refusals = 0  # of inputs
        self._states: dict[int, c_void_p] = {}
        self._lock = threading.Lock()  # an FMU may send messages from threads of its own

    def serve(self) -> None:
        """Answer requests until there are no more."""
        self._send(framed(ANSWER.pack(RESULT), None))
        while request := os.read(self._requests, REQUEST.size):
            what, known, instant, width = REQUEST.unpack(request)
            if what == CALL:
                self._call(*unframed(self._read))
                continue
            self._send(ANSWER.pack(self._do(what, instant, width, known)))

    def _do(self, what: int, time: float, width: float, known: int) -> int:
        """Step, or move values; a status."""
        if known < self._refusals:
            return ERROR
        status = self._slave.step(time, width) if what == STEP else self._transfers[what]()
        if status > WARNING:
            self._refusals += what in self._inputs
            with suppress(RunError):  # the run raises it; here it changes how the FMU is freed
                self._slave.check("", status, time)
        return status

    def load(self, node: Node, folder: Path) -> None:
        """Load and instantiate. Raises RunError."""
        kind = Slave3 if node.fmu.version_3 else Slave2
        self._slave: Slave = kind(node, folder, _Messages(self))

    def transfer(self, block: Block, read: bool) -> int:
        """Make a transfer between shared memory and the FMU; its code."""
        (call,) = self._slave.transfers([block], self._values, read)
        return self._add(call, is_input=not read)

    def derive(self, known: tuple[int, ...], orders: tuple[int, ...], first: int) -> int:
        """Make a transfer of derivatives of inputs; its code."""
        call = self._slave.derive(known, orders, self._values[first:])
        return self._add(call, is_input=True)

    def save(self) -> int:
        """Save the FMU's state; its number. Raises RunError."""
        state = self._slave.save()
        number = max(self._states, default=0) + 1
        self._states[number] = state
        return number

    def restore(self, number: int) -> None:
        """Go back to a saved state. Raises RunError."""
        self._slave.restore(self._states[number])

    def release(self, number: int) -> None:
        """Forget a saved state."""
        self._slave.release(self._states.pop(number))

    def say(self, *message: Any) -> None:
        """Send a message of the FMU, at once: what follows may end the process."""
        self._send(framed(ANSWER.pack(MESSAGE), message))

    def _call(self, name: str, arguments: tuple[Any, ...]) -> None:
        method = getattr(self, name, None) or getattr(self._slave, name)
        try:
            self._send(framed(ANSWER.pack(RESULT), method(*arguments)))
        except RunError as error:
            content = error.action, error.status, error.message
            self._send(framed(ANSWER.pack(REFUSAL), content))

    def _add(self, call: Call, is_input: bool) -> int:
        code = TRANSFERS + len(self._transfers)
        self._transfers[code] = call
        self._inputs |= {code} if is_input else set()
        return code

    def _read(self, count: int) -> bytes:
        data = b""
        while len(data) < count:
            part = os.read(self._requests, count - len(data))
            if not part:
                os._exit(ORPHANED)
            data += part
        return data

    def _send(self, data: bytes) -> None:
        with self._lock:
            write(self._answers, data)


class _Messages(RunLog):
    """Sends what the FMU says to the run's log."""

    def __init__(self, server: Server) -> None:
        super().__init__(None)
        self._server = server

    def add(self, instance: str, status: int, category: str, message: str) -> None:
        super().add(instance, status, category, message)
        self._server.say(instance, status, category, message)


def _end_with(requests: int) -> None:
    """End this process if it does not end by itself when there are no more requests."""
    hangup = select.poll()
    hangup.register(requests, 0)
    hangup.poll()
    time.sleep(END)
    os._exit(ORPHANED)


def main() -> None:
    """Serve the files that the arguments name."""
    files = [int(a) for a in sys.argv[1:]]
    for file in files:
        os.set_inheritable(file, False)  # processes of the FMU shall not keep them
    threading.Thread(target=_end_with, args=(files[0],), daemon=True).start()
    with suppress(BrokenPipeError):
        Server(*files).serve()


if __name__ == "__main__":
    main()
