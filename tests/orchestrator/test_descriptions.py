"""Model descriptions that took all memory, gave a traceback or a wrong number: each by its text."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from sightline.fmus.safe_description import description_problems, size_problems
from sightline.fmus.verify.subject import Subject
from sightline.orchestrator.errors import FmuError
from sightline.orchestrator.fmi.archive import read
from sightline.orchestrator.fmi.units import Unit, conversion

from .conftest import variable

SOUND = """<fmiModelDescription fmiVersion="2.0" modelName="Plant">
  <CoSimulation modelIdentifier="plant" fixedInternalStepSize="1e-3"/>
  <UnitDefinitions>
    <Unit name="m"><BaseUnit m="1" factor="2.5" offset="-1"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Ratio"><Real min="0" max="1"/></SimpleType>
    <SimpleType name="Method"><Enumeration><Item name="rk4" value="-1"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="k" valueReference="0"><Real min="-INF" max="3" unit="m"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="4294967295"><Real/></ScalarVariable>
  </ModelVariables>
</fmiModelDescription>"""

ARRAYS = """<fmiModelDescription fmiVersion="3.0" modelName="Plant">
  <ModelVariables>
    <UInt64 name="n" valueReference="1" causality="structuralParameter" start="{n}"/>
    <Float64 name="f" valueReference="2">{dimensions}</Float64>
  </ModelVariables>
</fmiModelDescription>"""


def arrays(dimensions: str, n: str = "3") -> ET.Element:
    return ET.fromstring(ARRAYS.format(dimensions=dimensions, n=n))


def dimension(start: object) -> str:
    return f'<Dimension start="{start}"/>'


def test_sound_description_has_no_problems() -> None:
    assert description_problems(ET.fromstring(SOUND)) == []
    assert description_problems(arrays(dimension(1000) * 2)) == []
    assert description_problems(arrays('<Dimension valueReference="1"/>' + dimension(0))) == []


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        (' modelName="Plant"', "", "modelName is missing"),
        *(('"1e-3"', f'"{step}"', f"CoSimulation: fixedInternalStepSize is '{step}', not a number "
           "above 0") for step in ("abc", "0", "-1", "NaN", "INF")),
        *(('"2.5"', f'"{factor}"', f"unit m: factor is '{factor}', not a finite number but 0")
          for factor in ("0", "-0.0", "NaN", "INF", "abc")),
        ('"-1"/></Unit>', '"INF"/></Unit>', "unit m: offset is 'INF', not a finite number"),
        ('min="0"', 'min="abc"', "type Ratio: min is 'abc', not a number"),
        ('value="-1"', 'value="one"', "type Method: value of the item rk4 is 'one', not a whole "
         "number"),
        (' value="-1"', "", "type Method: value of the item rk4 is missing, not a whole number"),
        ('min="-INF"', 'min="abc"', "k: min is 'abc', not a number"),
        ('max="3"', 'max="3 m"', "k: max is '3 m', not a number"),
        ('name="k" ', "", "variable 1 has no name"),
        ('name="k"', 'name="y"', "y: 2 variables have this name"),
        ('"4294967295"', '"4294967296"', "y: valueReference is '4294967296', not from 0 to "
         "4294967295"),
        ('"0"><Real', '"-1"><Real', "k: valueReference is '-1', not from 0 to 4294967295"),
        (' valueReference="0"', "", "k: valueReference is missing, not from 0 to 4294967295"),
        ('name="y"', 'name="y[1000000000]"', "y[1000000000]: its name has an index above "
         "1,000,000"),
        ('name="y"', f'name="y[{"9" * 60}]"', f"y[{'9' * 60}]: its name has an index above "
         "1,000,000"),
        ('name="y"', f'name="y[1{",1" * 32}]"', f"y[1{',1' * 32}]: has 33 dimensions, at most 32"),
    ],
)  # fmt: skip
def test_problem_names_variable_and_attribute(old: str, new: str, problem: str) -> None:
    assert SOUND.count(old) == 1
    assert description_problems(ET.fromstring(SOUND.replace(old, new))) == [problem]


def test_all_problems_are_told_at_once() -> None:
    text = SOUND.replace('"2.5"', '"0"').replace('max="3"', 'max="x"').replace('"y"', '"k"')
    assert description_problems(ET.fromstring(text)) == [
        "unit m: factor is '0', not a finite number but 0",
        "k: max is 'x', not a number",
        "k: 2 variables have this name",
    ]


def test_alias_has_a_name_of_its_own() -> None:
    assert description_problems(arrays('<Alias name="n"/>')) == ["n: 2 variables have this name"]


@pytest.mark.parametrize(
    ("dimensions", "problem"),
    [
        (dimension(10**9), "f: has 1,000,000,000 values, at most 1,000,000"),
        (dimension(100_000) * 3, "f: has more than 1e+15 values, at most 1,000,000"),
        (dimension(10**30), "f: has more than 1e+15 values, at most 1,000,000"),
        (dimension("9" * 5000), "f: has more than 1e+15 values, at most 1,000,000"),
        (dimension(3) * 50, "f: has 50 dimensions, at most 32"),
        (dimension(-1), "f: size of a Dimension is '-1', not a whole number"),
        (dimension("abc"), "f: size of a Dimension is 'abc', not a whole number"),
        ("<Dimension/>", "f: size of a Dimension is missing, not a whole number"),
    ],
)
def test_size_is_limited(dimensions: str, problem: str) -> None:
    assert description_problems(arrays(dimensions)) == [problem]


def test_size_by_a_structural_parameter_is_limited() -> None:
    assert size_problems(arrays('<Dimension valueReference="1"/>', n="1000001")) == [
        "f: has 1,000,001 values, at most 1,000,000"
    ]


def test_sum_of_sizes_is_limited() -> None:
    aliases = "".join(f'<Alias name="a{i}"/>' for i in range(10))
    assert size_problems(arrays(dimension(1_000_000) + aliases)) == [
        "its variables have 11,000,001 values, at most 10,000,000"
    ]


def test_verification_allocates_no_array_without_measure(tmp_path: Path) -> None:
    text = ARRAYS.format(dimensions=dimension(10**9), n="3")
    (tmp_path / "modelDescription.xml").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="f: has 1,000,000,000 values, at most 1,000,000"):
        Subject(tmp_path / "plant.fmu", tmp_path)


@pytest.mark.parametrize("factors", [(0.0, 1.0), (1.0, 0.0), (1e300, 1e-300), (1e-300, 1e300)])
def test_units_that_leave_nothing_of_a_value_do_not_fit(factors: tuple[float, float]) -> None:
    source, destination = (Unit("x", (0.0, 1.0), factor) for factor in factors)
    assert conversion(source, destination) is None


def test_reader_tells_all_problems_with_the_file(make_fmu) -> None:
    path = make_fmu("plant", [variable("y", min="abc"), variable("y[1000000000]", max="x")])
    with pytest.raises(FmuError) as caught:
        read(path)
    assert str(caught.value) == (
        f"{path} has a modelDescription.xml that cannot be used: y: min is 'abc', not a number; "
        "y[1000000000]: max is 'x', not a number; y[1000000000]: its name has an index above "
        "1,000,000"
    )


def test_indices_with_gaps_are_no_array(make_fmu) -> None:
    path = make_fmu("plant", [variable(f"y[{i},{i}]") for i in (1, 1_000_000)])
    assert set(read(path).ports) == {"y[1,1]", "y[1000000,1000000]"}
