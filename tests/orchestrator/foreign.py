"""Foreign FMUs of one C source, for tests."""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import fmpy


def library(folder: Path, name: str, source: str) -> Path:
    """The shared library of a C source."""
    (folder / f"{name}.c").write_text(source, encoding="utf-8")
    path = folder / f"{name}{fmpy.sharedLibraryExtension}"
    command = ["cc", "-shared", "-fPIC", str(folder / f"{name}.c"), "-o", str(path), "-lm"]
    subprocess.run(command, check=True)
    return path


def archive(path: Path, description: str, binary: Path, platform: str = fmpy.platform) -> Path:
    """An FMU of a description and a shared library."""
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("modelDescription.xml", description)
        file.write(binary, f"binaries/{platform}/{binary.name}")
    return path
