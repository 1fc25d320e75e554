"""Values in units of a datasheet: converted, told, and refused by the text."""

from __future__ import annotations

import math
from pathlib import Path

import h5py
import pytest

from sightline.orchestrator import Builder
from sightline.orchestrator.explain.explanation import explain
from sightline.orchestrator.system import System
from sightline.orchestrator.wiring.graph import Setting

from .conftest import SIMULATION, variable

DEG = math.pi / 180
DENSITY = 'noise_density = { value = 0.15, unit = "deg/sqrt(h)" }'


@pytest.fixture(autouse=True)
def gyro(make_fmu) -> None:
    def parameter(name: str, **attributes: str) -> str:
        return variable(name, "parameter", start="0", **attributes)

    make_fmu("gyro", [
        parameter("noise_density", unit="rad/s/sqrt(Hz)"),  # by name only, as FMI has no form
        parameter("walk_density", unit="rad/s/s/sqrt(Hz)"),
        *[parameter(f"bias[{i}]", unit="rad/s") for i in (1, 2, 3)],
        parameter("height", unit="km", min="0", max="10"),
        parameter("heat", unit="degC"),
        parameter("scale", unit="1"),
        parameter("gain"),
        parameter("odd", unit="fnord"),
        variable("count", "parameter", "Integer", start="0"),
        variable("rate", unit="rad/s", start="0"),
        variable("y", "output"),
    ], {"y": []})  # fmt: skip


@pytest.fixture
def settings(write):
    """The settings of one instance by name."""

    def found(parameters: str, start: str = "") -> dict[str, Setting]:
        body = f'fmu = "gyro.fmu"\n[instances.g.parameters]\n{parameters}\n'
        system = System.from_toml(write(g=f"{body}[instances.g.start]\n{start}"))
        return {s.port.name: s for s in system.graph.nodes[0].settings}

    return found


@pytest.mark.parametrize(
    ("name", "value", "unit", "expected"),
    [
        ("noise_density", 0.15, "deg/sqrt(h)", 0.15 * DEG / 60),
        ("noise_density", 0.15, "deg/√h", 0.15 * DEG / 60),
        ("noise_density", 9.0, "deg/h/sqrt(Hz)", 9.0 * DEG / 3600),
        ("walk_density", 2.0, "deg/h/sqrt(h)", 2.0 * DEG / 3600 / 60),
        ("height", 5, "m", 0.005),
        ("heat", 300.15, "K", 27.0),
        ("scale", 500, "ppm", 500e-6),
        ("scale", 2, "%", 0.02),
    ],
)
def test_value_is_converted_to_the_declared_unit(
    settings, name: str, value: float, unit: str, expected: float
) -> None:
    found = settings(f'{name} = {{ value = {value}, unit = "{unit}" }}')[name]
    assert found.values == (pytest.approx(expected, rel=1e-12),)


def test_array_and_start_value_are_converted(settings) -> None:
    found = settings('bias = { value = [3, 0, -6], unit = "deg/h" }',
                     'rate = { value = 180, unit = "deg/s" }')
    assert found["bias"].values == pytest.approx([3 * DEG / 3600, 0.0, -6 * DEG / 3600], rel=1e-12)
    assert found["rate"].values == (pytest.approx(math.pi, rel=1e-15),)


def test_explain_notes_and_results_tell_each_conversion(write, tmp_path: Path) -> None:
    told = (
        "g.noise_density: 0.15 deg/sqrt(h) to 4.363323e-05 rad/s/sqrt(Hz)",
        "g.bias: [3, 0, -6] deg/h to [1.454441e-05, 0, -2.908882e-05] rad/s",
    )
    same = 'heat = { value = 20.0, unit = "degC" }'  # nothing to convert
    body = f'fmu = "gyro.fmu"\n[instances.g.parameters]\n{DENSITY}\n{same}\n'
    body += 'bias = { value = [3, 0, -6], unit = "deg/h" }'
    system = System.from_toml(write(g=body))
    assert explain(system).conversions == told
    assert system.graph.notes[:2] == told


def test_results_hold_what_was_given_and_what_it_became(tmp_path: Path) -> None:
    build = Builder(stop_time=0.2, step=0.1)
    given = {"value": 0.15, "unit": "deg/sqrt(h)"}
    build.add("g", "Gyro", parameters={"noise_density": given, "sample_period": 0.1})
    results = build.system().simulate(tmp_path)
    told = "g.noise_density: 0.15 deg/sqrt(h) to 4.363323e-05 rad/s/sqrt(Hz)"
    assert results.conversions == (told,)
    assert 'noise_density = { value = 0.15, unit = "deg/sqrt(h)" }' in results.config
    with h5py.File(tmp_path / "results.h5") as file:
        assert file["conversions"].asstr()[()] == told


def test_command_line_takes_a_unit(write) -> None:
    asked = {"g.height": {"value": 250, "unit": "m"}}
    system = System.from_toml(write(g='fmu = "gyro.fmu"'), asked)
    assert system.graph.nodes[0].settings[0].values == (0.25,)


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ('{ value = 500, unit = "m" }', [0.5, 0.5]),
        ('{ each = [500, 700], unit = "m" }', [0.5, 0.7]),
        ('{ first = 1000, step = 10, unit = "m" }', [1.0, 1.01]),
    ],
)
def test_template_gives_its_copies_values_in_units(
    tmp_path: Path, rule: str, expected: list[float]
) -> None:
    template = '[repeat.i]\ncount = 2\n[repeat.i.instances."g{i}"]\nfmu = "gyro.fmu"\n'
    path = tmp_path / "system.toml"
    path.write_text(f"{SIMULATION}{template}parameters = {{ height = {rule} }}", encoding="utf-8")
    nodes = System.from_toml(path).graph.nodes
    assert [n.settings[0].values[0] for n in nodes] == pytest.approx(expected, rel=1e-15)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ('noise_density = { value = 3, unit = "deg/h" }',
         "is given in deg/h (s-1.rad), noise_density is in rad/s/sqrt(Hz) (s-0.5.rad); "
         "give it in rad/s/sqrt(Hz) or deg/sqrt(h)"),
        ('bias = { value = [1, 2, 3], unit = "arcsec" }',
         "is given in arcsec (rad), bias is in rad/s (s-1.rad); "
         "give it in rad/s or deg/s or deg/h"),
        ('height = { value = 3, unit = "kg.m2" }',
         "is given in kg.m2 (kg.m2), height is in km (m); give it in km or mm"),
        ('bias = { value = [1, 2, 3], unit = "dge/h" }',
         "'dge/h' is not a unit: dge is not known; "
         "did you mean deg/h or deg/s or deg/sqrt(h)?"),
        ('height = { value = 3, unit = "parsnips" }',
         "'parsnips' is not a unit: parsnips is not known; "
         "for example: arcsec, arcsec/sqrt(Hz), deg, deg/h, deg/h/sqrt(h), deg/s, deg/sqrt(h), "
         "g, …"),
        ('bias = { value = [1, 2, 3], unit = "degs" }',
         "'degs' is not a unit: degs is not known; did you mean deg/s?"),
        ('scale = { value = 3, unit = "rad" }',
         "is given in rad (rad), scale is in 1; give the plain value"),
        ('height = { value = 11000, unit = "m" }',
         "height is 11, above the maximum 10 km, given as 11000 m"),
        ('height = { value = "high", unit = "m" }', "height is 'high', not a real"),
        ('bias = { value = [1, 2], unit = "deg/h" }',
         "has the shape 2, bias needs the shape 3"),
        ("height = { value = 3 }", "is a table that lacks unit; a value in its own unit is "
         '{ value = 0.15, unit = "deg/sqrt(h)" }'),
        ('height = { value = 3, unit = "m", sigma = 1 }', "has the unknown key sigma; a value in "
         'its own unit is { value = 0.15, unit = "deg/sqrt(h)" }'),
        ("height = { value = 3, unit = 5 }", "has the unit 5, not a text; a value in its own unit "
         'is { value = 0.15, unit = "deg/sqrt(h)" }'),
        ('gain = { value = 3, unit = "m" }',
         "is given in m, but gain is declared without a unit; give the plain value"),
        ('count = { value = 3, unit = "m" }',
         "is given in m, but count is declared without a unit; give the plain value"),
        ('odd = { value = 3, unit = "m" }',
         "is given in m, but what fnord means is not known; give the plain value in fnord"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_its_line(
    write, problems, setting: str, message: str
) -> None:
    name = setting.partition(" ")[0]
    body = f'fmu = "gyro.fmu"\n[instances.g.parameters]\n{setting}'
    assert problems(write(g=body)) == [f"system.toml:10: instances.g.parameters.{name}: {message}"]


def test_all_that_is_wrong_comes_in_one_report(write, problems) -> None:
    body = (
        'fmu = "gyro.fmu"\n[instances.g.parameters]\ngain = "much"\n'
        'scale = { value = 1, unit = "m" }\nheight = { value = 1, unit = "s" }'
    )
    assert [p.partition(":")[2].partition(":")[0] for p in problems(write(g=body))] == [
        "10", "11", "12",
    ]  # fmt: skip
