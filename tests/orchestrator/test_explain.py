"""What explain says of order, timing, units and frames, and the picture's layout."""

from __future__ import annotations

import itertools
from pathlib import Path
from xml.etree import ElementTree

import pytest

from sightline.orchestrator.alike import few
from sightline.orchestrator.explain.explanation import explain
from sightline.orchestrator.explain.groups import groups_of, links_of
from sightline.orchestrator.explain.layout import PAGE, Box, Layout
from sightline.orchestrator.explain.picture import draw
from sightline.orchestrator.explain.text import text
from sightline.orchestrator.system import System

from .conftest import SIMULATION, variable

LOOP = ["plant.x -> sensor.x", "sensor.y -> control.y", "control.u -> plant.u"]
BODY = 'fmu = "{}.fmu"\nframes = {{ body = "craft" }}'


@pytest.fixture(autouse=True)
def blocks(make_fmu) -> None:
    make_fmu("plant", [
        variable("x", "output", unit="km"), variable("u", start="0"), variable("w", start="0"),
    ], {"x": []})  # fmt: skip
    make_fmu("sensor", [
        variable("y", "output", frame="body"), variable("x", unit="m", start="0"),
        variable("sample_period", "parameter", start="0.2"),
    ], {"y": ["x"]})  # fmt: skip
    make_fmu("control", [
        variable("u", "output"), variable("y", start="0", frame="body"),
    ], {"u": ["y"]})  # fmt: skip


@pytest.fixture
def system(write):
    def made(algorithm: str = "gauss-seidel", coupling: str = "hold") -> System:
        simulation = f'{SIMULATION}algorithm = "{algorithm}"\ncoupling = "{coupling}"\n'
        instances = {"control": BODY.format("control"), "plant": 'fmu = "plant.fmu"',
                     "sensor": BODY.format("sensor")}  # fmt: skip
        return System.from_toml(write(LOOP, simulation=simulation, **instances))

    return made


def test_inputs_that_may_be_extrapolated_are_not_said_to_be_held(system) -> None:
    told = text(explain(system(coupling="linear")))
    assert "carries the value of the step's start (it acts on states only)" in told
    assert "held over the step" not in told


def test_text_says_everything(system) -> None:
    assert text(explain(system())) == """\
system     3 instances, 3 connections of 3 values
time       0 to 1 s, communication step 0.1 s
algorithm  gauss-seidel, coupling hold
recorded   3 signals of 3 values every 0.1 s

order of stepping:
  1  plant    plant    FMI 2.0
  2  sensor   sensor   FMI 2.0  samples every 0.2 s
  3  control  control  FMI 2.0

2 connections carry the value of the same instant:
  plant.x -> sensor.x
  sensor.y -> control.y

1 connection carries the value of the step's start, held over the step (it acts on states only):
  control.u -> plant.u

algebraic loops:
  none

unit conversions:
  plant.x -> sensor.x: km to m, times 1000

inputs that nothing drives, kept at their start values:
  plant: w

frames:
  craft: control (body), sensor (body)
"""


def test_jacobi_is_late_where_outputs_depend_at_once(system) -> None:
    explanation = explain(system("jacobi"))
    assert [str(c) for c in explanation.of("late")] == LOOP[:2]
    assert [str(c) for c in explanation.of("held")] == LOOP[2:]


def test_loops_say_how_they_are_solved_or_broken(write, make_fmu) -> None:
    make_fmu("gain", [variable("y", "output"), variable("x", start="0")], {"y": ["x"]})
    body, loop = 'fmu = "gain.fmu"', ["a.y -> b.x", "b.y -> a.x"]
    solved = System.from_toml(write(loop, a=body, b=body))
    assert explain(solved).loops == (
        "a, b: solved at every step by Anderson's acceleration to 1e-09, in at most 50 iterations",
    )
    late = System.from_toml(
        write(loop, a=body, b=body, simulation=f'{SIMULATION}delay = ["b.y -> a.x"]\n')
    )
    assert explain(late).loops == ("b.y -> a.x: one step late, as the configuration allows",)
    assert [str(c) for c in explain(late).of("late")] == ["b.y -> a.x"]


def test_rates_are_told(write) -> None:
    plant = 'fmu = "plant.fmu"\nevery = 2'
    system = System.from_toml(write(LOOP[:1], plant=plant, sensor=BODY.format("sensor")))
    assert [s.rate for s in explain(system).steps] == [
        "steps every 0.2 s", "samples every 0.2 s",
    ]  # fmt: skip


def test_many_lines_that_are_alike_are_told_once() -> None:
    rows = [f"craft{i}.x" for i in range(1, 101)]
    assert few(["a", *rows, "b"]) == ["a", "craft1.x", "... 98 alike ...", "craft100.x", "b"]
    assert few(rows[:8]) == rows[:8]


def box(name: str, inputs: str = "", outputs: str = "") -> Box:
    return Box(name, name, name, [(c, c) for c in inputs], [(c, c) for c in outputs])


def test_columns_follow_the_order_and_boxes_do_not_overlap() -> None:
    boxes = [box("a", "", "xy"), box("b", "x", "y"), box("c", "x", "y"), box("d", "xyz")]
    edges = [
        (("a", "x"), ("b", "x")), (("a", "y"), ("c", "x")), (("b", "y"), ("d", "x")),
        (("c", "y"), ("d", "y")), (("a", "x"), ("d", "z")),
    ]  # fmt: skip
    layout = Layout(boxes, edges)
    assert [layout.layer[n] for n in "abcd"] == [0, 1, 1, 2]
    for one, other in itertools.combinations(boxes, 2):
        apart = one.x + one.width < other.x or other.x + other.width < one.x
        above = one.y + one.height < other.y or other.y + other.height < one.y
        assert apart or above


def test_line_that_passes_a_column_crosses_no_box() -> None:
    boxes = [box("a", "", "x"), box("b", "x", "y"), box("c", "xy")]
    edges = [(("a", "x"), ("b", "x")), (("b", "y"), ("c", "x")), (("a", "x"), ("c", "y"))]
    layout = Layout(boxes, edges)
    start, enter, leave, end = layout.lines()[2].points
    middle = layout.boxes["b"]
    assert not middle.y <= enter[1] <= middle.y + middle.height
    assert (enter[0], leave[0]) == (middle.x, middle.x + middle.width)
    assert start == (boxes[0].width, boxes[0].output_y("x"))
    assert end == (layout.boxes["c"].x, layout.boxes["c"].input_y("y"))


def test_a_long_chain_goes_on_in_bands_no_wider_than_a_page() -> None:
    names = [f"block{i}" for i in range(12)]
    boxes = [Box(n, 30 * "n", n, [("u", "u"), ("v", "v")], [("y", "y")]) for n in names]
    edges = [((a, "y"), (b, "u")) for a, b in itertools.pairwise(names)]
    edges.append((("block0", "y"), ("block11", "v")))
    layout = Layout(boxes, edges)
    assert layout.size()[0] <= PAGE
    for one, other in itertools.pairwise(boxes):  # left to right, and on below
        assert other.x > one.x + one.width or other.y > one.y + one.height
    level = [
        (a, b, y) for line in layout.lines()
        for (a, y), (b, _) in list(itertools.pairwise(line.points))[1::2]
    ]  # fmt: skip
    assert sum(b < a for a, b, _ in level) > 1  # back to the left
    for a, b, y in level:
        for each in boxes:
            beside = max(a, b) <= each.x or each.x + each.width <= min(a, b)
            assert beside or not each.y <= y <= each.y + each.height


@pytest.mark.parametrize("suffix", ["svg", "png"])
def test_picture_is_the_same_each_time(system, tmp_path: Path, suffix: str) -> None:
    contents = []
    for name in ("one", "two"):
        path = tmp_path / f"{name}.{suffix}"
        draw(system(), path)
        contents.append(path.read_bytes())
    assert contents[0] == contents[1]


def test_picture_names_instances_ports_and_timing(system, tmp_path: Path) -> None:
    draw(system(), tmp_path / "system.svg")
    root = ElementTree.parse(tmp_path / "system.svg").getroot()
    words = {"".join(e.itertext()).strip() for e in root.iter("{http://www.w3.org/2000/svg}text")}
    assert {"1  plant", "2  sensor", "sensor, samples every 0.2 s", "x", "u ⇠ control.u", "u ⇢",
            "w (start)"} <= words  # fmt: skip


def test_copies_of_a_large_system_are_one_box(write, tmp_path: Path) -> None:
    template = """[repeat.i]
count = 200
connections = [
  "plant{i}.x->sensor{i}.x", "sensor{i+1}.y -> control{i}.y", "control{i}.u -> plant{i}.u",
]
[repeat.i.instances]
"plant{i}" = { fmu = "plant.fmu" }
"sensor{i}" = { fmu = "sensor.fmu" }
"control{i}" = { fmu = "control.fmu" }
"""
    alone = write(["plant7.x -> last.x"], template, last='fmu = "sensor.fmu"')
    system = System.from_toml(alone)
    groups = groups_of(system)
    assert [(g.name, len(g.nodes)) for g in groups] == [
        ("plant{i}", 200), ("sensor{i}", 200), ("control{i}", 200), ("last", 1),
    ]  # fmt: skip
    assert groups[0].heading == "1, 3 … 597  plant1, plant2 … plant200"
    assert {(k.source, k.destination, k.shown, k.forward) for k in links_of(system, groups)} == {
        ("plant{i}", "sensor{i}", "plant{i}.x", True),
        ("sensor{i}", "control{i}", "sensor{i+1}.y", True),
        ("control{i}", "plant{i}", "control{i}.u", False),
        ("plant{i}", "last", "plant7.x", True),
    }
    draw(system, tmp_path / "picture.svg")
    picture = (tmp_path / "picture.svg").read_text(encoding="utf-8")
    for words in ("y of sensor{i+1}", "u ⇠ control{i}.u", "sensor, 200 copies", "x of plant7"):
        assert words in picture
