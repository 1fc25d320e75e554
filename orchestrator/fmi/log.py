"""One log for the messages of all FMUs: kept in a file, with the latest errors of each instance."""

from __future__ import annotations

from contextlib import suppress
from pathlib import Path
from typing import IO

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")
ENDED, STUCK, LOST, TRAP = 100, 101, 102, 110  # of our own
TRAPS = ("arithmetic", "integer division by zero", "integer overflow", "division by zero",
         "overflow", "underflow", "an inexact result", "an invalid operation")  # fmt: skip
OUR_OWN = {
    ENDED: "a request to end the simulation", STUCK: "events without end",
    LOST: "the end of its process",
    **{TRAP + i: f"a trap (SIGFPE): {what}" for i, what in enumerate(TRAPS)},
}  # fmt: skip


def status_name(status: int) -> str:
    """The name of a status of FMI 2.0 or 3.0, or of our own."""
    if status in OUR_OWN:
        return OUR_OWN[status]
    return STATUS[status] if 0 <= status < len(STATUS) else f"the unknown status {status}"


MOST = 8  # messages that an error quotes


class RunLog:
    """Writes ``log.txt`` once there is something to write; counts warnings and worse."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.warnings = 0
        self._complaints: dict[str, tuple[int, list[str]]] = {}  # their status, their texts
        self._file: IO[str] | None = None
        if path is not None:
            path.unlink(missing_ok=True)

    def add(self, instance: str, status: int, category: str, message: str) -> None:
        """Take a message of an instance."""
        message = message.strip()
        if status > OK:
            self.warnings += 1
            self._complain(instance, status, ": ".join(message.splitlines()[:2]))
        with suppress(OSError):  # a full disk is the results' to tell
            self._write(f"{instance}: {status_name(status)} [{category}] {message}\n")

    def complaint(self, instance: str) -> str:
        """The errors of an instance since it was last asked for, or else its last warning."""
        _, texts = self._complaints.pop(instance, (OK, []))
        more = len(texts) - MOST
        return "; ".join([*texts[:MOST], *([f"and {more} more, see the log"] if more > 0 else [])])

    def _complain(self, instance: str, status: int, text: str) -> None:
        before, texts = self._complaints.get(instance, (OK, []))
        if status < before or (before, status) == (ERROR, FATAL):
            return  # what made the FMU give up says more than that it gave up
        texts = texts if status == before == ERROR else []
        self._complaints[instance] = status, [*texts, *([text] if text not in texts else [])]

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            with suppress(OSError):
                self._file.close()

    def _write(self, line: str) -> None:
        if self.path is not None:
            if self._file is None:
                self._file = self.path.open("w", encoding="utf-8")
            self._file.write(line)
            self._file.flush()
