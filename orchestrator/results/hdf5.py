"""Opens HDF5 files that may be damaged, or come from anywhere."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py

from ..schedule.plan import Array

DENSITY = 1000  # bytes of values that a byte of a file may hold, however compressed
SMALL = 1 << 20  # bytes


@contextmanager
def opened(path: Path) -> Iterator[Any]:
    """A file to read from. Raises OSError, with a text of one line, for whatever is wrong."""
    try:
        with h5py.File(path, "r") as file:
            yield file
    except Exception as error:  # for damage h5py raises nearly any kind
        text = " ".join(str(error).split())
        if isinstance(error, OSError) and text == str(error):
            raise
        raise OSError(text or type(error).__name__) from None


def numbers(data: Any) -> Array:
    """All values of a dataset of numbers.

    Raises ValueError if it is none, or claims more values than the file can hold.
    """
    if not isinstance(data, h5py.Dataset) or data.dtype.kind not in "fiub":
        raise ValueError(f"{data.name} does not hold numbers")
    if data.nbytes > SMALL + DENSITY * Path(data.file.filename).stat().st_size:
        raise ValueError(f"{data.name} claims to hold more than the file can")
    found: Array = data[()]
    return found
