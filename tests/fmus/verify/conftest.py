"""Small sound FMUs, and the same with one defect: in the C source, or in the description."""

from __future__ import annotations

import subprocess
import zipfile
from collections.abc import Callable, Iterator
from pathlib import Path

import fmpy
import pytest

from sightline.fmus.native.platforms import own_platform, system_compiler
from sightline.fmus.verify.bench import Options, Workshop, verify, workshop
from sightline.fmus.verify.findings import Report

HERE = Path(__file__).parent
HEADERS = Path(fmpy.__file__).parent / "c-code"
Make = Callable[..., Path]


@pytest.fixture(scope="session")
def shop() -> Iterator[Workshop]:
    """One process for the checks of all tests."""
    with workshop() as made:
        yield made


@pytest.fixture(scope="session")
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., bytes]:
    """The shared library of a source with macros defined, compiled once."""
    folder = tmp_path_factory.mktemp("libraries")

    def compiled(source: str, *defines: str) -> bytes:
        out = folder / f"{source}{'-'.join(defines)}.so"
        if not out.exists():
            compiler = system_compiler()
            assert compiler is not None
            subprocess.run([compiler, "-shared", "-fPIC", "-O1", *(f"-D{d}" for d in defines),
                            f"-I{HEADERS}", str(HERE / source), "-o", str(out), "-lm"], check=True)
        return out.read_bytes()

    return compiled


@pytest.fixture
def make(library: Callable[..., bytes], tmp_path: Path) -> Make:
    """Make an FMU: ``defect`` of the source, ``edits`` (old, new) of the description.

    With ``end``, it asks for the end of the simulation after so many seconds; ``lag`` is the step
    of the solver inside one of FMI 3.0, in seconds.
    """

    def made(
        defect: str = "", *edits: tuple[str, str], name: str = "bench", fmi: int = 2,
        end: float | None = None, lag: float | None = None,
    ) -> Path:  # fmt: skip
        stem, identifier = ("model", "bench") if fmi == 2 else ("model3", "bench3")
        description = (HERE / f"{stem}.xml").read_text(encoding="utf-8")
        for old, new in edits:
            assert old in description
            description = description.replace(old, new)
        platform = own_platform()
        assert platform is not None
        path = tmp_path / f"{name}.fmu"
        given = {"ENDS": end, "LAG": lag}
        defines = [f"DEFECT_{defect}"] if defect else []
        defines += [f"{n}={v}" for n, v in given.items() if v is not None]
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", description)
            archive.writestr(platform.binary(fmi, identifier), library(f"{stem}.c", *defines))
        return path

    return made


@pytest.fixture
def check(shop: Workshop) -> Callable[..., Report]:
    """Run checks on files; the report of the last."""

    def checked(*files: Path, only: tuple[str, ...] = (), **options: object) -> Report:
        chosen = Options(only, **({"effort": 0.1} | options))  # type: ignore[arg-type]
        return list(verify(files, chosen, shop=shop))[-1]

    return checked
