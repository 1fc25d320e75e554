"""Compiling an FMU's C sources: the system's compiler for this machine, Zig for every platform."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import struct
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import BuildError

# rounding must not depend on the platform: no fused multiply-add unless the source says so
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-ffunction-sections",
         "-fno-math-errno", "-fomit-frame-pointer")  # fmt: skip
SMALL = ("-g0", "-fno-unroll-loops", "-fno-unwind-tables", "-fno-asynchronous-unwind-tables")


@dataclass(frozen=True)
class Platform:
    """A platform that FMUs can be built for, and its names in both standards.

    FMI 2.0 names folders for x86 only; for other machines it refers to the names of FMI 3.0.
    """

    name: str
    fmi2: str
    fmi3: str
    extension: str
    zig_target: str
    link: tuple[str, ...] = ()
    link_by_system: tuple[str, ...] = ()  # what only the system's linker takes

    def binary(self, fmi: int, identifier: str) -> str:
        """Path of the binary in the archive."""
        return f"binaries/{self.fmi2 if fmi == 2 else self.fmi3}/{identifier}{self.extension}"


LINUX = ("-Wl,--gc-sections", "-Wl,--build-id=none", "-lm")
DENSE = ("-Wl,-z,noseparate-code",)  # no padding to pages between segments
MACOS = ("-Wl,-dead_strip",)
PLATFORMS = {
    p.name: p
    for p in (
        Platform("linux-x86_64", "linux64", "x86_64-linux", ".so",
                 "x86_64-linux-gnu.2.17", LINUX, DENSE),
        Platform("linux-aarch64", "aarch64-linux", "aarch64-linux", ".so",
                 "aarch64-linux-gnu.2.17", LINUX, DENSE),
        Platform("windows-x86_64", "win64", "x86_64-windows", ".dll",
                 "x86_64-windows-gnu", ("-Wl,--gc-sections",)),
        Platform("macos-x86_64", "darwin64", "x86_64-darwin", ".dylib", "x86_64-macos", MACOS),
        Platform("macos-arm64", "aarch64-darwin", "aarch64-darwin", ".dylib",
                 "aarch64-macos", MACOS),
    )
}  # fmt: skip


def own_platform() -> Platform | None:
    """The platform that this Python runs on, if FMUs can be built for it."""
    system = {"linux": "linux", "win32": "windows", "darwin": "macos"}.get(sys.platform, "")
    machine = platform.machine().lower().replace("amd64", "x86_64")
    for name in (f"{system}-{machine}", f"{system}-{machine.replace('arm64', 'aarch64')}"):
        if name in PLATFORMS:
            return PLATFORMS[name]
    return None


def system_compiler() -> str | None:
    """The C compiler of this machine: that of the environment variable CC, cc, gcc or clang."""
    chosen = os.environ.get("CC")
    return next((p for n in (chosen, "cc", "gcc", "clang") if n and (p := shutil.which(n))), None)


def zig_available() -> bool:
    """Whether Zig is installed as a Python package."""
    return importlib.util.find_spec("ziglang") is not None


def choose(component: str, names: Sequence[str] | None) -> list[Platform]:
    """The platforms to build for. Raises BuildError naming all that cannot be built."""
    own = own_platform()
    if names is None:
        if own is None or not (system_compiler() or zig_available()):
            raise BuildError(component, ["there is no C compiler: install one (cc, gcc, clang), "
                                         "pip install sightline[cross], or use --target python"])
        return [own]
    problems = []
    for name in names:
        if name not in PLATFORMS:
            problems.append(f"there is no platform {name!r}; there are {', '.join(PLATFORMS)}")
        elif not zig_available() and not (own and name == own.name and system_compiler()):
            problems.append(f"building for {name} needs Zig: pip install sightline[cross]")
    if problems:
        raise BuildError(component, problems)
    return [PLATFORMS[n] for n in dict.fromkeys(names)]


def compile_library(
    component: str, target: Platform, source: Path, out: Path, *, portable: bool = False
) -> None:
    """Compile a C file into a shared library beside it. Raises BuildError quoting the compiler.

    ``portable``: by Zig if it is there, for any machine of the platform; else the own platform's
    library is made by the system's compiler, which is faster, for machines like this one.
    """
    cc = system_compiler() if target == own_platform() else None
    link = ["-shared", "-s", *target.link, "-o", str(out)]
    position = [] if target.extension == ".dll" else ["-fPIC"]
    if target.extension == ".dylib":  # the name by which it is known, else it is that of `out`
        link.append(f"-Wl,-install_name,@rpath/{component}.dylib")
    if cc and not (portable and zig_available()):
        commands = [[cc, *FLAGS, *position, source.name, *link, *target.link_by_system]]
    else:
        # in two steps, because Zig builds the C runtime that it links as small as these flags say
        zig = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig_target]
        made = f"{target.name}.o"
        commands = [[*zig, *FLAGS, *SMALL, *position, "-c", source.name, "-o", made],
                    [*zig, "-Os", made, *link]]  # fmt: skip
    for command in commands:
        done = subprocess.run(command, cwd=source.parent, capture_output=True, text=True)
        if done.returncode != 0:
            raise BuildError(component, [f"{target.name}: {line}" for line in
                                         done.stderr.strip().splitlines()[:20]])


def universal(libraries: Sequence[bytes]) -> bytes:
    """macOS libraries for several machines in one file, of which the system takes its own."""
    alignment = 14  # power of two: the page size of arm64
    table, content = struct.pack(">II", 0xCAFEBABE, len(libraries)), b""
    start = 1 << alignment
    for library in libraries:
        machine, variant = struct.unpack_from("<II", library, 4)
        content += bytes(-len(content) % start)
        offset = start + len(content)
        table += struct.pack(">IIIII", machine, variant, offset, len(library), alignment)
        content += library
    return table.ljust(start, b"\0") + content
