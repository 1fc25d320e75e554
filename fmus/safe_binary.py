"""Binaries of an archive, told apart by their bytes: what each is, and what it offers by name."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping

from .safe_xml import Head

EXTENSIONS = {"ELF": ".so", "PE": ".dll", "Mach-O": ".dylib"}
FOLDERS = {  # of FMI 2.0 and FMI 3.0 -> format and machine
    "linux64": ("ELF", "x86_64"), "linux32": ("ELF", "x86"),
    "win64": ("PE", "x86_64"), "win32": ("PE", "x86"), "darwin64": ("Mach-O", "x86_64"),
    "x86_64-linux": ("ELF", "x86_64"), "x86-linux": ("ELF", "x86"),
    "aarch64-linux": ("ELF", "aarch64"), "x86_64-windows": ("PE", "x86_64"),
    "x86-windows": ("PE", "x86"), "aarch64-windows": ("PE", "aarch64"),
    "x86_64-darwin": ("Mach-O", "x86_64"), "aarch64-darwin": ("Mach-O", "aarch64"),
}  # fmt: skip
ELF_MACHINES = {0x3E: "x86_64", 0x03: "x86", 0xB7: "aarch64", 0x28: "arm", 0xF3: "riscv"}
PE_MACHINES = {0x8664: "x86_64", 0x14C: "x86", 0xAA64: "aarch64"}
MACH_MACHINES = {0x01000007: "x86_64", 0x07: "x86", 0x0100000C: "aarch64"}
ESSENTIAL = {  # the function that an interface cannot do without
    ("2", "CoSimulation"): "fmi2DoStep", ("2", "ModelExchange"): "fmi2GetDerivatives",
    ("3", "CoSimulation"): "fmi3InstantiateCoSimulation",
    ("3", "ModelExchange"): "fmi3InstantiateModelExchange",
    ("3", "ScheduledExecution"): "fmi3InstantiateScheduledExecution",
}  # fmt: skip


def what_is(content: bytes) -> tuple[str, frozenset[str]]:
    """Format (ELF, PE, Mach-O or empty) and machines of a binary, from its header."""
    if content[:4] == b"\x7fELF" and len(content) >= 20:
        order = ">" if content[5] == 2 else "<"
        return "ELF", _named(ELF_MACHINES, struct.unpack_from(order + "H", content, 18)[0])
    if content[:2] == b"MZ" and len(content) >= 64:
        at = struct.unpack_from("<I", content, 60)[0]
        if content[at : at + 4] == b"PE\0\0" and len(content) >= at + 6:
            return "PE", _named(PE_MACHINES, struct.unpack_from("<H", content, at + 4)[0])
    if content[:4] in (b"\xcf\xfa\xed\xfe", b"\xce\xfa\xed\xfe") and len(content) >= 8:
        return "Mach-O", _named(MACH_MACHINES, struct.unpack_from("<I", content, 4)[0])
    if content[:4] == b"\xca\xfe\xba\xbe" and len(content) >= 8:
        count = min(struct.unpack_from(">I", content, 4)[0], 8)
        kinds = [struct.unpack_from(">I", content, 8 + 20 * i)[0] for i in range(count)
                 if len(content) >= 12 + 20 * i]
        return "Mach-O", frozenset().union(*(_named(MACH_MACHINES, k) for k in kinds))
    return "", frozenset()


def offered(content: bytes, version: str) -> set[str]:
    """Names of FMI functions that stand in a binary's string tables."""
    prefix = b"fmi" + version[:1].encode()
    names = re.findall(rb"(?<![A-Za-z0-9])_?(" + prefix + rb"[A-Z][A-Za-z0-9]*)\0", content)
    return {n.decode() for n in names}


def binary_problems(head: Head, binaries: Mapping[str, bytes]) -> Iterator[tuple[str, str]]:
    """Member and problem, for binaries that are not what folder and description say."""
    stems = set(head.identifiers.values())
    for member, content in binaries.items():
        folder, _, name = member.removeprefix("binaries/").partition("/")
        stem, dot, extension = name.rpartition(".")
        if folder not in FOLDERS or stem not in stems:
            continue  # data, or libraries that the binary brings along
        wanted, machine = FOLDERS[folder]
        if dot + extension != EXTENSIONS[wanted]:
            continue
        found, machines = what_is(content)
        if not found:
            yield member, "is not a shared library"
        elif found != wanted:
            yield member, f"is a binary for another platform: {found}, in a folder for {wanted}"
        elif machine not in machines:
            has = ", ".join(sorted(machines)) or "an unknown machine"
            yield member, f"is a binary for another platform: {has}, in a folder for {machine}"
        else:
            yield from _disagreements(head, member, stem, content)


def _disagreements(
    head: Head, member: str, stem: str, content: bytes
) -> Iterator[tuple[str, str]]:
    names = offered(content, head.version)
    for interface, identifier in head.identifiers.items():
        essential = ESSENTIAL.get((head.version[:1], interface))
        if identifier == stem and essential and essential not in names:
            says = f"the description says FMI {head.version} {interface}"
            yield member, f"disagrees with the description: {says}, it has no {essential}"


def _named(machines: Mapping[int, str], code: int) -> frozenset[str]:
    return frozenset({machines.get(code, f"machine {code:#x}")})
