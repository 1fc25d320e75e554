"""Unpacked FMUs are used again, checked, and never half there."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from sightline.orchestrator.errors import FmuError
from sightline.orchestrator.fmi.extraction import unpacked


@pytest.fixture
def archive(tmp_path: Path, monkeypatch) -> Path:
    monkeypatch.setenv("SIGHTLINE_CACHE", str(tmp_path / "cache"))
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("modelDescription.xml", "<fmi/>")
        file.writestr("resources/data.txt", "data")
    return path


def test_archive_is_unpacked_once_for_its_content(archive: Path, tmp_path: Path) -> None:
    folder = unpacked(archive)
    born = (folder / "resources/data.txt").stat().st_mtime_ns
    copy = tmp_path / "b.fmu"
    copy.write_bytes(archive.read_bytes())
    assert unpacked(copy) == folder
    assert (folder / "resources/data.txt").stat().st_mtime_ns == born


def test_other_content_goes_elsewhere(archive: Path) -> None:
    before = unpacked(archive)
    with zipfile.ZipFile(archive, "a") as file:
        file.writestr("more.txt", "more")
    assert unpacked(archive) != before


@pytest.mark.parametrize("damage", ["", "date"])
def test_damaged_copy_is_replaced(archive: Path, damage: str) -> None:
    folder = unpacked(archive)
    (folder / "resources/data.txt").write_text(damage, encoding="utf-8")
    assert unpacked(archive) == folder
    assert (folder / "resources/data.txt").read_text(encoding="utf-8") == "data"
    assert [p.name for p in folder.parent.iterdir()] == [folder.name]


def test_archive_that_leads_out_is_refused(archive: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(archive, "a") as file:
        file.writestr("../../../escaped.txt", "out")
    with pytest.raises(FmuError, match="leads out of it"):
        unpacked(archive)
    assert not list(tmp_path.rglob("escaped.txt"))
