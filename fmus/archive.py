"""FMU archives that come out the same byte for byte: sorted members, fixed dates and modes."""

from __future__ import annotations

import os
import tempfile
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import IO

EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest date that a zip archive can hold


def write_archive(path: Path, members: Mapping[str, bytes]) -> None:
    """Write an archive, whole or not at all. Raises OSError as :func:`complete` does."""
    with complete(path) as stream, zipfile.ZipFile(stream, "w") as archive:
        for name in sorted(members, key=lambda n: (n != "modelDescription.xml", n)):
            info = zipfile.ZipInfo(name, EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3
            info.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(info, members[name])


@contextmanager
def complete(path: Path) -> Iterator[IO[bytes]]:
    """A stream to write a file with, which appears when all is written; its folder is made.

    Raises OSError that names the folder.
    """
    temporary = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".part")
        with os.fdopen(handle, "wb") as stream:
            yield stream
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException as error:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
        if isinstance(error, OSError):
            raise OSError(error.errno, error.strerror, str(path.parent)) from None
        raise
