"""What passes between a run and the process of an isolated FMU.

Requests and answers go through two pipes, values through shared memory. A pipe wakes who waits for
it, and tells at once that the other side has died. A request is a code with a time and a width, an
answer a status; where a frame follows, it is a length and as many bytes of pickle.

Inputs are set without waiting for the answer. Each request tells how many refusals the run knows
of; after one that it does not know of yet, nothing is done but answered with an error.
"""

from __future__ import annotations

import mmap
import os
import pickle
import tempfile
from collections.abc import Callable
from struct import Struct
from typing import Any

import numpy as np

from ..schedule.plan import Array

REQUEST = Struct("<iidd")
ANSWER = Struct("<i")
LENGTH = Struct("<q")
CALL, STEP, TRANSFERS = 0, 1, 2  # requests: a frame follows; step; the first of the transfers
MESSAGE, RESULT, REFUSAL = -1, -2, -3  # answers that a frame follows
DOUBLE = 8  # bytes

Read = Callable[[int], bytes]  # exactly so many bytes


def framed(code: bytes, content: object) -> bytes:
    """A request or an answer with its frame."""
    data = pickle.dumps(content)
    return code + LENGTH.pack(len(data)) + data


def unframed(read: Read) -> Any:
    """The content of a frame."""
    return pickle.loads(read(LENGTH.unpack(read(LENGTH.size))[0]))


def write(file: int, data: bytes) -> None:
    """Write all of it. Raises BrokenPipeError if nobody reads."""
    while data:
        data = data[os.write(file, data):]


def memory(count: int) -> int:
    """A file for so many values that has no name: whatever dies, nothing of it stays."""
    if hasattr(os, "memfd_create"):
        file = os.memfd_create("sightline")
    else:
        with tempfile.TemporaryFile() as unnamed:
            file = os.dup(unnamed.fileno())
    os.ftruncate(file, count * DOUBLE)
    return file


def mapped(file: int) -> Array:
    """The values in shared memory."""
    return np.frombuffer(mmap.mmap(file, 0), dtype=np.float64)
