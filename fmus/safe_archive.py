"""An .fmu file as a container that may be hostile: looked at, then unpacked, without running it.

Every file that the project opens goes through here, before anything in it is executed. What is
refused, by the name of the problem: names that leave the folder, links, members that are
encrypted, damaged, repeated or both file and folder, archives that grow beyond all measure, XML
with a document type (entities), of another encoding or nested without end, identifiers that are
paths, binaries that are not of the platform whose folder they lie in, and a description that asks
for what the binary does not offer.

A leaf: the standard library only, so that verification and the orchestrator can share it.
"""

from __future__ import annotations

import stat
import unicodedata
import zipfile
import zlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path, PurePosixPath
from typing import IO

from .safe_binary import binary_problems
from .safe_xml import read_head, xml_problem

DESCRIPTION = "modelDescription.xml"
XML_FILES = (DESCRIPTION, "sources/buildDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml")
METHODS = {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}  # all that FMI allows
CHUNK = 1 << 20  # bytes


@dataclass(frozen=True)
class Limits:
    """What an archive may hold at most."""

    members: int = 20_000
    member_bytes: int = 1 << 30
    total_bytes: int = 4 << 30
    ratio: float = 400.0  # unpacked to packed, of members over a megabyte
    name_bytes: int = 1024
    part_bytes: int = 255  # of a file or folder's own name, as file systems have it
    xml_bytes: int = 64 << 20


@dataclass(frozen=True)
class ArchiveProblem:
    """One reason to refuse an archive: its kind in a word, the member, and what was found."""

    kind: str
    member: str
    detail: str

    def __str__(self) -> str:
        return f"{self.member}: {self.detail}" if self.member else self.detail


class UnsafeArchiveError(Exception):
    """An archive is refused; ``problems`` says everything that is wrong with it."""

    def __init__(self, file: Path, problems: Iterable[ArchiveProblem]) -> None:
        self.file, self.problems = file, tuple(problems)
        super().__init__(str(file), *self.problems)

    def __str__(self) -> str:
        return f"{self.file}: " + "; ".join(map(str, self.problems))


def inspect(path: Path, limits: Limits = Limits()) -> list[ArchiveProblem]:
    """Everything that is wrong with the archive; nothing is unpacked to disk or executed."""
    try:
        with zipfile.ZipFile(path) as archive:
            found = list(_container(archive, limits))
            return found or list(_contents(archive, limits))
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, ValueError) as error:
        return [ArchiveProblem("damaged", "", f"is not an FMU or is damaged: {error}")]
    except OSError as error:
        return [ArchiveProblem("unreadable", "", f"cannot be read: {error.strerror or error}")]


def extract(path: Path, folder: Path, limits: Limits = Limits()) -> None:
    """Unpack an archive that has nothing wrong.

    Raises UnsafeArchiveError: with nothing written if it is refused, with a part of it if the
    folder cannot take it all.
    """
    if problems := inspect(path, limits):
        raise UnsafeArchiveError(path, problems)
    try:
        _unpack(path, folder)
    except OSError as error:
        detail = f"cannot be unpacked to {folder}: {error.strerror or error}"
        raise UnsafeArchiveError(path, [ArchiveProblem("not unpacked", "", detail)]) from None


def _unpack(path: Path, folder: Path) -> None:
    root = folder.resolve()
    with zipfile.ZipFile(path) as archive:
        for info in archive.infolist():
            target = root.joinpath(*PurePosixPath(info.filename).parts)
            if info.is_dir():
                target.mkdir(parents=True, exist_ok=True)
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            with archive.open(info) as source, target.open("wb") as out:
                for chunk in _chunks(source):
                    out.write(chunk)


def _container(archive: zipfile.ZipFile, limits: Limits) -> Iterator[ArchiveProblem]:
    """Problems that show in the archive's directory."""
    members = archive.infolist()
    if len(members) > limits.members:
        yield ArchiveProblem("bomb", "", f"has {len(members)} members, at most {limits.members}")
        return
    total = sum(m.file_size for m in members)
    if total > limits.total_bytes:
        detail = f"unpacks to {total:,} bytes, at most {limits.total_bytes:,}"
        yield ArchiveProblem("bomb", "", detail)
    end, last = 0, ""
    for info in sorted(members, key=lambda m: m.header_offset):
        if info.header_offset < end:
            yield ArchiveProblem("bomb", info.filename, f"overlaps {last} in the archive")
        end, last = info.header_offset + 30 + info.compress_size, info.filename
    for info in members:
        yield from _member(info, limits)
    yield from _clashes(info.orig_filename for info in members)
    if DESCRIPTION not in archive.namelist():
        yield ArchiveProblem("no description", "", f"is not an FMU: it has no {DESCRIPTION}")


def _clashes(names: Iterable[str]) -> Iterator[ArchiveProblem]:
    """Names that are one on some platform, and files that are folders of other members, too."""
    # in this order what lies in a folder comes right after it
    ordered = sorted((place, name) for name in names if (place := _place(name)))
    for (above, first), (place, second) in pairwise(ordered):
        if place[: len(above)] != above:
            continue
        file = not first.endswith("/")
        if place == above and file is not second.endswith("/"):
            yield ArchiveProblem("repeated", second[:80], f"the same file as {first[:80]}")
        elif place == above or file:
            detail = f"is a file and a folder: {second[:80]}"
            yield ArchiveProblem("file and folder", first[:80], detail)


def _place(name: str) -> tuple[str, ...]:
    """Parts of a path, the same for names that Windows or macOS takes for the same."""
    folded = unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())
    parts = (part.partition(":")[0].rstrip(" .") for part in folded.split("/"))
    return tuple(part for part in parts if part)


def _member(info: zipfile.ZipInfo, limits: Limits) -> Iterator[ArchiveProblem]:
    name = info.orig_filename
    if problem := _name_problem(name, limits):
        yield ArchiveProblem("path", name[:80], problem)
    mode = info.external_attr >> 16
    if stat.S_IFMT(mode) not in (0, stat.S_IFREG, stat.S_IFDIR):
        kind = "a link" if stat.S_ISLNK(mode) else "not a regular file"
        yield ArchiveProblem("link", name, f"is {kind}")
    if info.flag_bits & 0x1:
        yield ArchiveProblem("encrypted", name, "is encrypted")
    if info.compress_type not in METHODS:
        detail = f"is packed by method {info.compress_type}; FMI allows stored and deflated"
        yield ArchiveProblem("packing", name, detail)
    if info.file_size > limits.member_bytes:
        detail = f"unpacks to {info.file_size:,} bytes, at most {limits.member_bytes:,}"
        yield ArchiveProblem("bomb", name, detail)
    elif info.file_size > CHUNK and info.file_size > limits.ratio * max(info.compress_size, 1):
        detail = f"unpacks to {info.file_size // max(info.compress_size, 1)} times its size"
        yield ArchiveProblem("bomb", name, f"{detail}, at most {limits.ratio:g}")


def _name_problem(name: str, limits: Limits) -> str:
    size = len(name.encode())
    if not 0 < size <= limits.name_bytes:
        return f"its name has {size} bytes, 1 to {limits.name_bytes} are allowed"
    if any(ord(c) < 32 or ord(c) == 127 for c in name):
        return "its name has control characters"
    if "\\" in name:
        return "its name has a backslash; FMI asks for forward slashes"
    if name.startswith("/") or (len(name) > 1 and name[1] == ":"):
        return "its name is absolute"
    parts = name.removesuffix("/").split("/")
    if ".." in parts:
        return "its name leads out of the folder"
    if "" in parts or "." in parts:
        return "its name has an empty part or '.', so that it may stand for another member"
    if (longest := max(len(part.encode()) for part in parts)) > limits.part_bytes:
        return f"a part of its name has {longest} bytes, at most {limits.part_bytes}"
    return ""


def _contents(archive: zipfile.ZipFile, limits: Limits) -> Iterator[ArchiveProblem]:
    """Problems that show when members are unpacked in memory, one after the other."""
    files = [i for i in archive.infolist() if not i.is_dir()]
    binaries = {}
    for info in files:
        wanted = info.filename in XML_FILES
        if wanted and info.file_size > limits.xml_bytes:
            detail = f"is {info.file_size:,} bytes, at most {limits.xml_bytes:,}"
            yield ArchiveProblem("xml size", info.filename, detail)
            continue
        is_binary = info.filename.startswith("binaries/")
        try:
            content = _read(archive, info, keep=wanted or is_binary)
        except (zipfile.BadZipFile, zlib.error, EOFError, RuntimeError) as error:
            yield ArchiveProblem("damaged", info.filename, f"is damaged: {error}")
            continue
        if wanted and (problem := xml_problem(content)):
            yield ArchiveProblem("xml", info.filename, problem)
        if is_binary:
            binaries[info.filename] = content
    description = archive.read(DESCRIPTION)
    if not xml_problem(description):
        for member, detail in binary_problems(read_head(description), binaries):
            yield ArchiveProblem("binary", member, detail)


def _read(archive: zipfile.ZipFile, info: zipfile.ZipInfo, keep: bool) -> bytes:
    """Unpack one member to its end, which checks it. Raises if it is longer than it says."""
    parts, size = [], 0
    with archive.open(info) as source:
        for chunk in _chunks(source):
            size += len(chunk)
            if size > info.file_size:
                raise zipfile.BadZipFile(f"longer than the {info.file_size} bytes it declares")
            if keep:
                parts.append(chunk)
    return b"".join(parts)


def _chunks(source: IO[bytes]) -> Iterator[bytes]:
    while chunk := source.read(CHUNK):
        yield chunk
