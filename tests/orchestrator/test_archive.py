"""Files that are no FMU, or none for this machine; and how scalars become ports."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest

from sightline.orchestrator.errors import FmuError
from sightline.orchestrator.fmi.archive import read

from .conftest import variable


def test_missing_file_names_its_neighbours(make_fmu, tmp_path: Path) -> None:
    make_fmu("plant", [])
    with pytest.raises(FmuError, match=r"plnt\.fmu does not exist; in that folder: plant\.fmu"):
        read(tmp_path / "plnt.fmu")


def test_corrupt_archive_is_said_to_be(make_fmu) -> None:
    path = make_fmu("plant", [])
    path.write_bytes(path.read_bytes()[:40])
    with pytest.raises(FmuError, match=r"is not an FMU or is damaged: .*; build or fetch it again"):
        read(path)


def test_archive_without_description_is_no_fmu(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "")
    with pytest.raises(FmuError, match=r"is not an FMU: it has no modelDescription\.xml"):
        read(path)


def test_description_that_is_not_xml_is_said_to_be(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmi")
    with pytest.raises(FmuError, match=r"modelDescription\.xml: is not XML"):
        read(path)


def test_hostile_archive_is_refused_by_name_of_the_problem(make_fmu) -> None:
    path = make_fmu("plant", [])
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr("../evil", "")
    with pytest.raises(FmuError, match=r"\.\./evil: its name leads out of the folder"):
        read(path)


def test_description_with_entities_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", "<!DOCTYPE m [<!ENTITY a 'a'>]><m>&a;</m>")
    with pytest.raises(FmuError, match=r"modelDescription\.xml: has a document type"):
        read(path)


def test_identifier_that_is_a_path_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        text = '<m fmiVersion="2.0"><CoSimulation modelIdentifier="../../evil"/></m>'
        archive.writestr("modelDescription.xml", text)
    with pytest.raises(FmuError, match=r"CoSimulation is a path, '\.\./\.\./evil'; FMI asks for"):
        read(path)


def test_binary_for_another_platform_is_named(make_fmu) -> None:
    path = make_fmu("plant", [], platform="amiga")
    with pytest.raises(FmuError, match=r"no binaries/.*; it has binaries for amiga; export it for"):
        read(path)


def test_model_exchange_alone_is_refused(make_fmu) -> None:
    path = make_fmu("plant", [], head='<ModelExchange modelIdentifier="plant"/>')
    with pytest.raises(FmuError, match="offers no co-simulation, only model exchange"):
        read(path)


def test_unsupported_version_says_what_is_supported(make_fmu) -> None:
    path = make_fmu("plant", [], version="1.0")
    with pytest.raises(FmuError, match=r"is of FMI 1\.0; supported: FMI 2\.0"):
        read(path)


def test_complete_indices_become_arrays_in_row_major_order(make_fmu) -> None:
    names = ["m[2,1]", "m[1,1]", "m[1,2]", "m[2,2]", "v[1]", "v[3]", "s", "a[1].b"]
    ports = read(make_fmu("plant", [variable(n) for n in names])).ports
    assert {n: p.shape for n, p in ports.items()} == {
        "m": (2, 2), "v[1]": (), "v[3]": (), "s": (), "a[1].b": (),
    }  # fmt: skip
    assert ports["m"].references == (1, 2, 0, 3)
    assert list(ports["m"].labels()) == ["m[1,1]", "m[1,2]", "m[2,1]", "m[2,2]"]


def test_declared_dependencies_are_read_and_others_assumed(make_fmu) -> None:
    variables = [variable("y", "output"), variable("z", "output"), variable("u"), variable("w")]
    declared = read(make_fmu("a", variables, {"y": ["w"]}))
    assert declared.feedthrough == {0: frozenset({3}), 1: frozenset()}
    assumed = read(make_fmu("b", variables))
    assert assumed.feedthrough == {0: frozenset({2, 3}), 1: frozenset({2, 3})}


def test_platform_of_this_machine_is_what_the_reader_asks_for(make_fmu) -> None:
    assert read(make_fmu("plant", [], platform=fmpy.platform)).model_name == "plant"
