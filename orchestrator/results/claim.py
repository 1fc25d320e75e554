"""One run at a time writes into a folder."""

from __future__ import annotations

import errno
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def claimed(folder: Path) -> Iterator[None]:
    """The folder to oneself. Raises OSError while another run has it."""
    if sys.platform == "win32":  # an open results file cannot be replaced there
        yield
        return
    import fcntl

    handle = os.open(folder, os.O_RDONLY)
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BlockingIOError(errno.EAGAIN, "another run is writing there") from None
        except OSError:
            pass  # a file system without locks
        yield
    finally:
        os.close(handle)
