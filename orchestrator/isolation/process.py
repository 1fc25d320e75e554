"""The process of an isolated FMU, seen from the run: asked, awaited, mourned."""

from __future__ import annotations

import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

from ..schedule.plan import Array
from .channel import (
    ANSWER,
    CALL,
    MESSAGE,
    REFUSAL,
    REQUEST,
    framed,
    mapped,
    memory,
    unframed,
    write,
)

START = 120.0  # s that the interpreter may take to be there
END = 5.0  # s that it may take to go when it is told to
GLANCE = 0.5  # s between looks at a process that does not answer

Say = Callable[[str, int, str, str], None]


class Lost(Exception):
    """The process is gone, or was ended because it did not answer: ``Process.ended`` says how."""


class Refusal(Exception):
    """The FMU did not do what a call asked: the action, its status, its own last word."""


class Process:
    """Runs :mod:`.server`. ``limit``: s that any one call may take.

    ``values``: shared with it, as many as are asked for. ``say`` gets the FMU's messages. Raises
    OSError if no process can be started.
    """

    def __init__(self, limit: float, count: int) -> None:
        if os.name == "nt":
            raise OSError("Windows has no means for it here; Linux and macOS do")
        self.limit = limit
        self.ended = ""
        self.say: Say = lambda *_: None
        shared = memory(count)
        self.values: Array = mapped(shared)
        requests, self._requests = os.pipe()
        self._answers, answers = os.pipe()
        files = requests, answers, shared
        command = [sys.executable, "-P", "-m", f"{__package__}.server", *map(str, files)]
        try:
            self._process = subprocess.Popen(
                command, pass_fds=files, stdin=subprocess.DEVNULL,
                process_group=0,  # Ctrl-C is for the run, which decides what becomes of this one
            )  # fmt: skip
        except BaseException:
            os.close(self._requests)
            os.close(self._answers)
            raise
        finally:
            for file in files:
                os.close(file)
        self._waiting = select.poll()
        self._waiting.register(self._answers, select.POLLIN)

    def await_start(self) -> None:
        """Wait until it takes requests. Raises Lost."""
        limit, self.limit = self.limit, START
        self.answer()
        unframed(self._read)
        self.limit = limit

    def send(self, request: bytes) -> None:
        """Send a request; there will be an answer to each, in their order. Raises Lost."""
        if self.ended:
            raise Lost
        try:
            write(self._requests, request)
        except BrokenPipeError:
            raise self._mourn() from None

    def answer(self) -> int:
        """The status that answers the first of the requests that is not answered. Raises Lost."""
        while True:
            code: int = ANSWER.unpack(self._read(ANSWER.size))[0]
            if code != MESSAGE:
                return code
            self.say(*unframed(self._read))

    def call(self, name: str, *arguments: Any) -> Any:
        """What a method of the FMU gives in its process. Raises Refusal, Lost."""
        self.send(framed(REQUEST.pack(CALL, 0, 0.0, 0.0), (name, arguments)))
        refused = self.answer() == REFUSAL
        content = unframed(self._read)
        if refused:
            raise Refusal(*content)
        return content

    def close(self) -> None:
        """End the process and give back everything."""
        if self._requests < 0:
            return
        os.close(self._requests)  # at the end of its requests it ends
        self._requests = -1
        try:
            self._process.wait(0.0 if self.ended else END)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        os.close(self._answers)

    def _read(self, count: int) -> bytes:
        """Read exactly so much. Raises Lost."""
        data = b""
        try:
            while len(data) < count:
                self._await()
                part = os.read(self._answers, count - len(data))
                if not part:
                    raise self._mourn()
                data += part
        except KeyboardInterrupt:  # what comes yet would be taken for the answer to the next call
            self._end("an interrupt")
            raise
        return data

    def _await(self) -> None:
        """Wait until there is something to read. Raises Lost."""
        if self._waiting.poll(min(self.limit, GLANCE) * 1e3):
            return
        deadline = time.monotonic() + self.limit - min(self.limit, GLANCE)
        while (left := deadline - time.monotonic()) > 0.0:
            if self._waiting.poll(min(left, GLANCE) * 1e3):
                return
            if self._process.poll() is not None and not self._waiting.poll(0):
                raise self._mourn()  # a process of its own still holds the pipe
        self._end(f"no answer within its time_limit of {self.limit:g} s")
        raise Lost

    def _mourn(self) -> Lost:
        """Find out how the process died."""
        try:
            code = self._process.wait(END)
        except subprocess.TimeoutExpired:
            self._end("the end of all contact with its process")
            return Lost()
        if code < 0:
            what = signal.strsignal(-code) or "unknown"
            self._end(f"the death of its process by {signal.Signals(-code).name} ({what.lower()})")
        else:
            self._end(f"the end of its process, exit status {code}")
        return Lost()

    def _end(self, how: str) -> None:
        self.ended = self.ended or how
        self._process.kill()
