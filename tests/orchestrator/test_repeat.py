"""Templates: copies, neighbours, values per copy, and problems with the template's line."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sightline.orchestrator.config import toml_text
from sightline.orchestrator.config.loading import check, load
from sightline.orchestrator.config.spread import Refused, spread
from sightline.orchestrator.system import System

from .conftest import SIMULATION, variable
from .test_run import BLOCKS

TEMPLATE = """
[repeat.i]
count = {count}
{more}
connections = [
  "craft{{i}}.y -> craft{{i+1}}.u[1]",
  "craft{{i}}.y -> craft{{i-1}}.u[2]",
]
[repeat.i.instances."craft{{i}}"]
fmu = "craft.fmu"
{table}
"""


@pytest.fixture(autouse=True)
def craft(make_fmu) -> Path:
    return make_fmu("craft", [
        variable("y", "output"), variable("u[1]", start="0"), variable("u[2]", start="0"),
        variable("mass", "parameter", start="1"),
        variable("seed", "parameter", "Integer", start="1"),
    ], {"y": []})  # fmt: skip


@pytest.fixture
def ring(tmp_path: Path) -> Callable[..., Path]:
    def write(count: int = 4, more: str = "", table: str = "", rest: str = "") -> Path:
        path = tmp_path / "system.toml"
        text = SIMULATION + TEMPLATE.format(count=count, more=more, table=table) + rest
        path.write_text(text, encoding="utf-8")
        return path

    return write


def test_ring_closes(ring) -> None:
    system = System.from_toml(ring(3))
    assert [n.name for n in system.graph.nodes] == ["craft1", "craft2", "craft3"]
    assert [str(c) for c in system.graph.connections] == [
        "craft1.y -> craft2.u[1]", "craft1.y -> craft3.u[2]",
        "craft2.y -> craft3.u[1]", "craft2.y -> craft1.u[2]",
        "craft3.y -> craft1.u[1]", "craft3.y -> craft2.u[2]",
    ]  # fmt: skip


def test_open_row_ends(ring) -> None:
    system = System.from_toml(ring(3, 'neighbours = "open"'))
    assert [str(c) for c in system.graph.connections] == [
        "craft1.y -> craft2.u[1]", "craft2.y -> craft3.u[1]", "craft2.y -> craft1.u[2]",
        "craft3.y -> craft2.u[2]",
    ]  # fmt: skip
    assert system.graph.warnings == (
        "nothing drives craft1.u[1]; it stays at its start value",
        "nothing drives craft3.u[2]; it stays at its start value",
    )


def test_count_is_set_from_outside(ring) -> None:
    system = System.from_toml(ring(), {"repeat.i": 50, "simulation.stop_time": 2.0})
    assert len(system.graph.nodes) == 50
    assert system.loaded.config.simulation.steps == 20
    written = tomllib.loads(system.loaded.text)
    assert written["repeat"]["i"]["count"] == 50
    assert list(written["repeat"]["i"]["instances"]) == ["craft{i}"]


def test_thousand_copies_are_read_and_checked_in_seconds(ring) -> None:
    system = System.from_toml(ring(1000))
    assert len(system.graph.connections) == 2000


def test_table_of_its_own_overlays_a_copy(ring) -> None:
    path = ring(table="parameters = { mass = 2.0, seed = 3 }",
                rest="[instances.craft2]\nparameters = { mass = 5.0 }")
    instances = System.from_toml(path, {"craft3.mass": 7}).loaded.config.instances
    assert [i.parameters["mass"] for i in instances.values()] == [2.0, 5.0, 7, 2.0]
    assert {i.parameters["seed"] for i in instances.values()} == {3}


def test_extending_config_changes_the_count_and_one_driver(ring, tmp_path: Path) -> None:
    ring()
    derived = tmp_path / "more.toml"
    derived.write_text(
        'extends = "system.toml"\n[repeat.i]\ncount = 5\n'
        'connections = ["craft{i}.y -> craft{i-1}.u[2]"]', encoding="utf-8"
    )  # fmt: skip
    system = System.from_toml(derived)
    assert (len(system.graph.nodes), len(system.graph.connections)) == (5, 10)


def test_index_stands_in_every_text_of_an_instance(ring) -> None:
    path = ring(table='frames = { body = "craft{i}", other = ["craft{i-1}", "craft{i+1}"] }')
    loaded, _ = load(path)
    frames = loaded.config.instances["craft3"].frames
    assert frames == {"body": "craft3", "other": ("craft2", "craft4")}


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("parameters = { mas = 1 }",
         "instances.craft1.parameters.mas: craft has no parameter of this name (the first of 4 "
         "alike); did you mean mass?"),
        ("satrt = {}",
         "instances.craft1.satrt: unknown key (the first of 4 alike); did you mean start or "
         "structure or target?"),
        ("parameters = { mass = { each = [1, 2] } }",
         "repeat.i.instances.craft{i}.parameters.mass: each needs 4 values, one per copy; found 2"),
    ],
)  # fmt: skip
def test_problem_of_a_template_is_one_and_has_its_line(
    ring, problems, table: str, message: str
) -> None:
    assert problems(ring(table=table)) == [f"system.toml:14: {message}"]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('"craft{i}.y -> craft{i+1}.u[1]"', '"craft{i}.y -> craft{i+1}.w"',
         'system.toml:9: connection "craft1.y -> craft2.w": craft2 (craft) has no port w '
         "(the first of 4 alike); its inputs: u"),
        ('"craft{i}.y -> craft{i+1}.u[1]"', '"craft1.y -> craft2.u[1]"',
         "system.toml:9: repeat.i.connections.craft1.y -> craft2.u[1]: is the same for every "
         "copy; put {i} into it, or take it out of the template"),
        ('"craft{i}.y -> craft{i+1}.u[1]"', '"craft{i}.y -> craft{j}.u[1]"',
         "system.toml:9: repeat.i.connections.craft{i}.y -> craft{j}.u[1]: {j} is not the index "
         "of this template; {i} is"),
        ("count = 4", "count = 0",
         "system.toml:6: repeat.i.count: input should be greater than or equal to 1, found 0"),
        ("count = 4", "cout = 4", "system.toml:6: repeat.i.cout: unknown key; did you mean count?"),
        ("[repeat.i]", "[repeat.1]",
         "system.toml:5: repeat.1: '1' is not a name; use letters, digits and _"),
    ],
)  # fmt: skip
def test_wrong_template_is_refused(
    ring, problems, old: str, new: str, message: str
) -> None:
    path = ring()
    path.write_text(path.read_text().replace(old, new), encoding="utf-8")
    assert message in problems(path)


def test_two_templates_do_not_name_one_instance(ring, problems) -> None:
    rest = '[repeat.k]\ncount = 2\n[repeat.k.instances."craft{k}"]\nfmu = "craft.fmu"'
    assert problems(ring(rest=rest))[0] == (
        "system.toml:17: repeat.k.instances.craft{k}: craft1 is named by "
        "repeat.i.instances.craft{i} too (the first of 2 alike)"
    )


def test_setting_the_count_of_no_template_is_refused(ring, problems) -> None:
    assert problems(ring(), {"repeat.j": 3}) == [
        "--set repeat.j: nothing repeats over j; indices: i"
    ]


def column(count: int, **rule: Any) -> list[Any]:
    return spread(rule, count, Path("."), "craft{i}.x")


def test_values_by_list_and_by_difference() -> None:
    assert column(2, each=[[1, 2], [3, 4]]) == [[1, 2], [3, 4]]
    assert column(3, first=1, step=1) == [1, 2, 3]
    assert column(3, first=[0.0, 1.0], step=[10.0, 0.0]) == [[0.0, 1.0], [10.0, 1.0], [20.0, 1.0]]


def test_values_from_a_table(tmp_path: Path) -> None:
    (tmp_path / "starts.csv").write_text("x, y, m\n1,2,5\n3,4,6\n5,6,7\n", encoding="utf-8")
    rule = {"file": "starts.csv"}
    assert spread({**rule, "columns": ["x", "y"]}, 2, tmp_path, "") == [[1.0, 2.0], [3.0, 4.0]]
    assert spread({**rule, "columns": ["m"]}, 3, tmp_path, "") == [5.0, 6.0, 7.0]
    assert spread(rule, 1, tmp_path, "") == [[1.0, 2.0, 5.0]]


def test_random_values_do_not_depend_on_the_count() -> None:
    few, many = column(3, random="attitude", seed=1), column(1000, random="attitude", seed=1)
    assert few == many[:3]
    assert column(3, random="attitude", seed=2) != few


def test_random_values_have_their_distribution() -> None:
    # mean and deviation of 4000 draws: within 4 sigma of the estimate, 4/sqrt(4000) = 0.063
    normal = np.array(column(4000, random="normal", mean=[1.0, 2.0], sigma=[1.0, 2.0], seed=1))
    np.testing.assert_allclose(normal.mean(axis=0), [1.0, 2.0], atol=0.063 * 2)
    np.testing.assert_allclose(normal.std(axis=0), [1.0, 2.0], rtol=0.063)
    uniform = np.array(column(4000, random="uniform", low=-1.0, high=3.0, seed=1))
    assert uniform.min() > -1.0
    assert uniform.max() < 3.0
    assert uniform.mean() == pytest.approx(1.0, abs=0.063 * 4 / math.sqrt(12))
    attitude = np.array(column(4000, random="attitude", seed=1))
    np.testing.assert_allclose(np.linalg.norm(attitude, axis=1), 1.0, rtol=1e-15)
    np.testing.assert_allclose(attitude.T @ attitude / 4000, np.eye(4) / 4, atol=0.02)


@pytest.mark.parametrize(
    ("rule", "message"),
    [
        ({"every": 1}, "is a table"),
        ({"first": 1}, "lacks step"),
        ({"first": 1, "step": [1]}, "first and step must be numbers, or arrays of one shape"),
        ({"random": "attitude"}, "lacks seed"),
        ({"random": "cauchy", "seed": 1}, "'cauchy' is not a distribution"),
        ({"random": "normal", "seed": 1}, "normal needs mean and sigma"),
        ({"random": "attitude", "seed": 1.5}, "the seed is 1.5, not an integer"),
        ({"random": "attitude", "seed": 1, "sed": 1}, "has the unknown key sed"),
        ({"file": "none.csv"}, "none.csv cannot be read"),
    ],
)
def test_wrong_rule_is_refused(rule: dict[str, Any], message: str) -> None:
    with pytest.raises(Refused) as caught:
        spread(rule, 2, Path("."), "")
    assert message in caught.value.what


def test_template_reads_back_from_its_text(ring) -> None:
    path = ring(table="parameters = { mass = { first = 1.0, step = 0.5 } }")
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    assert tomllib.loads(toml_text.dump(data)) == data


@pytest.mark.usefixtures("fmu_cache")
def test_ring_of_integrators_agrees_on_the_mean(tmp_path: Path) -> None:
    path = tmp_path / "system.toml"
    path.write_text(f"""
[simulation]
stop_time = 20.0
step = 0.1
[repeat.i]
count = 3
connections = [
  "control{{i}}.y -> craft{{i}}.u",
  "craft{{i}}.x -> control{{i}}.x",
  "craft{{i+1}}.x -> control{{i}}.other",
]
[repeat.i.instances."craft{{i}}"]
component = "{BLOCKS.as_posix()}:Integrator"
target = "python"
start = {{ x = {{ first = 1.0, step = 1.0 }} }}
[repeat.i.instances."control{{i}}"]
component = "{BLOCKS.as_posix()}:Follow"
target = "python"
""", encoding="utf-8")
    results = System.from_toml(path).simulate(tmp_path)
    last = [results[f"craft{i}.x"][-1] for i in (1, 2, 3)]
    np.testing.assert_allclose(last, 2.0, atol=1e-6)  # slowest mode exp(-1.5 · 20 s) = 1e-13


@pytest.mark.parametrize("unit", ["", ', unit = "kg"'])
def test_values_from_a_file_are_in_the_config_that_results_keep(ring, tmp_path, unit) -> None:
    table = tmp_path / "masses.csv"
    table.write_text("mass,other\n1.5,0\n2.5,0\n3.5,0\n4.5,0\n", encoding="utf-8")
    rule = f'{{ file = "masses.csv", columns = "mass"{unit} }}'
    loaded, _ = load(ring(table=f"parameters = {{ mass = {rule} }}"))
    table.unlink()
    kept = tomllib.loads(loaded.text)["repeat"]["i"]["instances"]["craft{i}"]
    assert kept["parameters"]["mass"]["each"] == [1.5, 2.5, 3.5, 4.5]
    again, _ = check(tomllib.loads(loaded.text), tmp_path)
    assert again.config.instances == loaded.config.instances
