"""What a run says of its wiring: frames and units not checked, inputs that nothing drives."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from sightline.orchestrator.errors import ConfigError
from sightline.orchestrator.explain.explanation import explain
from sightline.orchestrator.explain.text import text
from sightline.orchestrator.system import System

from .conftest import variable, vector

EXAMPLES = Path(__file__).parents[2] / "examples"
CONFIGS = sorted(EXAMPLES.glob("*/*.toml"))
WHICH = "(sightline explain tells which)"
HERE, THERE = 'frames = { body = "here" }', 'frames = { body = "there" }'


@pytest.fixture(autouse=True)
def blocks(make_fmu) -> None:
    make_fmu("craft", [
        *vector("attitude", 4, "output", unit="1", frame="body"),
        *vector("rate", 3, "output", unit="1", frame="body"),
        *vector("force", 3, unit="N", frame="body", start="0"),
        *vector("disturbance", 3, unit="N", frame="body", start="0", optional=True),
    ], {})  # fmt: skip
    make_fmu("group", [
        *(variable(f"rates[{i},{j}]", unit="1", frame="each_body", start="0")
          for i in (1, 2) for j in (1, 2, 3)),
        variable("mean", "output"),
    ], {})  # fmt: skip
    make_fmu("foreign", [
        *vector("rate", 3, start="0.0"), variable("other", start="2"),
        *vector("force", 3, "output"),
    ], {"force[1]": ["rate[1]"]})  # fmt: skip


def craft(rest: str = HERE) -> str:
    return f'fmu = "craft.fmu"\n{rest}'


def section(system: System, title: str) -> list[str]:
    lines = text(explain(system)).partition(f"\n{title}:\n")[2].partition("\n\n")[0]
    return [line.strip() for line in lines.splitlines()]


@pytest.mark.parametrize("path", CONFIGS, ids=lambda p: f"{p.parent.name}-{p.stem}")
def test_example_checks_every_frame_and_forgets_no_input(path: Path) -> None:
    graph = System.from_toml(path).graph
    assert [n for n in graph.notes if "not checked" in n] == []
    assert graph.warnings == ()
    assert len(graph.notes) <= 10


@pytest.mark.parametrize(
    ("right", "wrong", "reason"),
    [
        ("craft1.attitude -> los12.attitude", "craft2.attitude -> los12.attitude",
         "craft2.attitude is of the frame craft2 (its body), los12.attitude needs craft1 "
         "(its body)"),
        ("craft2.attitude -> monitor.target_attitude", "craft1.attitude -> monitor.target_attitude",
         "craft1.attitude is of the frame craft1 (its body), monitor.target_attitude needs craft2 "
         "(its target_body)"),
    ],
)  # fmt: skip
def test_attitude_of_the_other_craft_is_refused(right: str, wrong: str, reason: str) -> None:
    data = tomllib.loads((EXAMPLES / "los_formation" / "system.toml").read_text("utf-8"))
    data["connections"] = [wrong if c == right else c for c in data["connections"]]
    with pytest.raises(ConfigError) as caught:
        System.from_data(data)
    (problem,) = caught.value.problems
    assert str(problem).endswith(
        f'connection "{wrong}": {reason}; connect ports of one frame, or correct frames = {{...}}'
    )


def test_neighbour_of_the_other_row_is_refused() -> None:
    path = EXAMPLES / "consensus_ring" / "system.toml"
    data = tomllib.loads(path.read_text("utf-8").replace(
        '"craft{i-1}.attitude -> control{i}.neighbour_attitudes[1]"',
        '"craft{i+1}.attitude -> control{i}.neighbour_attitudes[1]"',
    ))  # fmt: skip
    with pytest.raises(ConfigError) as caught:
        System.from_data(data)
    assert (
        "craft2.attitude is of the frame craft2 (its body), control1.neighbour_attitudes[1] needs "
        "craft10 (its neighbour_body)"
    ) in str(caught.value)


def test_each_row_has_a_frame_of_its_own(write, problems) -> None:
    group = 'fmu = "group.fmu"\nframes = { each_body = ["here", "there"] }'
    right = ["a.rate -> g.rates[1]", "b.rate -> g.rates[2]"]
    system = System.from_toml(write(right, a=craft(HERE), b=craft(THERE), g=group))
    assert section(system, "frames") == [
        "here: a (body), g (each_body)", "there: b (body), g (each_body)",
    ]  # fmt: skip
    wrong = write(["a.rate -> g.rates[2]"], a=craft(HERE), g=group)
    assert problems(wrong) == [
        'system.toml:2: connection "a.rate -> g.rates[2]": a.rate is of the frame here (its '
        "body), g.rates[2] needs there (its each_body); connect ports of one frame, or correct "
        "frames = {...}"
    ]


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        ('each_body = ["a", "b", "c"]',
         "3 frames, but rates has 2 rows; name one frame for each row, or one for all"),
        ("each_body = 1", "input should be a name or a list of names, found 1"),
        ("each_body = []", "input should be a name or a list of names"),
        ('each_body = ["a", 2]', "input should be a name or a list of names"),
    ],
)  # fmt: skip
def test_frames_that_do_not_fit_are_refused(write, problems, frames: str, message: str) -> None:
    path = write(g=f'fmu = "group.fmu"\nframes = {{ {frames} }}')
    assert problems(path) == [f"system.toml:9: instances.g.frames.each_body: {message}"]


def test_list_of_frames_needs_rows(write, problems) -> None:
    assert problems(write(a=craft('frames = { body = ["a", "b", "c"] }'))) == [
        "system.toml:9: instances.a.frames.body: 3 frames, but attitude has no rows; "
        "name one frame for each row, or one for all"
    ]


def test_role_that_is_not_bound_is_noted(write) -> None:
    group = 'fmu = "group.fmu"\nframes = { each_body = "here" }'
    connections = ["a.rate -> g.rates[1]", "b.rate -> g.rates[2]"]
    system = System.from_toml(write(connections, a=craft(""), b=craft(), g=group))
    assert system.graph.notes[0] == (
        f"frames of 1 connection are not checked: bind roles with frames = {{...}} {WHICH}"
    )
    assert section(system, "connections whose frames are not checked") == [
        "a.rate -> g.rates[1]: a does not bind body"
    ]


def test_fmu_that_declares_neither_units_nor_frames_is_noted(write) -> None:
    foreign = 'fmu = "foreign.fmu"\nstart = { other = 1.0 }'
    connections = [f"a.rate -> {f}.rate" for f in ("f", "g")] + ["f.force -> a.force"]
    system = System.from_toml(write(connections, a=craft(), f=foreign, g=foreign))
    assert system.graph.notes[0] == (
        f"frames of 3 and units of 3 connections are not checked: f and 1 more declare none {WHICH}"
    )
    told = [
        "a.rate -> f.rate: f.rate declares none", "a.rate -> g.rate: g.rate declares none",
        "f.force -> a.force: f.force declares none",
    ]  # fmt: skip
    assert section(system, "connections whose frames are not checked") == told
    assert section(system, "connections whose units are not checked") == told


def test_nothing_is_noted_where_all_is_checked_or_neither_end_declares(write) -> None:
    group = 'fmu = "group.fmu"\nframes = { each_body = "here" }'
    connections = ["a.rate -> g.rates[1]", "f.force -> h.rate"]
    foreign = 'fmu = "foreign.fmu"'
    path = write(connections, a=craft(), g=group, f=foreign, h=foreign)
    assert not any("not checked" in note for note in System.from_toml(path).graph.notes)


def test_required_inputs_that_nothing_drives_are_warned_of_one_by_one(write) -> None:
    connections = ["a.rate[1] -> f.rate[2]"]
    system = System.from_toml(write(connections, a=craft(), f='fmu = "foreign.fmu"'))
    assert system.graph.warnings == (
        "nothing drives a.force; it stays at its start value [0, 0, 0] N",
        "nothing drives f.rate[1], rate[3]; they stay at their start values",
        "nothing drives f.other; it stays at its start value 2",
    )


def test_optional_and_given_inputs_are_summed_up_in_one_note(write) -> None:
    given = f"{HERE}\nstart = {{ force = [1, 2, 3] }}"
    graph = System.from_toml(write(a=craft(given), b=craft(given))).graph
    assert graph.warnings == ()
    assert graph.notes == (
        f"nothing drives 4 inputs that are optional or given a start value {WHICH}",
    )


def test_explain_lists_undriven_inputs_and_marks_what_is_meant(write) -> None:
    given = f"{HERE}\nstart = {{ force = [1, 2, 3] }}"
    system = System.from_toml(write(a=craft(given), b=craft()))
    assert section(system, "inputs that nothing drives, kept at their start values") == [
        "a: force (start value given), disturbance (optional)", "b: force, disturbance (optional)",
    ]  # fmt: skip
