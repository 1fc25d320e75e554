"""Hostile archives are refused, by the name of the problem, before anything in them is executed."""

from __future__ import annotations

import io
import random
import stat
import struct
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from sightline.fmus.safe_archive import Limits, UnsafeArchiveError, extract, inspect
from sightline.fmus.safe_binary import what_is

DESCRIPTION = b'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="2.0" ' \
    b'modelName="m"><CoSimulation modelIdentifier="m"/></fmiModelDescription>\n'
ELF = b"\x7fELF\2\1\1" + bytes(9) + struct.pack("<HH", 3, 0x3E) + bytes(40)
DLL = b"MZ" + bytes(58) + struct.pack("<I", 64) + b"PE\0\0" + struct.pack("<H", 0x8664)
MACH = b"\xcf\xfa\xed\xfe" + struct.pack("<I", 0x0100000C) + bytes(24)
SOUND = ELF + b"\0fmi2DoStep\0"
Write = Callable[..., Path]


@pytest.fixture
def write(tmp_path: Path) -> Write:
    """Write an archive of members: name (or ZipInfo) -> content."""

    def written(*members: tuple[str | zipfile.ZipInfo, bytes],
                description: bytes | None = DESCRIPTION) -> Path:
        path = tmp_path / "a.fmu"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            if description is not None:
                archive.writestr("modelDescription.xml", description)
            for name, content in members:
                archive.writestr(name, content)
        return path

    return written


def kinds(path: Path, limits: Limits | None = None) -> set[str]:
    return {p.kind for p in inspect(path, limits or Limits())}


def named(name: str) -> zipfile.ZipInfo:
    """A member whose name zipfile has not tidied."""
    info = zipfile.ZipInfo("x")
    info.filename = info.orig_filename = name
    return info


def linked(mode: int) -> zipfile.ZipInfo:
    info = zipfile.ZipInfo("resources/link")
    info.create_system = 3
    info.external_attr = (mode | 0o777) << 16
    return info


def test_an_ordinary_archive_is_unpacked(write: Write, tmp_path: Path) -> None:
    path = write(("binaries/linux64/m.so", SOUND), ("resources/", b""), ("resources/a", b"data"))
    assert inspect(path) == []
    extract(path, tmp_path / "out")
    assert (tmp_path / "out/resources/a").read_bytes() == b"data"
    assert (tmp_path / "out/binaries/linux64/m.so").read_bytes() == SOUND


@pytest.mark.parametrize(
    ("name", "detail"),
    [
        ("../evil", "leads out of the folder"),
        ("resources/../../evil", "leads out of the folder"),
        ("/etc/evil", "is absolute"),
        ("C:/evil", "is absolute"),
        ("..\\evil", "has a backslash"),
        ("resources/a\nb", "has control characters"),
        ("r/" * 600 + "x", "has 1201 bytes, 1 to 1024 are allowed"),
        ("€" * 400, "has 1200 bytes, 1 to 1024 are allowed"),
        ("", "has 0 bytes, 1 to 1024 are allowed"),
        ("resources/" + "a" * 256, "a part of its name has 256 bytes, at most 255"),
        ("resources/" + "€" * 86, "a part of its name has 258 bytes, at most 255"),
        (".", "has an empty part or '.'"),
        ("resources/.", "has an empty part or '.'"),
        ("./modelDescription.xml", "has an empty part or '.'"),
        ("binaries//linux64/m.so", "has an empty part or '.'"),
        ("binaries/./linux64/m.so", "has an empty part or '.'"),
        ("resources//", "has an empty part or '.'"),
    ],
)
def test_names_that_are_no_plain_path_in_the_folder_are_refused(
    name: str, detail: str, write: Write, tmp_path: Path
) -> None:
    path = write((named(name), b"evil"))
    assert detail in str(inspect(path)[0])
    with pytest.raises(UnsafeArchiveError, match=detail):
        extract(path, tmp_path / "out")
    assert not (tmp_path / "out").exists()
    assert [p.name for p in tmp_path.iterdir()] == ["a.fmu"]


@pytest.mark.parametrize("mode", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR, stat.S_IFSOCK])
def test_links_and_devices_are_refused(mode: int, write: Write) -> None:
    assert kinds(write((linked(mode), b"/etc/passwd"))) == {"link"}


def test_a_member_that_unpacks_to_a_multiple_is_refused(write: Write) -> None:
    assert kinds(write(("resources/zeros", bytes(20 << 20)))) == {"bomb"}


def test_sizes_and_counts_beyond_the_limits_are_refused(write: Write) -> None:
    path = write(*[(f"resources/{i}", random.Random(i).randbytes(2000)) for i in range(30)])
    assert kinds(path) == set()
    assert kinds(path, Limits(members=20)) == {"bomb"}
    assert kinds(path, Limits(member_bytes=1000)) == {"bomb"}
    assert kinds(path, Limits(total_bytes=50_000)) == {"bomb"}


def test_members_that_overlap_are_refused(write: Write) -> None:
    data = bytearray(write(("resources/a", b"a" * 99), ("resources/b", b"a" * 99)).read_bytes())
    first, second = _directory_entries(data)[1:]
    data[second + 42 : second + 46] = data[first + 42 : first + 46]
    data[second + 46 : second + 57] = data[first + 46 : first + 57]
    path = write()
    path.write_bytes(data)
    assert "bomb" in kinds(path) or "damaged" in kinds(path)


def test_a_member_longer_than_it_says_is_refused(write: Write) -> None:
    content = random.Random(1).randbytes(1000)
    data = bytearray(write(("resources/a", content)).read_bytes())
    entry = _directory_entries(data)[1]
    data[entry + 24 : entry + 28] = struct.pack("<I", 500)
    path = write()
    path.write_bytes(data)
    assert kinds(path) == {"damaged"}


def _directory_entries(data: bytes) -> list[int]:
    found, at = [], data.find(b"PK\1\2")
    while at >= 0:
        found.append(at)
        at = data.find(b"PK\1\2", at + 1)
    return found


def test_encrypted_members_are_refused(write: Write) -> None:
    data = bytearray(write(("resources/a", b"secret")).read_bytes())
    entry = _directory_entries(data)[1]
    data[entry + 8] |= 1
    path = write()
    path.write_bytes(data)
    assert kinds(path) == {"encrypted"}


def test_packing_that_fmi_does_not_allow_is_refused(write: Write) -> None:
    path = write()
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("resources/a", b"text" * 99, zipfile.ZIP_LZMA)
    assert kinds(path) == {"packing"}


@pytest.mark.parametrize("other", ["A", "a.", "a ", "a::$DATA", "a\u0301", "\u00e1"])
def test_names_that_are_one_file_on_some_platforms_are_refused(other: str, write: Write) -> None:
    first = "resources/\u00c1" if other[-1] in "\u0301\u00e1" else "resources/a"
    problems = inspect(write((first, b""), (f"resources/{other}", b"")))
    assert [p.kind for p in problems] == ["repeated"]
    assert "the same file as resources/" in str(problems[0])


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (("resources", "resources/a"), "resources: is a file and a folder: resources/a"),
        (("resources/a", "resources"), "resources: is a file and a folder: resources/a"),
        (("Resources", "resources/a"), "Resources: is a file and a folder: resources/a"),
        (("resources/a/", "resources/a"), "resources/a: is a file and a folder: resources/a/"),
        (("modelDescription.xml/a",),
         "modelDescription.xml: is a file and a folder: modelDescription.xml/a"),
    ],
)
def test_names_of_both_a_file_and_a_folder_are_refused(
    names: tuple[str, ...], found: str, write: Write
) -> None:
    assert [str(p) for p in inspect(write(*((n, b"") for n in names)))] == [found]


def test_folders_may_stand_before_after_and_without_their_files(write: Write) -> None:
    names = ("a/", "a/b/c", "a/b/", "a-b", "a.b/c", "ab", "b/c/d", "b/c.d")
    assert inspect(write(*((n, b"") for n in names))) == []


def test_a_folder_that_cannot_take_the_files_is_named(write: Write, tmp_path: Path) -> None:
    (tmp_path / "out").write_bytes(b"")
    with pytest.raises(UnsafeArchiveError, match=r"a\.fmu: cannot be unpacked to .*out: ") as found:
        extract(write(), tmp_path / "out")
    assert [p.kind for p in found.value.problems] == ["not unpacked"]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is full: Linux only")
def test_a_full_disk_is_said_to_be_full(write: Write, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    (tmp_path / "out/modelDescription.xml").symlink_to("/dev/full")
    with pytest.raises(UnsafeArchiveError, match=r"cannot be unpacked to .*: No space left on"):
        extract(write(), tmp_path / "out")


def test_an_archive_without_description_is_refused(write: Write) -> None:
    assert kinds(write(("readme", b""), description=None)) == {"no description"}


def test_truncated_archives_are_refused_wherever_they_end(write: Write, tmp_path: Path) -> None:
    data = write(("binaries/linux64/m.so", SOUND), ("resources/a", b"data" * 50)).read_bytes()
    for length in range(len(data)):
        (tmp_path / "cut.fmu").write_bytes(data[:length])
        assert kinds(tmp_path / "cut.fmu") <= {"damaged"}
        assert kinds(tmp_path / "cut.fmu")


def test_no_flipped_bytes_raise_anything_but_a_refusal(write: Write, tmp_path: Path) -> None:
    data = write(("binaries/linux64/m.so", SOUND), ("resources/a", b"data" * 50)).read_bytes()
    rng = random.Random(6)
    for _ in range(1500):
        spoilt = bytearray(data)
        for _ in range(rng.randint(1, 8)):
            spoilt[rng.randrange(len(spoilt))] = rng.randrange(256)
        (tmp_path / "spoilt.fmu").write_bytes(spoilt)
        inspect(tmp_path / "spoilt.fmu")


ENTITIES = b'<?xml version="1.0"?><!DOCTYPE m [<!ENTITY a "ha"><!ENTITY b "&a;&a;&a;&a;">]>' \
    b'<m fmiVersion="2.0">&b;</m>'
EXTERNAL = b'<?xml version="1.0"?><!DOCTYPE m [<!ENTITY a SYSTEM "file:///etc/passwd">]><m>&a;</m>'


@pytest.mark.parametrize(
    ("description", "detail"),
    [
        (ENTITIES, "has a document type"),
        (EXTERNAL, "has a document type"),
        (b"<!DOCTYPE m SYSTEM 'http://localhost/x.dtd'><m/>", "has a document type"),
        (DESCRIPTION.decode().replace("UTF-8", "UTF-16").encode("utf-16"), "is in UTF-16"),
        (DESCRIPTION.replace(b"UTF-8", b"ISO-8859-1"), "declares the encoding ISO-8859-1"),
        (DESCRIPTION.replace(b'"m"', b'"\xff"'), "is not UTF-8 at byte"),
        (b"<a>" * 100_000 + b"</a>" * 100_000, "is nested deeper than 64 elements"),
        (b"<m", "is not XML"),
        (b"", "is not XML"),
        (DESCRIPTION + b"<more/>", "is not XML"),
    ],
)
def test_xml_that_does_harm_is_refused(description: bytes, detail: str, write: Write) -> None:
    problems = inspect(write(description=description))
    assert [p.kind for p in problems] == ["xml"]
    assert detail in problems[0].detail


IDENTIFIER = b'modelIdentifier="m"'


@pytest.mark.parametrize(
    ("attribute", "detail"),
    [
        ('modelIdentifier="/tmp/evil"', "of CoSimulation is a path, '/tmp/evil'; FMI asks for"),
        ('modelIdentifier="../../evil"', "is a path, '../../evil'; FMI asks for letters, digits"),
        ('modelIdentifier="..\\evil"', "is a path"),
        ('modelIdentifier="C:evil"', "is a path"),
        ('modelIdentifier="&#47;evil"', "is a path, '/evil'"),
        ('modelIdentifier="a&#10;b"', "is a path"),
        ('modelIdentifier="."', "is a path"),
        ('modelIdentifier=".."', "is a path"),
        ('modelIdentifier=""', "the modelIdentifier of CoSimulation is empty"),
        (f'modelIdentifier="{"m" * 201}"', "has more than 200 bytes"),
        ("", "CoSimulation has no modelIdentifier"),
        ('modelIdentifier="/evil"/><CoSimulation modelIdentifier="m"', "is a path, '/evil'"),
        ('modelIdentifier="/evil"/><CoSimulation xmlns="n" modelIdentifier="m"', "is a path"),
        ('modelIdentifier="m"/><ModelExchange modelIdentifier="/evil"', "of ModelExchange is a"),
    ],
)
def test_identifiers_that_name_a_file_elsewhere_are_refused(
    attribute: str, detail: str, write: Write
) -> None:
    problems = inspect(write(description=DESCRIPTION.replace(IDENTIFIER, attribute.encode())))
    assert [p.kind for p in problems] == ["xml"]
    assert detail in problems[0].detail


@pytest.mark.parametrize("identifier", ["a-b", "a.b", "a b", "1a", "ä", "..a"])
def test_identifiers_that_are_plain_names_are_allowed(identifier: str, write: Write) -> None:
    attribute = f'modelIdentifier="{identifier}"'.encode()
    assert inspect(write(description=DESCRIPTION.replace(IDENTIFIER, attribute))) == []


def test_an_element_of_another_namespace_hides_no_binary(write: Write) -> None:
    more = IDENTIFIER + b'/><CoSimulation xmlns="n" modelIdentifier="other"'
    problems = inspect(write(("binaries/linux64/m.so", b"#!/bin/sh\n"),
                             description=DESCRIPTION.replace(IDENTIFIER, more)))
    assert [p.detail for p in problems] == ["is not a shared library"]


def test_the_word_doctype_in_a_text_is_allowed(write: Write) -> None:
    harmless = DESCRIPTION.replace(b'"m"', b'"&lt;!DOCTYPE"', 1)
    assert inspect(write(description=harmless)) == []


def test_xml_of_the_build_description_is_looked_at_too(write: Write) -> None:
    assert kinds(write(("sources/buildDescription.xml", ENTITIES))) == {"xml"}


@pytest.mark.parametrize(
    ("member", "content", "detail"),
    [
        ("binaries/linux64/m.so", DLL, "for another platform: PE, in a folder for ELF"),
        ("binaries/win64/m.dll", SOUND, "for another platform: ELF, in a folder for PE"),
        ("binaries/linux32/m.so", SOUND, "for another platform: x86_64, in a folder for x86"),
        ("binaries/darwin64/m.dylib", MACH, "for another platform: aarch64"),
        ("binaries/linux64/m.so", b"#!/bin/sh\nrm -rf /\n", "is not a shared library"),
        ("binaries/linux64/m.so", ELF + b"\0fmi3InstantiateCoSimulation\0",
         "disagrees with the description: the description says FMI 2.0 CoSimulation"),
    ],
)
def test_binaries_that_are_not_what_they_seem_are_refused(
    member: str, content: bytes, detail: str, write: Write
) -> None:
    problems = inspect(write((member, content)))
    assert [p.kind for p in problems] == ["binary"]
    assert detail in str(problems[0])


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (ELF, ("ELF", {"x86_64"})), (DLL, ("PE", {"x86_64"})), (MACH, ("Mach-O", {"aarch64"})),
        (b"\xca\xfe\xba\xbe" + struct.pack(">I", 1) + struct.pack(">I", 0x01000007) + bytes(16),
         ("Mach-O", {"x86_64"})),
        (b"", ("", set())), (b"\x7fELF", ("", set())), (b"MZ", ("", set())),
    ],
)  # fmt: skip
def test_binaries_are_told_apart_by_their_bytes(
    content: bytes, found: tuple[str, set[str]]
) -> None:
    assert what_is(content) == found


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    assert kinds(tmp_path) == {"unreadable"}
    assert kinds(tmp_path / "none.fmu") == {"unreadable"}
    (tmp_path / "empty.fmu").write_bytes(b"")
    assert kinds(tmp_path / "empty.fmu") == {"damaged"}


def test_an_archive_of_random_bytes_is_refused(tmp_path: Path) -> None:
    stream = io.BytesIO(random.Random(0).randbytes(5000))
    (tmp_path / "noise.fmu").write_bytes(stream.getvalue())
    assert kinds(tmp_path / "noise.fmu") == {"damaged"}
