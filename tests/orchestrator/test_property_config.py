"""Configs made up and configs spoilt: a run or a report, whatever they say."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, note
from hypothesis import strategies as st

from sightline.fmus.build import build
from sightline.orchestrator.config.loading import load
from sightline.orchestrator.errors import ConfigError

from .fuzzing import EVERY_EXAMPLE, check_report, invoke, run, toml
from .test_run import BLOCKS

pytestmark = pytest.mark.usefixtures("fmu_cache")
FMUS = ("Integrator", "Gain", "Switch")
OUTPUTS = {"Integrator": ["x"], "Gain": ["y"], "Switch": ["count", "on", "echo"]}
INPUTS = {"Integrator": ["u"], "Gain": ["x"], "Switch": ["count_in", "on_in"]}
SHORT = 3000  # steps times instances, that a test may wait for
Data = dict[str, Any]


@pytest.fixture(scope="session")
def fmus(fmu_cache: None) -> dict[str, bytes]:
    return {n: build(f"{BLOCKS}:{n}", target="native").read_bytes() for n in FMUS}


@pytest.fixture
def folder(fmus: dict[str, bytes], tmp_path: Path) -> Path:
    for name, content in fmus.items():
        (tmp_path / f"{name}.fmu").write_bytes(content)
    (tmp_path / "starts.csv").write_text("x, w\n1, 5\n2, 6\n3, 7\n", encoding="utf-8")
    (tmp_path / "base.toml").write_text(toml(BASE), encoding="utf-8")
    return tmp_path


@pytest.fixture
def fresh(folder: Path) -> Callable[[], tuple[Path, Path]]:
    """The paths of a config and of its results, anew for every example."""
    numbers = iter(range(10**9))

    def paths() -> tuple[Path, Path]:
        return folder / "system.toml", folder / f"out{next(numbers)}"

    return paths


BASE: Data = {
    "connections": ["plant.x -> control.x", "control.y -> plant.u"],
    "simulation": {"stop_time": 1.0, "step": 0.1},
    "instances": {
        "plant": {"fmu": "Integrator.fmu", "start": {"x": 1.0}},
        "control": {"fmu": "Gain.fmu", "parameters": {"k": -0.5}},
    },
}
ROW: Data = {
    "simulation": {"stop_time": 1.0, "step": 0.25, "coupling": "linear"},
    "record": {"signals": ["*.x", "*.y"], "every": 0.5},
    "repeat": {
        "i": {
            "count": 3,
            "neighbours": "open",
            "connections": ["p{i}.x -> g{i}.x", "g{i}.y -> p{i+1}.u"],
            "instances": {
                "p{i}": {"fmu": "Integrator.fmu",
                         "start": {"x": {"file": "starts.csv", "columns": ["x"], "unit": "km"}}},
                "g{i}": {"fmu": "Gain.fmu",
                         "parameters": {"k": {"random": "uniform", "low": -1.0, "high": 0.0,
                                              "seed": 3}}},
            },
        },
    },
    "plots": [{"title": "All", "signals": ["p*.x", "g1.y"], "until": 1.0, "scale": "linear"}],
}  # fmt: skip
DERIVED: Data = {
    "extends": "base.toml",
    "connections": ["clock.echo -> control.x"],
    "simulation": {"algorithm": "adaptive", "tolerance": 1e-3},
    "instances": {"clock": {"fmu": "Switch.fmu", "start": {"on_in": True}, "max_step": 0.05},
                  "plant": {"start": {"x": {"value": 2, "unit": "mm"}}}},
}  # fmt: skip
SEEDS = (BASE, ROW, DERIVED)


# --- what the grammar of a config allows ---------------------------------------------------------

names = st.text("abcXYZ_", min_size=1, max_size=6) | st.sampled_from(["a-b", "_", "Long" * 20])
numbers = st.floats(-1e3, 1e3) | st.integers(-1000, 1000)


@st.composite
def systems(draw: st.DrawFn) -> Data:
    """A config of the right form whose instances, ports and values are there."""
    chosen = draw(st.dictionaries(names, st.sampled_from(FMUS), min_size=1, max_size=4))
    instances = {name: _instance(draw, block) for name, block in chosen.items()}
    outputs = [(f"{n}.{p}", n) for n, block in chosen.items() for p in OUTPUTS[block]]
    inputs = [f"{n}.{p}" for n, block in chosen.items() for p in INPUTS[block]]
    driven = draw(st.lists(st.sampled_from(inputs), unique=True, max_size=4))
    connections = [f"{draw(st.sampled_from(outputs))[0]} -> {d}" for d in driven]
    step = draw(st.sampled_from([0.1, 0.25, 1, 1e-3]))
    start = draw(st.sampled_from([0.0, -1.0, 100]))
    count = draw(st.integers(1, 12))
    simulation = {
        "start_time": start, "stop_time": start + count * step, "step": step,
        **_some(draw, {
            "algorithm": st.sampled_from(["gauss-seidel", "jacobi", "adaptive"]),
            "coupling": st.sampled_from(["hold", "linear", "quadratic"]),
            "tolerance": st.floats(1e-9, 1.0),
            "loop_iterations": st.integers(1, 60),
            "delay": st.lists(st.sampled_from(connections), max_size=1)
            if connections else st.just([]),
        }),
    }  # fmt: skip
    signals = st.lists(
        st.sampled_from([o for o, _ in outputs]) | st.just("*"), min_size=1, max_size=3
    )
    data = {"connections": connections, "simulation": simulation, "instances": instances}
    record = {"signals": signals, "every": st.integers(1, count).map(lambda n: n * step)}
    data |= {"record": _some(draw, record)}
    if draw(st.integers(0, 9)) == 0:  # a figure takes half a second
        more = {"until": st.just(start + step), "scale": st.sampled_from(["linear", "log"]),
                "y": st.text(max_size=5), "file": st.just("mine.svg"),
                "kind": st.sampled_from(["time", "activity"])}  # fmt: skip
        title = draw(st.text(max_size=10))
        data["plots"] = [{"title": title, "signals": draw(signals), **_some(draw, more)}]
    return data


def _instance(draw: st.DrawFn, block: str) -> Data:
    table: Data = {"fmu": f"{block}.fmu"}
    table |= _some(draw, {"every": st.integers(1, 3), "max_step": st.floats(1e-3, 10.0)})
    length = numbers | st.builds(
        lambda v, u: {"value": v, "unit": u}, numbers, st.sampled_from(["m", "km", "mm", "ft"])
    )
    values = {
        "Integrator": {"start": {"x": length, "u": numbers}},
        "Gain": {"start": {"x": length}, "parameters": {"k": numbers, "limit": length}},
        "Switch": {"start": {"count_in": st.integers(-9, 9), "on_in": st.booleans()}},
    }[block]
    return table | {k: _some(draw, ports) for k, ports in values.items()}


def _some(draw: st.DrawFn, choices: dict[str, st.SearchStrategy[Any]]) -> Data:
    return {k: draw(s) for k, s in choices.items() if draw(st.booleans())}


@given(systems())
@EVERY_EXAMPLE
def test_config_of_the_right_form_runs_or_is_refused(fresh, data: Data) -> None:
    config, out = fresh()
    config.write_text(toml(data), encoding="utf-8")
    note(config.read_text(encoding="utf-8"))
    done = run(config, out)
    note(done.output)


# --- what can be wrong with a value --------------------------------------------------------------

DEEP: Any = []
for _ in range(80):
    DEEP = [DEEP]
TEXTS = ["", "\0", "x" * 5000, "../x", "/", ".", "~", "{i}", "{i+99999999999999999999}", "{j}",
         "*", "[", "a[1]", "a.x -> b.x", "plant.x -> control.x", "plant.x[1] -> control.x",
         "plant.x -> plant.x[", "system.toml", "base.toml", "gone.fmu", "starts.csv", "\ud7ff",
         "time", "km", "nan", "[bold]x[/]", "[/]", "\u202e", "a\nb", "/dev/zero", "%s", "{}",
         "blocks.py:Gone", "FreeRigidBdy", "m" * 500, "m**m", "10**10**10", "1/0"]  # fmt: skip
VALUES: list[Any] = [
    True, False, 0, 1, -1, 3, 2**31, 2**63, -2**63 - 1, 2**64, 10**400, 10**5000, 1.5, -0.0,
    1e308, -1e308, 5e-324, 1e-320, float("nan"), float("inf"), float("-inf"), *TEXTS, [], {}, [[]],
    [1, 2], [1, [2]], [1.0, 2.0, 3.0], ["*", 1], [{}], DEEP, {"": 1}, {"x": {"x": {"x": 1}}},
    {"value": 1, "unit": "m"}, {"value": [1, "a"], "unit": "m"}, {"value": 10**400, "unit": "km"},
    {"value": 1, "unit": "K" * 50}, {"value": 1, "unit": ""}, {"value": {}, "unit": "km"},
    {"value": 1, "unit": "m^99999999"}, {"value": 1, "unit": "m\0"}, {"value": 1, "unit": "**"},
    {"each": [1, 2, 3]}, {"each": [10**400, {}, []]}, {"first": 1, "step": 10**400},
    {"first": 1e308, "step": 1e308}, {"random": "uniform", "low": 1e308, "high": -1e308, "seed": 1},
    {"random": "normal", "mean": [[1]], "sigma": [[2]], "seed": 10**400},
    {"random": [], "seed": 1}, {"random": "attitude", "seed": True}, {"random": {}, "seed": 1},
    {"file": "starts.csv"}, {"file": "starts.csv", "columns": 1},
    {"file": "starts.csv", "columns": [[]]}, {"file": "/dev/zero"}, {"file": "\0"}, {"file": 1},
    {"file": "."}, {"file": "Gain.fmu"}, {"file": "starts.csv", "columns": []},
]  # fmt: skip
KEYS = ["", "\0", "x", "time", "a.b", "a/b", "../a", "é", "extends", "simulation", "instances",
        "repeat", "plots", "record", "fmu", "component", "start", "every", "isolate", "p{i}", "p2",
        "[1]", "connections", "count", "unit", "[bold]", "config", "frames", "structure"]


def places(data: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """The paths of all keys and elements."""
    items = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in list(items):
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


def at(data: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        data = data[key]
    return data


@st.composite
def spoilt(draw: st.DrawFn) -> Data:
    """A sound config with one to three of its keys or values changed."""
    data = copy.deepcopy(draw(st.sampled_from(SEEDS)))
    for _ in range(draw(st.integers(1, 3))):
        found = list(places(data))
        if not found:
            break
        path = draw(st.sampled_from(found))
        holder, key = at(data, path[:-1]), path[-1]
        match draw(st.sampled_from(["value", "value", "delete", "rename", "add", "copy"])):
            case "value":
                holder[key] = copy.deepcopy(draw(st.sampled_from(VALUES)))
            case "delete":
                del holder[key]
            case "rename" if isinstance(holder, dict):
                holder[draw(st.sampled_from(KEYS))] = holder.pop(key)
            case "copy":
                other = copy.deepcopy(at(data, draw(st.sampled_from(found))))
                holder[key] = other
            case _ if isinstance(holder, dict):
                holder[draw(st.sampled_from(KEYS))] = copy.deepcopy(draw(st.sampled_from(VALUES)))
            case _:
                holder.append(copy.deepcopy(draw(st.sampled_from(VALUES))))
    return data


@given(spoilt())
@EVERY_EXAMPLE
def test_config_with_wrong_values_runs_or_is_refused(fresh, data: Data) -> None:
    config, out = fresh()
    config.write_text(toml(data), encoding="utf-8", newline="")
    note(config.read_text(encoding="utf-8")[:3000])
    explain_or_run(config, out)


def explain_or_run(config: Path, out: Path) -> None:
    """Run a config if it can be run in a moment; else see that it can be explained."""
    explained = invoke("explain", config)
    if explained.exit_code == 2:
        check_report(explained.stderr, config.parent)
    if explained.exit_code == 0 and _short(config):
        run(config, out)


def _short(config: Path) -> bool:
    try:
        found = load(config)[0].config
    except ConfigError:
        return False
    parts = sum(1 + found.simulation.step / (i.max_step or found.simulation.step)
                for i in found.instances.values())  # fmt: skip
    return found.simulation.steps * parts < SHORT and not found.simulation.adaptive


# --- what can be wrong with a text ---------------------------------------------------------------

PIECES = [b"", b"\0", b"\xff", b"\xef\xbb\xbf", b"\r\n", b"\r", b"[", b"]", b"[[", b"]]", b"{",
          b"}", b'"', b"'", b'"""', b"=", b".", b",", b"#", b"-", b"nan", b"inf", b"0x", b"1e999",
          b"1979-05-27T07:32:00Z", b"07:32:00", b"[" * 3000, b"x." * 3000, b"9" * 5000,
          b"a=" + b"[" * 400 + b"]" * 400, b"{" * 400, b"\\u0000", b" ", b"\t", b"i", b"{i+1}",
          b"a" * 70000, b"[x]\n", b"[simulation]\n", b"\xe2\x80\xae", b"\xed\xa0\x80"]  # fmt: skip
EXAMPLES = Path(__file__).parents[2] / "examples" / "los_formation"
WRITTEN = [toml(d).encode() for d in SEEDS]


@st.composite
def garbled(draw: st.DrawFn) -> bytes:
    """The text of a sound config with some bytes or lines taken out, put in or exchanged."""
    text = draw(st.sampled_from(WRITTEN))
    for _ in range(draw(st.integers(1, 3))):
        lines = text.splitlines(keepends=True)
        first = draw(st.integers(0, max(0, len(text))))
        last = min(len(text), first + draw(st.integers(0, 12)))
        match draw(st.sampled_from(["bytes", "piece", "line", "twice", "end"])):
            case "bytes":
                text = text[:first] + draw(st.binary(max_size=4)) + text[last:]
            case "piece":
                text = text[:first] + draw(st.sampled_from(PIECES)) + text[last:]
            case "line" if lines:
                del lines[draw(st.integers(0, len(lines) - 1))]
                text = b"".join(lines)
            case "twice" if lines:
                line = lines[draw(st.integers(0, len(lines) - 1))]
                lines.insert(draw(st.integers(0, len(lines))), line)
                text = b"".join(lines)
            case _:
                text = text[:first]
    return text


@given(garbled())
@EVERY_EXAMPLE
def test_garbled_config_runs_or_is_refused(fresh, text: bytes) -> None:
    config, out = fresh()
    config.write_bytes(text)
    note(repr(text[:3000]))
    explain_or_run(config, out)


# --- several mistakes at once --------------------------------------------------------------------

SOUND = """\
connections = [
  "plant.x -> control.x",
  "control.y -> plant.u",
]
[simulation]
stop_time = 1.0
step = 0.1
[instances.plant]
fmu = "Integrator.fmu"
[instances.plant.start]
x = 1.0
[instances.control]
fmu = "Gain.fmu"
[instances.control.parameters]
k = -0.5
[instances.switch]
fmu = "Switch.fmu"
[instances.switch.start]
count_in = 1
[record]
every = 0.2
"""
MISTAKES = {  # a line, what to write below it, and what must be said of the new line
    "connections = [": [
        ('  "plant.z -> control.x",', "plant (Integrator) has no port z; its outputs: x"),
        ('  "plant.x",', "is not of the form a.x -> b.y"),
        ('  "gone.x -> control.x",', "there is no instance gone"),
        ('  "plant.x -> plant.u",', "plant.x is in m, plant.u needs m/s (m.s-1)"),
        ('  "switch.on -> control.x",', "switch.on is boolean, control.x needs real"),
        ('  "plant.u -> control.x",', "plant.u is an input, not an output"),
        ('  "plant.x -> control.y",', "control.y is an output, not an input"),
        ('  "plant.x[2] -> control.x",', "plant.x[2] does not exist; x is a scalar"),
    ],
    "[simulation]": [
        ('algorithm = "euler"', "simulation.algorithm: 'euler' is not supported"),
        ("stpe = 0.1", "simulation.stpe: unknown key; did you mean step?"),
        ("start_time = nan", "simulation.start_time: input should be a finite number"),
    ],
    'fmu = "Integrator.fmu"': [
        ("every = 0", "instances.plant.every: input should be greater than or equal to 1"),
        ("time_limit = 1.0", "instances.plant.time_limit: can be kept by an isolated FMU only"),
        ('target = "native"', "instances.plant.target: is a choice of building, but an fmu"),
    ],
    "[instances.plant.start]": [
        ("u = [1.0, 2.0]", "instances.plant.start.u: has the shape 2, u needs a single value"),
        ("v = 1.0", "instances.plant.start.v: Integrator has no start value of this name"),
    ],
    "[instances.control.parameters]": [
        ('limit = { value = 1, unit = "s" }', "limit: is given in s (s), limit is in m"),
        ("gain = 1.0", "instances.control.parameters.gain: Gain has no parameter of this name"),
    ],
    "[instances.switch.start]": [
        ("on_in = 1", "instances.switch.start.on_in: on_in is 1, not a boolean"),
    ],
    "[record]": [
        ("signals = [3]", "record.signals.0: input should be a valid string, found 3"),
        ("evry = 1", "record.evry: unknown key; did you mean every?"),
    ],
}  # fmt: skip
ALL_MISTAKES = [(after, *m) for after, mistakes in MISTAKES.items() for m in mistakes]


@given(st.lists(st.sampled_from(ALL_MISTAKES), min_size=1, max_size=8, unique_by=lambda m: m[1]))
@EVERY_EXAMPLE
def test_every_mistake_is_told_with_its_line(fresh, chosen: list[tuple[str, str, str]]) -> None:
    lines = SOUND.splitlines()
    for after, wrong, _ in chosen:
        lines.insert(lines.index(after) + 1, wrong)
    config, _ = fresh()
    config.write_text("\n".join(lines), encoding="utf-8")
    note(config.read_text(encoding="utf-8"))
    done = invoke("explain", config)
    note(done.stderr)
    assert done.exit_code == 2
    told = done.stderr.splitlines()[1:]
    for _, wrong, message in chosen:
        place = f"{config}:{lines.index(wrong) + 1}: "
        assert any(place in t and message in t for t in told), wrong


# --- the examples --------------------------------------------------------------------------------

EXAMPLE = re.sub(
    rb'component = "(\w+)"', rb'fmu = "\1.fmu"', (EXAMPLES / "system.toml").read_bytes()
)  # of FMUs that are there: building is not tried here


@st.composite
def garbled_examples(draw: st.DrawFn) -> bytes:
    """The first example, some lines taken out, exchanged or with other values in them."""
    lines = EXAMPLE.splitlines()
    for _ in range(draw(st.integers(1, 5))):
        number = draw(st.integers(0, len(lines) - 1))
        key, equals, _ = lines[number].partition(b" = ")
        match draw(st.sampled_from(["value", "value", "line", "twice", "swap", "piece"])):
            case "value" if equals:
                lines[number] = key + equals + VALUES_AS_TEXT[draw(WHICH_VALUE)]
            case "line" if len(lines) > 1:
                del lines[number]
            case "twice":
                lines.insert(draw(st.integers(0, len(lines))), lines[number])
            case "swap":
                other = draw(st.integers(0, len(lines) - 1))
                lines[number], lines[other] = lines[other], lines[number]
            case _:
                lines[number] += draw(st.sampled_from(PIECES))
    return b"\n".join(lines)


@pytest.fixture(scope="module")
def formation(fmu_cache: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the FMUs of the example."""
    folder = tmp_path_factory.mktemp("formation")
    for name in sorted({n.decode() for n in re.findall(rb'"(\w+)\.fmu"', EXAMPLE)}):
        build(name, target="native", out=folder)
    return folder


VALUES_AS_TEXT = [toml({"x": v}).partition(" = ")[2].strip().encode() for v in VALUES
                  if not isinstance(v, dict) and v != [{}]]  # fmt: skip
WHICH_VALUE = st.integers(0, len(VALUES_AS_TEXT) - 1)


@given(garbled_examples())
@EVERY_EXAMPLE
def test_garbled_example_is_explained_or_refused(formation: Path, text: bytes) -> None:
    config = formation / "system.toml"
    config.write_bytes(text)
    note(repr(text))
    done = invoke("explain", config)
    if done.exit_code == 2:
        check_report(done.stderr, formation)
