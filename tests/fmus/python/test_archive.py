"""What the archive of a Python FMU holds, and that it comes out the same."""

from __future__ import annotations

import zipfile
from pathlib import Path

import fmpy
import pytest
from fmpy.validation import validate_fmu
from lxml import etree

from sightline.fmus.build import build


def description(path: Path) -> etree._Element:
    with zipfile.ZipFile(path) as archive:
        return etree.fromstring(archive.read("modelDescription.xml"))


def test_validation_has_no_message(python_fmu: Path) -> None:
    assert validate_fmu(str(python_fmu)) == []


def test_every_real_variable_has_a_defined_unit(python_fmu: Path) -> None:
    root = description(python_fmu)
    defined = {u.get("name") for u in root.iterfind("UnitDefinitions/Unit")}
    assert {v.get("unit") for v in root.iterfind("ModelVariables/ScalarVariable/Real")} <= defined


def test_every_variable_is_described(python_fmu: Path) -> None:
    root = description(python_fmu)
    assert all(v.get("description") for v in root.iterfind("ModelVariables/ScalarVariable"))


def test_unit_quantity_and_frame_of_a_force(body_fmu: Path) -> None:
    root = description(body_fmu)
    force = root.find("ModelVariables/ScalarVariable[@name='force[2]']")
    assert force.find("Real").get("unit") == "N"
    assert force.find("Real").get("quantity") == "Force"
    assert force.find("Annotations/Tool[@name='sightline']/Port").get("frame") == "body"
    newton = root.find("UnitDefinitions/Unit[@name='N']/BaseUnit")
    assert dict(newton.attrib) == {"kg": "1", "m": "1", "s": "-2"}


def test_a_sensor_declares_what_inputs_its_output_depends_on(fmu_cache: None) -> None:
    root = description(build("LineOfSightSensor", target="python"))
    variables = list(root.iterfind("ModelVariables/ScalarVariable"))
    names = [v.get("name") for v in variables]
    inputs = {v.get("name") for v in variables if v.get("causality") == "input"}
    first = root.find("ModelStructure/Outputs/Unknown")
    known = [names[int(i) - 1] for i in first.get("dependencies").split()]
    assert names[int(first.get("index")) - 1] == "line_of_sight[1]"
    expected = [f"{port}[{i + 1}]" for port, size in
                (("position", 3), ("target_position", 3), ("attitude", 4)) for i in range(size)]
    assert [name for name in known if name in inputs] == expected


def test_a_rigid_body_passes_no_input_straight_through(body_fmu: Path) -> None:
    root = description(body_fmu)
    inputs = {str(i) for i in range(1, 13)}
    for unknown in root.iterfind("ModelStructure/Outputs/Unknown"):
        assert inputs.isdisjoint(unknown.get("dependencies").split())


def test_initial_unknowns_depend_on_parameters(fmu_cache: None) -> None:
    root = description(build("RangeSensor", target="python"))
    names = [v.get("name") for v in root.iterfind("ModelVariables/ScalarVariable")]
    unknown = root.find("ModelStructure/InitialUnknowns/Unknown")
    assert "bias" in [names[int(i) - 1] for i in unknown.get("dependencies").split()]


def test_archive_is_the_same_byte_for_byte(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    archives = []
    for name in ("first", "second"):
        monkeypatch.setenv("SIGHTLINE_CACHE", str(tmp_path / name))
        archives.append(build("Gyro", target="python").read_bytes())
    assert archives[0] == archives[1]


def test_token_changes_with_the_structure(fmu_cache: None) -> None:
    tokens = {
        fmpy.read_model_description(
            str(build("ThrusterCluster", structure={"thrusters": n}, target="python"))
        ).guid
        for n in (6, 8, 12)
    }
    assert len(tokens) == 3


def test_fmu_carries_documentation_licence_and_icon(python_fmu: Path) -> None:
    with zipfile.ZipFile(python_fmu) as archive:
        assert {"documentation/index.html", "documentation/licenses/license.txt",
                "model.png"} <= set(archive.namelist())
        assert b"<table>" in archive.read("documentation/index.html")
        assert b"MIT License" in archive.read("documentation/licenses/license.txt")


def test_second_build_takes_the_fmu_from_the_cache(fmu_cache: None) -> None:
    first = build("Gyro", target="python")
    stamp = first.stat().st_mtime_ns
    assert build("Gyro", target="python").stat().st_mtime_ns == stamp
