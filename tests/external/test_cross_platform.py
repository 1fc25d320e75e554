"""One FMU, five platforms: what its libraries need, what they export, and that they agree."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import fmpy
import lief
import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.fmus.native.platforms import PLATFORMS
from sightline.orchestrator.fmi.archive import read

HEADERS = Path(fmpy.__file__).parent / "c-code"
LOADER = Path(__file__).with_name("loader.c")
STEPS, STEP = 1000, 0.01
SIZE = 100_000  # bytes, of one library
LINUX, MACOS = ("linux-x86_64", "linux-aarch64"), ("macos-x86_64", "macos-arm64")
RUNNERS = {
    "linux-x86_64": [],
    "linux-aarch64": ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"],
    "windows-x86_64": ["/usr/lib/wine/wine64"],
}


@dataclass(frozen=True)
class Case:
    """A block, how it is driven, and how far C libraries may move its outputs."""

    block: str
    tolerance: float
    parameters: dict[str, tuple[float, ...]] = field(default_factory=dict)
    slopes: dict[str, tuple[float, ...]] = field(default_factory=dict)


CASES = [
    # square roots only, which every C library rounds correctly: every bit must agree
    Case("FreeRigidBody", 0.0, {"mass": (3.0,), "angular_velocity": (0.3, -0.2, 0.1)},
         {"force": (1e-3, 2e-3, -1e-3), "torque": (1e-5, -2e-5, 3e-5)}),
    # noise: logarithm, sine and cosine of each C library, correct to one unit in the last place
    Case("LineOfSightSensor", 1e-12, {"noise_density": (1e-3,), "sample_period": (0.05,)},
         {"position": (0.01, 0.02, 0.0), "target_position": (0.0, 0.01, 0.03)}),
    # sine and cosine, through eight Newton steps
    Case("KeplerOrbit", 1e-12, {"eccentricity": (0.7,), "inclination": (0.9,)}),
]  # fmt: skip


@pytest.fixture(scope="session", params=[2, 3])
def fmi(request: pytest.FixtureRequest) -> int:
    """The version of the standard."""
    return request.param


@pytest.fixture(scope="session")
def libraries(fmi: int) -> dict[str, bytes]:
    """The rigid body's library for each platform, as members of one FMU."""
    path = build("FreeRigidBody", target="native", fmi=fmi, platforms=list(PLATFORMS))
    with zipfile.ZipFile(path) as archive:
        return {
            name: _own_part(archive.read(platform.binary(fmi, "FreeRigidBody")), name)
            for name, platform in PLATFORMS.items()
        }


def _own_part(library: bytes, platform: str) -> bytes:
    """The part of a universal macOS library for one platform; other libraries are whole."""
    if not library.startswith(b"\xca\xfe\xba\xbe"):
        return library
    fat = lief.MachO.parse(library)
    part = fat.at(MACOS.index(platform))
    return library[part.fat_offset:part.fat_offset + part.original_size]


def functions(fmi: int) -> set[str]:
    """Every function that the standard's header declares."""
    text = (HEADERS / f"fmi{fmi}Functions.h").read_text(encoding="utf-8")
    return set(re.findall(rf"FMI{fmi}_Export\s+\w+\s+(fmi{fmi}\w+)\s*;", text))


def test_an_fmu_holds_the_library_of_each_platform_where_the_standards_put_it():
    members = {
        fmi: {n for n in zipfile.ZipFile(path).namelist() if n.startswith("binaries/")}
        for fmi in (2, 3)
        for path in [build("Gyro", target="native", fmi=fmi, platforms=list(PLATFORMS))]
    }

    assert members[2] == {
        "binaries/linux64/Gyro.so", "binaries/aarch64-linux/Gyro.so", "binaries/win64/Gyro.dll",
        "binaries/darwin64/Gyro.dylib", "binaries/aarch64-darwin/Gyro.dylib",
    }  # fmt: skip
    assert members[3] == {
        "binaries/x86_64-linux/Gyro.so", "binaries/aarch64-linux/Gyro.so",
        "binaries/x86_64-windows/Gyro.dll", "binaries/x86_64-darwin/Gyro.dylib",
        "binaries/aarch64-darwin/Gyro.dylib",
    }  # fmt: skip


@pytest.mark.parametrize("platform", PLATFORMS)
def test_a_library_is_small(libraries: dict[str, bytes], platform: str):
    assert len(libraries[platform]) < SIZE


@pytest.mark.parametrize("platform", PLATFORMS)
def test_a_library_exports_the_functions_of_the_standard_and_nothing_else(
    libraries: dict[str, bytes], platform: str, fmi: int
):
    library = lief.parse(libraries[platform])
    exported = {f.name.removeprefix("_" if platform in MACOS else "") for f in _exports(library)}

    assert exported == functions(fmi)


def _exports(library: lief.Binary) -> list:
    if isinstance(library, lief.MachO.Binary):
        added_by_linker = {"__mh_dylib_header", "___dso_handle"}
        return [
            s for s in library.symbols if s.has_export_info and s.name not in added_by_linker
        ]
    return list(library.exported_functions)


@pytest.mark.parametrize("platform", LINUX)
def test_a_linux_library_needs_libc_and_libm_of_2012_or_later(
    libraries: dict[str, bytes], platform: str
):
    library = lief.parse(libraries[platform])
    needed = library.symbols_version_requirement
    versions = {v.name for n in needed for v in n.get_auxiliary_symbols()}

    assert set(library.libraries) == {"libc.so.6", "libm.so.6"}
    assert all(v.startswith("GLIBC_") for v in versions)
    assert max(tuple(map(int, v[6:].split("."))) for v in versions) <= (2, 17)


def test_a_windows_library_needs_the_universal_c_runtime_only(libraries: dict[str, bytes]):
    library = lief.parse(libraries["windows-x86_64"])

    assert all(
        i.name == "KERNEL32.dll" or i.name.startswith("api-ms-win-crt-") for i in library.imports
    )


@pytest.mark.parametrize(
    ("platform", "machine"), [("macos-x86_64", "X86_64"), ("macos-arm64", "ARM64")]
)
def test_a_macos_library_needs_libsystem_only_and_is_signed_where_it_must_be(
    libraries: dict[str, bytes], platform: str, machine: str
):
    library = lief.parse(libraries[platform])
    commands = [str(c.command).rpartition(".")[2] for c in library.commands]
    names = [d.name for d in library.libraries]

    assert library.header.cpu_type.name == machine
    assert library.header.file_type.name == "DYLIB"
    assert names == ["@rpath/FreeRigidBody.dylib", "/usr/lib/libSystem.B.dylib"]
    assert commands.count("LOAD_DYLIB") == 1
    assert "RPATH" not in commands
    assert "CODE_SIGNATURE" in commands or machine == "X86_64"  # arm64 loads signed code only


def test_the_macos_library_of_fmi_2_runs_on_both_machines():
    path = build("Gyro", target="native", fmi=2, platforms=list(PLATFORMS))
    with zipfile.ZipFile(path) as archive:
        both = archive.read("binaries/darwin64/Gyro.dylib")
        arm = archive.read("binaries/aarch64-darwin/Gyro.dylib")
    parts = lief.MachO.parse(both)

    assert [p.header.cpu_type.name for p in parts] == ["X86_64", "ARM64"]
    assert _own_part(both, "macos-arm64") == arm


@pytest.mark.parametrize("platform", PLATFORMS)
def test_a_library_tells_nothing_of_the_machine_that_built_it(
    libraries: dict[str, bytes], platform: str, tmp_path: Path
):
    library = libraries[platform]

    assert str(Path.home()).encode() + b"/" not in library
    assert str(tmp_path.parents[2]).encode() + b"/" not in library


@pytest.fixture(scope="session")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """Wine with a folder of its own."""
    values = os.environ | {
        "WINEPREFIX": str(tmp_path_factory.mktemp("wine")),
        "WINEDEBUG": "-all",
        "WINEDLLOVERRIDES": "mscoree,mshtml=",
    }
    values.pop("DISPLAY", None)
    yield values
    subprocess.run(["/usr/lib/wine/wineserver64", "-k"], env=values, check=False)


@pytest.fixture(scope="session")
def run(
    tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str]
) -> Callable[[Case, str], np.ndarray]:
    """Runs a case on a platform: one row of outputs for each step."""
    folder = tmp_path_factory.mktemp("loader")

    def loader(platform: str, headers: Path) -> Path:
        target = PLATFORMS[platform]
        program = folder / f"{platform}.exe"
        if not program.exists():
            system = ["-ldl"] if platform in LINUX else []
            command = [sys.executable, "-m", "ziglang", "cc", "-target", target.zig_target, "-O1"]
            command += ["-I", str(headers), str(LOADER), *system, "-o", str(program)]
            subprocess.run(command, check=True)
        return program

    def run_case(case: Case, platform: str) -> np.ndarray:
        path = build(case.block, target="native", fmi=2, platforms=list(PLATFORMS))
        unpacked = folder / case.block
        if not unpacked.exists():
            zipfile.ZipFile(path).extractall(unpacked)
        fmu = read(path)
        library = unpacked / PLATFORMS[platform].binary(2, case.block)
        command = [*RUNNERS[platform], str(loader(platform, unpacked / "sources"))]
        command += [str(library), fmu.token, str(STEPS), repr(STEP)]
        for name, values in case.parameters.items():
            for reference, value in zip(fmu.ports[name].references, values, strict=True):
                command += ["set", str(reference), repr(value)]
        for name, slopes in case.slopes.items():
            port = fmu.ports[name]
            for i, slope in enumerate(slopes):
                command += ["drive", str(port.references[i]), port.start[i], repr(slope)]
        for port in (p for p in fmu.outputs.values() if p.kind == "real"):
            for reference in port.references:
                command += ["get", str(reference)]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, done.stderr
        return np.array([[float.fromhex(x) for x in r.split()] for r in done.stdout.splitlines()])

    return run_case


@pytest.mark.parametrize("platform", ["linux-aarch64", "windows-x86_64"])
@pytest.mark.parametrize("case", CASES, ids=lambda case: case.block)
def test_other_platforms_compute_the_numbers_of_linux_x86_64(
    case: Case, platform: str, run: Callable[[Case, str], np.ndarray]
):
    expected = run(case, "linux-x86_64")
    computed = run(case, platform)
    size = np.max(np.abs(expected), axis=0)

    assert expected.shape == (STEPS, expected.shape[1])
    assert np.all(np.ptp(expected, axis=0) > 0.0)
    assert np.all(np.abs(computed - expected) <= case.tolerance * size)
