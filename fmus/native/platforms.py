"""Compiling an FMU's C sources: the system's compiler for this machine, Zig for every platform."""

from __future__ import annotations

import importlib.util
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from ..errors import BuildError

# rounding must not depend on the platform: no fused multiply-add unless the source says so
FLAGS = ("-std=c11", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-ffunction-sections",
         "-fno-math-errno", "-shared")  # fmt: skip


@dataclass(frozen=True)
class Platform:
    """A platform that FMUs can be built for, and its names in both standards."""

    name: str
    fmi2: str
    fmi3: str
    extension: str
    zig_target: str
    flags: tuple[str, ...] = ()

    def binary(self, fmi: int, identifier: str) -> str:
        """Path of the binary in the archive."""
        return f"binaries/{self.fmi2 if fmi == 2 else self.fmi3}/{identifier}{self.extension}"


LINUX_FLAGS = ("-fPIC", "-Wl,--gc-sections", "-Wl,--build-id=none",
               "-Wl,-z,noseparate-code", "-s", "-lm")
PLATFORMS = {
    p.name: p
    for p in (
        Platform("linux-x86_64", "linux64", "x86_64-linux", ".so",
                 "x86_64-linux-gnu.2.17", LINUX_FLAGS),
        Platform("linux-aarch64", "aarch64-linux", "aarch64-linux", ".so",
                 "aarch64-linux-gnu.2.17", LINUX_FLAGS),
        Platform("windows-x86_64", "win64", "x86_64-windows", ".dll", "x86_64-windows-gnu",
                 ("-s", "-Wl,--gc-sections")),
        Platform("macos-x86_64", "darwin64", "x86_64-darwin", ".dylib", "x86_64-macos",
                 ("-fPIC", "-Wl,-dead_strip")),
        Platform("macos-arm64", "aarch64-darwin", "aarch64-darwin", ".dylib", "aarch64-macos",
                 ("-fPIC", "-Wl,-dead_strip")),
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


def compile_library(component: str, target: Platform, source: Path, out: Path) -> None:
    """Compile one C file into one shared library. Raises BuildError with the compiler's message."""
    cc = system_compiler() if target == own_platform() else None
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig_target]
    command = [cc] if cc else zig
    command += [*FLAGS, source.name, *target.flags, "-o", str(out)]
    done = subprocess.run(command, cwd=source.parent, capture_output=True, text=True)
    if done.returncode != 0:
        raise BuildError(component, [f"{target.name}: {line}" for line in
                                     done.stderr.strip().splitlines()[:20]])

