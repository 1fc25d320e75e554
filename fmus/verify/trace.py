"""What an FMU is doing: the present trial and call, in a file that outlives its process."""

from __future__ import annotations

import mmap
from pathlib import Path

BYTES = 256  # of each


class Trace:
    """Writes to the file, which is mapped to memory."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(bytes(2 * BYTES))
        with path.open("r+b") as file:
            self._memory = mmap.mmap(file.fileno(), 2 * BYTES)

    def trial(self, name: str) -> None:
        """One of several trials of a check begins."""
        self._memory[:BYTES] = _padded(name)

    def call(self, name: str) -> None:
        """A call begins."""
        self._memory[BYTES:] = _padded(name)


def last(path: Path) -> tuple[str, str]:
    """The last trial and the last call; empty if there was none."""
    data = path.read_bytes() if path.exists() else b""
    trial, call = (half.partition(b"\0")[0].decode(errors="ignore")
                   for half in (data[:BYTES], data[BYTES:]))
    return trial, call


def _padded(name: str) -> bytes:
    return name.encode()[:BYTES].ljust(BYTES, b"\0")
