"""The form of a config: keys, types, times, base files."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from sightline.orchestrator.config import toml_text
from sightline.orchestrator.config.loading import load
from sightline.orchestrator.errors import ConfigError

from .conftest import variable

BODY = 'fmu = "plant.fmu"'


@pytest.fixture(autouse=True)
def plant(make_fmu):
    return make_fmu("plant", [variable("y", "output"), variable("u", start="0")])


def test_unknown_key_names_the_nearest(write, problems) -> None:
    path = write(a=BODY + "\nstrt = { u = 1 }")
    assert problems(path) == [
        "system.toml:9: instances.a.strt: unknown key; did you mean start or structure or target?"
    ]


def test_problems_of_form_and_of_wiring_come_together(write, problems) -> None:
    path = write(["a.y -> a.w"], "[record]\nevry = 1", a=BODY)
    assert problems(path) == [
        'system.toml:2: connection "a.y -> a.w": a (plant) has no port w; its inputs: u',
        "system.toml:12: record.evry: unknown key; did you mean every?",
    ]


def test_wrong_type_says_what_was_found(write, problems) -> None:
    path = write(simulation='[simulation]\nstop_time = 1.0\nstep = "0.1"\n', a=BODY)
    (problem,) = problems(path)
    assert problem.startswith("system.toml:5: simulation.step: input should be a valid number")
    assert problem.endswith("found '0.1'")


@pytest.mark.parametrize("key", ["stop_time", "step"])
def test_missing_key_is_named(write, problems, key: str) -> None:
    lines = {"stop_time": "stop_time = 1.0", "step": "step = 0.1"}
    del lines[key]
    path = write(simulation="[simulation]\n" + "\n".join(lines.values()) + "\n", a=BODY)
    assert problems(path) == [f"system.toml:3: simulation.{key}: is missing"]


@pytest.mark.parametrize(
    ("key", "value", "supported"),
    [
        ("algorithm", "newton", "'gauss-seidel', 'jacobi' or 'adaptive'"),
        ("coupling", "cubic", "'hold', 'linear' or 'quadratic'"),
    ],
)
def test_unsupported_choice_lists_what_is_supported(
    write, problems, key: str, value: str, supported: str
) -> None:
    text = f'[simulation]\nstop_time = 1.0\nstep = 0.1\n{key} = "{value}"\n'
    assert problems(write(simulation=text, a=BODY)) == [
        f"system.toml:6: simulation.{key}: '{value}' is not supported; supported: {supported}"
    ]


def test_stop_time_off_the_steps_names_the_nearest(write, problems) -> None:
    path = write(simulation="[simulation]\nstop_time = 1.04\nstep = 0.1\n", a=BODY)
    assert problems(path) == [
        "system.toml:4: simulation.stop_time: 1.04 is not a whole number of steps of 0.1 from "
        "the start; nearest: 1"
    ]


def test_stop_time_before_start_time_is_refused(write, problems) -> None:
    text = "[simulation]\nstart_time = 2.0\nstop_time = 1.0\nstep = 0.1\n"
    assert problems(write(simulation=text, a=BODY)) == [
        "system.toml:5: simulation.stop_time: 1 is not after start_time = 2"
    ]


def test_record_interval_off_the_steps_names_the_nearest(write, problems) -> None:
    path = write(rest="[record]\nevery = 0.25", a=BODY)
    assert problems(path) == [
        "system.toml:11: record.every: 0.25 is not a multiple of the step 0.1; nearest: 0.2"
    ]


def test_instance_needs_exactly_one_origin(write, problems) -> None:
    path = write(a=BODY, b="start = {}", c=BODY + '\ncomponent = "FreeRigidBody"')
    assert problems(path) == [
        "system.toml:10: instances.b: has neither of component and fmu; give one of them",
        "system.toml:13: instances.c: has both of component and fmu; give one of them",
    ]


@pytest.mark.parametrize("name", ["time", "config"])
def test_instance_does_not_take_a_name_of_the_results(write, problems, name: str) -> None:
    assert problems(write(**{name: BODY})) == [
        f"system.toml:7: instances.{name}: is the name of something else in the results; rename it"
    ]


def test_text_that_is_no_toml_is_one_problem(tmp_path: Path) -> None:
    path = tmp_path / "system.toml"
    path.write_text("connections = [", encoding="utf-8")
    with pytest.raises(ConfigError, match=r"system\.toml: config: is not TOML: "):
        load(path)


def test_missing_config_names_those_that_are_there(write, tmp_path: Path) -> None:
    write(a=BODY)
    with pytest.raises(ConfigError, match=r"there is no file .*sytem\.toml; did you mean system"):
        load(tmp_path / "sytem.toml")


def test_extending_config_overlays_tables_and_replaces_drivers(write, tmp_path: Path) -> None:
    write(["a.y -> b.u", "b.y -> a.u"], a=BODY, b=BODY, name="base.toml")
    derived = tmp_path / "derived.toml"
    derived.write_text(
        'connections = ["a.y -> a.u"]\nextends = "base.toml"\n[simulation]\nstep = 0.5\n'
        "[instances.b]\nstart = { u = 2.0 }\n",
        encoding="utf-8",
    )
    loaded, found = load(derived)
    assert found == []
    assert loaded.config.connections == ["a.y -> b.u", "a.y -> a.u"]
    assert (loaded.config.simulation.step, loaded.config.simulation.stop_time) == (0.5, 1.0)
    assert loaded.config.instances["b"].start == {"u": 2.0}
    assert loaded.config.instances["b"].fmu == "plant.fmu"


def test_paths_of_a_base_are_seen_from_its_own_folder(write, tmp_path: Path) -> None:
    write(a=BODY, b='component = "mine.py:Mine"', name="base.toml")
    derived = tmp_path / "sub" / "derived.toml"
    derived.parent.mkdir()
    derived.write_text('extends = "../base.toml"', encoding="utf-8")
    loaded, _ = load(derived)
    assert loaded.config.instances["a"].fmu == "../plant.fmu"
    assert loaded.config.instances["b"].component == "../mine.py:Mine"


def test_tables_of_a_base_are_read_from_its_own_folder(write, tmp_path: Path) -> None:
    (tmp_path / "starts.csv").write_text("1\n2\n", encoding="utf-8")
    start = 'start = { u = { file = "starts.csv" } }'
    write(rest=f'[repeat.i]\ncount = 2\n[repeat.i.instances."a{{i}}"]\n{BODY}\n{start}')
    derived = tmp_path / "sub" / "derived.toml"
    derived.parent.mkdir()
    derived.write_text('extends = "../system.toml"', encoding="utf-8")
    loaded, found = load(derived)
    assert found == []
    assert [loaded.config.instances[n].start["u"] for n in ("a1", "a2")] == [1.0, 2.0]


def test_problem_inherited_from_a_base_is_placed_in_the_base(write, tmp_path, problems) -> None:
    write(a=BODY + "\nparameters = { v = 1 }", name="base.toml")
    derived = tmp_path / "derived.toml"
    derived.write_text('extends = "base.toml"\n[instances.a]\nstart = {u = 1}', encoding="utf-8")
    assert problems(derived) == [
        "base.toml:9: instances.a.parameters.v: plant has no parameter of this name; "
        "parameters: there are none"
    ]


def test_file_that_extends_itself_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "system.toml"
    path.write_text('extends = "system.toml"', encoding="utf-8")
    with pytest.raises(ConfigError, match="a file extends itself"):
        load(path)


def test_dumped_toml_reads_back_the_same() -> None:
    data = {
        "connections": ["a.x -> b.y"] * 6,
        "simulation": {"stop_time": 1e-7, "step": 0.1},
        "instances": {"a": {"fmu": "ä.fmu", "start": {"x": [[1.0, 2], [3, 4]], "on": True}}},
        "record": {},
        "plots": [{"title": 'a "b"', "signals": ["*"]}, {"title": "c", "signals": []}],
    }
    assert tomllib.loads(toml_text.dump(data)) == data
