"""What a native FMU consists of: complete, reproducible, self-contained, buildable again."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import fmpy
import fmpy.build
import numpy as np
import pytest

from sightline.fmus.errors import BuildError
from sightline.fmus.model import model_of
from sightline.fmus.native import platforms
from sightline.fmus.native.target import build_native, compiler_available

from .blocks import Branching, Everything
from .conftest import Builder
from .driver import Fmi, Native, native_model

HEADERS = Path(fmpy.__file__).parent / "c-code"
BINARY = platforms.own_platform()
LIBRARIES = {"libc.so.6", "libm.so.6"}


def binary(native: Native) -> Path:
    assert BINARY is not None
    return native.folder / BINARY.binary(native.fmi, native.model.block.name)


def test_a_build_is_reproducible_byte_for_byte(everything: Native, tmp_path: Path) -> None:
    again = tmp_path / "again.fmu"
    build_native(native_model(Everything()), fmi=everything.fmi, out=again)
    assert again.read_bytes() == everything.path.read_bytes()


def test_the_archive_carries_sources_documentation_and_licence(everything: Native) -> None:
    names = set(zipfile.ZipFile(everything.path).namelist())
    assert {"modelDescription.xml", "documentation/index.html", "sources/fmu.c",
            "sources/equations.c", "documentation/licenses/license.txt"} <= names  # fmt: skip
    assert ("sources/buildDescription.xml" in names) == (everything.fmi == 3)


def test_nothing_of_the_building_machine_is_in_the_archive(everything: Native) -> None:
    traces = [str(Path.home()).encode(), str(Path(__file__).parents[3]).encode(), b"/tmp"]
    with zipfile.ZipFile(everything.path) as archive:
        for name in archive.namelist():
            content = archive.read(name)
            assert not any(len(t) > 1 and t in content for t in traces), name


def test_every_function_of_the_standard_is_exported_and_nothing_else(
    everything: Native, fmi: Fmi
) -> None:
    header = (HEADERS / f"fmi{fmi}Functions.h").read_text()
    standard = set(re.findall(rf"^#define (fmi{fmi}\w+) +fmi{fmi}FullName", header, re.M))
    listed = subprocess.run(["nm", "-D", "--defined-only", binary(everything)], check=True,
                            capture_output=True, text=True).stdout  # fmt: skip
    assert {line.split()[-1] for line in listed.splitlines()} == standard


def test_the_library_needs_libc_and_libm_only(everything: Native) -> None:
    dynamic = subprocess.run(["readelf", "-d", binary(everything)], check=True,
                             capture_output=True, text=True).stdout  # fmt: skip
    assert set(re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic)) <= LIBRARIES


def test_the_library_has_no_variables(everything: Native) -> None:
    sections = subprocess.run(["size", "-A", binary(everything)], check=True,
                              capture_output=True, text=True).stdout  # fmt: skip
    sizes = {p[0]: int(p[1]) for line in sections.splitlines()
             if (p := line.split()) and p[0].startswith(".")}
    assert sizes.get(".bss", 0) <= 8  # of the compiler's start-up code
    assert sizes.get(".data", 0) <= 8


def test_it_builds_again_from_its_own_sources(everything: Native, tmp_path: Path) -> None:
    folder = tmp_path / "copy"
    shutil.copytree(everything.folder, folder)
    shutil.rmtree(folder / "binaries")
    description = fmpy.read_model_description(str(folder))
    (files,) = description.buildConfigurations[0].sourceFileSets
    target = folder / binary(everything).relative_to(everything.folder)
    target.parent.mkdir(parents=True)
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-O1", "-ffp-contract=off", "-o", target,
         *(folder / "sources" / f for f in files.sourceFiles), "-lm"], check=True,
    )  # fmt: skip
    rebuilt = Native(everything.model, everything.fmi, everything.path, folder).instance()
    first = everything.instance()
    for fmu in (rebuilt, first):
        fmu.initialise()
        fmu.step(0.0, 1.0)
    np.testing.assert_allclose(rebuilt.all("state", "output"), first.all("state", "output"),
                               rtol=1e-14)  # fmt: skip


def test_the_runtime_compiles_without_a_warning(everything: Native) -> None:
    subprocess.run(
        ["cc", "-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-Wno-unused-function",
         "-Wno-unused-parameter", "-Wno-unused-variable", "-O2", "-fsyntax-only", "fmu.c"],
        cwd=everything.folder / "sources", check=True,
    )  # fmt: skip


def test_each_source_compiles_on_its_own(everything: Native) -> None:
    sources = everything.folder / "sources"
    for file in sorted(sources.glob("*.c")):
        subprocess.run(["cc", "-std=c11", "-fsyntax-only", file.name], cwd=sources, check=True)


def test_a_block_that_cannot_be_traced_is_refused(tmp_path: Path) -> None:
    model = model_of(Branching(), None, derivatives=True)
    with pytest.raises(BuildError, match="cannot be traced; build it with --target python"):
        build_native(model, fmi=2, out=tmp_path / "x.fmu")


def test_unknown_platforms_are_all_named(tmp_path: Path) -> None:
    with pytest.raises(BuildError) as caught:
        build_native(native_model(Everything()), fmi=2, platforms=["amiga", "atari"],
                     out=tmp_path / "x.fmu")  # fmt: skip
    assert len(caught.value.problems) == 2
    assert "no platform 'amiga'; there are linux-x86_64, linux-aarch64" in str(caught.value)


def test_without_a_compiler_the_error_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(platforms, "zig_available", lambda: False)
    monkeypatch.setattr("sightline.fmus.native.target.zig_available", lambda: False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert not compiler_available()
    with pytest.raises(BuildError, match=r"no C compiler.*sightline\[cross\]"):
        build_native(native_model(Everything()), fmi=2, out=tmp_path / "x.fmu")
    with pytest.raises(BuildError, match=r"needs Zig: pip install sightline\[cross\]"):
        build_native(native_model(Everything()), fmi=2, platforms=["windows-x86_64"],
                     out=tmp_path / "x.fmu")  # fmt: skip


def test_a_compiler_that_fails_is_quoted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\necho 'error: out of patience' >&2\nexit 1\n")
    os.chmod(broken, 0o755)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(BuildError, match="out of patience"):
        build_native(native_model(Everything()), fmi=2, out=tmp_path / "x.fmu")
    assert not (tmp_path / "x.fmu").exists()


def test_an_fmu_is_small(native: Builder) -> None:
    assert binary(native("FreeRigidBody", 2)).stat().st_size < 100_000
