"""Unpacked FMUs, kept by content: a file that was unpacked before is not unpacked again.

A folder appears complete or not at all: it is unpacked under another name, then renamed. Before it
is used again its files are compared with the archive.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
import zipfile
import zlib
from pathlib import Path

import platformdirs

from ..errors import NO_ROOM, FmuError

PART = 1 << 20  # bytes read at once


def root() -> Path:
    """Where unpacked FMUs are kept: within SIGHTLINE_CACHE, or the user's cache folder."""
    cache = os.environ.get("SIGHTLINE_CACHE") or platformdirs.user_cache_dir("sightline")
    return Path(cache).absolute() / "unpacked"


def unpacked(path: Path) -> Path:
    """The folder with an FMU's files. Raises FmuError if the archive is damaged, or has no room."""
    try:
        folder = root() / digest(path)[:32]
        with zipfile.ZipFile(path) as archive:
            if not _intact(folder, archive):
                _unpack(archive, folder)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, ValueError) as error:
        if isinstance(error, OSError) and _of_cache(error):
            what = f"cannot be unpacked to {root()}: {error.strerror}"
            raise FmuError(str(path), what, "SIGHTLINE_CACHE names another folder") from None
        raise FmuError(str(path), f"is a damaged archive: {error}") from None
    return folder


def _of_cache(error: OSError) -> bool:
    """Whether it is the folder of unpacked FMUs, or one above it, that cannot be written to."""
    place = Path(error.filename or os.devnull)
    return error.errno in NO_ROOM or place.is_relative_to(root()) or root().is_relative_to(place)


def digest(path: Path) -> str:
    """The SHA-256 of a file. Raises OSError."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _intact(folder: Path, archive: zipfile.ZipFile) -> bool:
    return folder.is_dir() and all(
        _same(folder / member.filename, member)
        for member in archive.infolist()
        if not member.is_dir()
    )


def _same(path: Path, member: zipfile.ZipInfo) -> bool:
    if not path.is_file() or path.stat().st_size != member.file_size:
        return False
    sum_ = 0
    with path.open("rb") as file:
        while part := file.read(PART):
            sum_ = zlib.crc32(part, sum_)
    return sum_ == member.CRC


def _unpack(archive: zipfile.ZipFile, folder: Path) -> None:
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, ignore_cleanup_errors=True) as name:
        fresh = Path(name) / "fresh"
        for member in archive.infolist():
            inside = (fresh / member.filename).resolve()
            if not inside.is_relative_to(fresh.resolve()):
                raise ValueError(f"{member.filename} leads out of it")
        archive.extractall(fresh)
        if folder.exists():  # damaged: put it aside, others may have its files open
            folder.rename(Path(name) / "old")
        try:
            fresh.rename(folder)
        except OSError:  # another process was quicker
            if not _intact(folder, archive):
                raise
            shutil.rmtree(fresh)
