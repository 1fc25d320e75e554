"""Command lines made up from right and wrong arguments, and damaged files: always an answer."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, note
from hypothesis import strategies as st

from sightline.fmus.build import build
from sightline.orchestrator.system import System

from .fuzzing import EVERY_EXAMPLE, invoke, toml
from .test_run import BLOCKS

pytestmark = pytest.mark.usefixtures("fmu_cache")

SYSTEM = {
    "connections": ["plant.x -> control.x", "control.y -> plant.u"],
    "simulation": {"stop_time": 1.0, "step": 0.1},
    "instances": {"plant": {"fmu": "plant.fmu"}, "control": {"fmu": "control.fmu"}},
}


@pytest.fixture(scope="module")
def shelf(fmu_cache: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of sound and of wrong files; ``long.toml`` was run with checkpoints."""
    folder = tmp_path_factory.mktemp("shelf")
    for block, name in (("Integrator", "plant"), ("Gain", "control")):
        built = build(f"{BLOCKS}:{block}", target="native")
        (folder / f"{name}.fmu").write_bytes(built.read_bytes())
    (folder / "good.toml").write_text(toml(SYSTEM), encoding="utf-8")
    System.from_toml(folder / "good.toml").execute(folder / "kept", checkpoint_every=0.5)
    (folder / "spoilt.toml").write_text("[", encoding="utf-8")
    (folder / "empty").touch()
    (folder / "noise").write_bytes(bytes(range(256)) * 40)
    (folder / "folder").mkdir()
    (folder / "loop").symlink_to("loop")
    (folder / "fails.py").write_text("1 / 0", encoding="utf-8")
    return folder


@pytest.fixture
def here(shelf: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(shelf)
    return shelf


# --- arguments -----------------------------------------------------------------------------------

FILES = ["good.toml", "spoilt.toml", "folder", "empty", "noise", "loop", "gone", "gone/gone", "",
         ".", "..", "/dev/null", "-", "--", "kept/results.h5", "kept/checkpoint.h5", "plant.fmu",
         "empty/x", "x" * 300, "[red]", "~"]  # fmt: skip
NUMBERS = ["0", "1", "-1", "0.5", "nan", "inf", "-inf", "1e400", "1e-320", "x", "", "1,2",
           "9" * 5000, "\u0663", "²", "1_0", "0x1", " 1"]  # fmt: skip
TEXTS = ["", "*", "plant.x", "plant.*", "[", "plant.x[1]", "?", "$\\frac{$", "a\nb", "gone",
         "x" * 500, "[/]", "\0", "日本", "%", "{i}"]  # fmt: skip
KEYS = ["plant.x", "plant.u", "control.k", "control.limit", "simulation.step",
        "simulation.algorithm", "simulation.stop_time", "simulation.gone", "record.every",
        "record.signals", "repeat.i",
        "plots.0", "plant", "", ".", "gone.x", "plant.gone", "plant.x.y", "plant.", ".x",
        "simulation.", "plant.x[1]", "connections.x", "instances.plant", "extends.x"]  # fmt: skip
VALUES = [*NUMBERS, "true", '"a"', "'", '"', "[", "[1, 2]", "[" * 2000, "{", "{}", "1\nx = 2",
          '{ value = 1, unit = "km" }', '{ value = 1, unit = "K" }', '{ file = "/dev/zero" }',
          "1979-05-27", "=", "# 1", '"""', '["*"]', '"jacobi"', "1 # one", "{a" + ".a" * 99 + "=1}"]
BLOCK_NAMES = ["RangeSensr", "gone.py:X", f"{BLOCKS}:Gain", f"{BLOCKS}:Gone", str(BLOCKS),
               "fails.py", "good.toml", "x:y", ".py", ":", "folder", "folder.py:",
               *TEXTS]  # fmt: skip

files, texts, numbers = st.sampled_from(FILES), st.sampled_from(TEXTS), st.sampled_from(NUMBERS)
assignments = st.builds(
    "{}{}{}".format, st.sampled_from(KEYS), st.sampled_from(["=", "=", "=", " = ", "==", ""]),
    st.sampled_from(VALUES),
)  # fmt: skip
configs = st.sampled_from(["good.toml"] * 20 + FILES)
results = st.sampled_from(["kept/results.h5"] * 20 + FILES)
outs = st.sampled_from(["out"] * 5 + FILES)


def option(name: str, values: st.SearchStrategy[str]) -> st.SearchStrategy[list[str]]:
    return values.map(lambda value: [name, value])


def flag(*words: str) -> st.SearchStrategy[list[str]]:
    return st.just([*words])


def line(
    command: str, *options: st.SearchStrategy[list[str]], **positional: st.SearchStrategy[str]
) -> st.SearchStrategy[list[str]]:
    """A command with its arguments and up to four options, in any order."""
    arguments = st.tuples(*(p.map(lambda a: [a]) for p in positional.values()))
    chosen = st.lists(st.one_of(*options, flag("--gone"), texts.map(lambda t: [t])), max_size=4)
    usual = st.lists(st.one_of(flag(), *options), max_size=3)
    parts = st.tuples(arguments, usual | usual | chosen)
    return parts.flatmap(lambda p: st.permutations([*p[0], *p[1]])).map(
        lambda words: [command, *(w for part in words for w in part)]
    )


SET = option("--set", assignments)
LINES = st.one_of(
    line("run", SET, SET, flag("--csv"), option("--checkpoint-every", numbers),
         option("--resume", files), option("-o", outs), flag("--out", "out"), config=configs),
    line("run", SET, flag("--out", "out"), config=configs),
    line("explain", SET, option("--graph", files | st.sampled_from(["x.svg", "x.png", "empty/x.svg",
                                                                    "x.xyz"])), config=configs),
    line("plot", option("-s", texts), option("--kind", st.sampled_from(
        ["time", "angle", "trajectory", "activity", ""])), option("--until", numbers),
         option("--title", texts), option("--scale", st.sampled_from(["log", "linear", "x"])),
         option("--out", outs | st.sampled_from(["x.png", "x.svg", "empty/x.pdf"])),
         option("--format", st.sampled_from(["png", "svg", "pdf"])), results=results),
    line("verify", option("--junit", files), option("--only", st.sampled_from(["schema", *TEXTS])),
         option("--reference", files), option("--seed", numbers),
         file=st.sampled_from([f for f in FILES if f != "plant.fmu"])),
    line("build", option("--target", st.sampled_from(["native", "x", ""])),
         option("--fmi", st.sampled_from(["2", "1", "x", "4"])), option("--out", outs),
         option("--platform", st.sampled_from(["amiga", "", ","])),
         option("--structure", assignments), name=st.sampled_from(BLOCK_NAMES)),
    line("info", name=st.sampled_from(BLOCK_NAMES)),
    line("list", texts.map(lambda t: [t])),
    line("demo", option("--out", files), flag("--csv"), setting=st.just("--set=x")),
    st.lists(texts | files | st.sampled_from(["run", "--help", "-h", "plot", "--set"]), max_size=4),
)  # fmt: skip


@given(LINES)
@EVERY_EXAMPLE
def test_any_command_line_gets_an_answer(here: Path, words: list[str]) -> None:
    note(repr(words))
    done = invoke(*words)
    note(done.output)


# --- damaged files -------------------------------------------------------------------------------


@st.composite
def damage(draw: st.DrawFn) -> Callable[[bytes], bytes]:
    """Cuts a file short, or writes over some of its bytes."""
    share = draw(st.floats(0.0, 1.0))
    if draw(st.booleans()):
        return lambda content: content[:int(share * len(content))]
    places = draw(st.lists(st.tuples(st.floats(0.0, 1.0), st.binary(min_size=1, max_size=8)),
                           min_size=1, max_size=6))  # fmt: skip

    def spoil(content: bytes) -> bytes:
        changed = bytearray(content)
        for where, what in places:
            # most of what a file says about itself stands in its first few kilobytes
            first = int(where * min(len(content), 8192 if share < 0.8 else len(content)))
            changed[first:first + len(what)] = what
        return bytes(changed[:len(content)])

    return spoil


@given(damage())
@EVERY_EXAMPLE
def test_damaged_results_are_drawn_or_refused(here: Path, spoil: Callable[[bytes], bytes]) -> None:
    (here / "spoilt.h5").write_bytes(spoil((here / "kept" / "results.h5").read_bytes()))
    done = invoke("plot", "spoilt.h5", "-s", "plant.x", "--out", "spoilt.svg")
    note(done.output)


@given(damage(), st.booleans())
@EVERY_EXAMPLE
def test_damaged_checkpoint_is_taken_or_refused(
    here: Path, spoil: Callable[[bytes], bytes], both: bool
) -> None:
    (here / "again").mkdir(exist_ok=True)
    for name in ("results.h5", "checkpoint.h5"):
        content = (here / "kept" / name).read_bytes()
        changed = spoil(content) if both or name == "checkpoint.h5" else content
        (here / "again" / name).write_bytes(changed)
    resume = os.path.join("again", "checkpoint.h5")
    done = invoke("run", "good.toml", "--out", "resumed", "--resume", resume)
    note(done.output)
