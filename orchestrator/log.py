"""One log for the messages of all FMUs: kept in a file, with the last error of each instance."""

from __future__ import annotations

from pathlib import Path
from typing import IO

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
STATUS = ("OK", "warning", "discard", "error", "fatal", "pending")
ENDED, STUCK = 100, 101  # of our own
OUR_OWN = {ENDED: "a request to end the simulation", STUCK: "events without end"}


def status_name(status: int) -> str:
    """The name of a status of FMI 2.0 or 3.0, or of our own."""
    if status in OUR_OWN:
        return OUR_OWN[status]
    return STATUS[status] if 0 <= status < len(STATUS) else f"the unknown status {status}"


class RunLog:
    """Writes ``log.txt`` once there is something to write; counts warnings and worse."""

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.warnings = 0
        self._last: dict[str, tuple[int, str]] = {}
        self._file: IO[str] | None = None
        if path is not None:
            path.unlink(missing_ok=True)

    def add(self, instance: str, status: int, category: str, message: str) -> None:
        """Take a message of an instance."""
        message = message.strip()
        if status > OK:
            self.warnings += 1
            # what made the FMU give up says more than that it gave up
            if status != FATAL or self._last.get(instance, (OK, ""))[0] != ERROR:
                self._last[instance] = (status, message.partition("\n")[0])
        if self.path is not None:
            if self._file is None:
                self._file = self.path.open("w", encoding="utf-8")
            self._file.write(f"{instance}: {status_name(status)} [{category}] {message}\n")
            self._file.flush()

    def last(self, instance: str) -> str:
        """The last warning or error of an instance; empty if it had none."""
        return self._last.get(instance, (OK, ""))[1]

    def close(self) -> None:
        """Close the file."""
        if self._file is not None:
            self._file.close()
