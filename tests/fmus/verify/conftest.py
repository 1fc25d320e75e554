"""A small sound FMU, and the same with one defect: in its C source, or in its description."""

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
def library(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], bytes]:
    """The shared library of the small FMU with a defect, compiled once."""
    folder = tmp_path_factory.mktemp("libraries")

    def compiled(defect: str) -> bytes:
        out = folder / f"{defect or 'sound'}.so"
        if not out.exists():
            compiler = system_compiler()
            assert compiler is not None
            define = [f"-DDEFECT_{defect}"] if defect else []
            subprocess.run([compiler, "-shared", "-fPIC", "-O1", *define, f"-I{HEADERS}",
                            str(HERE / "model.c"), "-o", str(out), "-lm"], check=True)
        return out.read_bytes()

    return compiled


@pytest.fixture
def make(library: Callable[[str], bytes], tmp_path: Path) -> Make:
    """Make an FMU: ``defect`` of the source, ``edits`` (old, new) of the description."""

    def made(defect: str = "", *edits: tuple[str, str], name: str = "bench") -> Path:
        description = (HERE / "model.xml").read_text(encoding="utf-8")
        for old, new in edits:
            assert old in description
            description = description.replace(old, new)
        platform = own_platform()
        assert platform is not None
        path = tmp_path / f"{name}.fmu"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
            archive.writestr("modelDescription.xml", description)
            archive.writestr(platform.binary(2, "bench"), library(defect))
        return path

    return made


@pytest.fixture
def check(shop: Workshop) -> Callable[..., Report]:
    """Run checks on files; the report of the last."""

    def checked(*files: Path, only: tuple[str, ...] = (), **options: object) -> Report:
        chosen = Options(only, **({"effort": 0.1} | options))  # type: ignore[arg-type]
        return list(verify(files, chosen, shop=shop))[-1]

    return checked
