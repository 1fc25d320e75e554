"""Room on the disk, taken before it is written to.

Where a write of HDF5 fails, all that the file held before is lost too. So a file grows only into
room that the file system has granted.
"""

from __future__ import annotations

import errno
import os
import shutil
from pathlib import Path

SLACK = 1 << 15  # bytes for what a file holds besides values
NODE = 1 << 12  # bytes that describe a dataset, a group or a new chunk


def take(path: Path, first: int, count: int) -> None:
    """Have room for so many bytes from a place on in a file. Raises OSError if there is none."""
    if not hasattr(os, "posix_fallocate"):
        if shutil.disk_usage(path.parent).free < count:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        return
    with path.open("ab") as file:
        try:
            os.posix_fallocate(file.fileno(), first, count)
        except OSError as error:
            if error.errno not in (errno.EOPNOTSUPP, errno.EINVAL):  # that it cannot tell
                raise OSError(error.errno, error.strerror, str(path)) from None
