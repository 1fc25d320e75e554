"""Inputs that gave a traceback, a hang, a file elsewhere or a wrong number: each by its text."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from sightline.fmus.errors import BuildError
from sightline.fmus.load import load_block
from sightline.orchestrator.config.loading import load
from sightline.orchestrator.config.model import Config, slug
from sightline.orchestrator.config.parsing import parse
from sightline.orchestrator.config.spread import Refused, spread
from sightline.orchestrator.errors import ConfigError
from sightline.orchestrator.fmi.units import UnitError, unit_of
from sightline.orchestrator.results.file import ResultsWriter, read
from sightline.orchestrator.system import System

from .conftest import variable
from .fuzzing import invoke

BODY = 'fmu = "plant.fmu"'
LONG = "x" * 5000


@pytest.fixture(autouse=True)
def plant(make_fmu: Callable[..., Path]) -> Path:
    return make_fmu("plant", [
        variable("y", "output"), variable("u", start="0"), variable("v", unit="m", start="0"),
        variable("n", kind="Integer", start="0"),
    ])  # fmt: skip


# --- the text ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a = " + "[" * 100_000, "is not TOML: it is nested deeper than 32 levels"),
        ("a" + ".a" * 500 + " = 1", "is not TOML: it is nested deeper than 32 levels"),
        ("[a" + ".a" * 500 + "]", "is not TOML: it is nested deeper than 32 levels"),
        ("a = " + "9" * 5000, "is not TOML: an integer in it has more than 64 bits"),
        ("a.b = [1, 0x" + "f" * 5000 + "]",
         "is not TOML: a.b.1 is an integer of more than 64 bits"),
        ("a = '" + "x" * 16_000_000 + "'", "cannot be read: it has more than 16000000 characters"),
        ("\0", "is not TOML: Invalid statement (at line 1, column 1)"),
    ],
)  # fmt: skip
def test_text_is_refused(tmp_path: Path, text: str, message: str) -> None:
    path = tmp_path / "system.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load(path)
    assert str(caught.value).endswith(f"system.toml: config: {message}")


def test_bytes_that_are_no_text_are_refused(tmp_path: Path) -> None:
    (tmp_path / "system.toml").write_bytes(b"a = '\xff'")
    with pytest.raises(ConfigError, match="cannot be read: 'utf-8' codec can't decode byte 0xff"):
        load(tmp_path / "system.toml")


def test_mark_of_the_encoding_and_line_ends_of_windows_are_read(write) -> None:
    path = write(a=BODY)
    text = path.read_text(encoding="utf-8")
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert load(path)[1] == []


def test_integers_of_64_bits_are_read() -> None:
    assert parse(f"a = [{-2**63}, {2**63 - 1}]") == {"a": [-(2**63), 2**63 - 1]}


def test_config_that_is_a_link_to_itself_is_refused(tmp_path: Path) -> None:
    (tmp_path / "system.toml").symlink_to("system.toml")
    with pytest.raises(ConfigError, match=r"cannot be read: .*Too many levels of symbolic links"):
        load(tmp_path / "system.toml")


# --- its values ----------------------------------------------------------------------------------


def simulation(**values: str) -> str:
    lines = {"stop_time": "1.0", "step": "0.1", **values}
    return "[simulation]\n" + "".join(f"{k} = {v}\n" for k, v in lines.items())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"stop_time": "1e300"}, "simulation.stop_time: input should be less than or equal to "
         "1000000000000000, found 1e+300"),
        ({"step": "5e-324"}, "simulation.step: input should be greater than or equal to "
         "0.000000000000001, found 5e-324"),
        ({"step": "0"}, "simulation.step: input should be greater than or equal to "
         "0.000000000000001, found 0"),
        ({"step": "nan"}, "simulation.step: input should be a finite number, found nan"),
        ({"tolerance": "1e308"}, "simulation.tolerance: input should be less than or equal to 1, "
         "found 1e+308"),
        ({"start_time": "9e14", "stop_time": "9.5e14", "step": "0.5"},
         "simulation.step: 0.5 is lost in the rounding of the time 9.5e+14"),
    ],
)  # fmt: skip
def test_time_is_refused(write, problems, values: dict[str, str], message: str) -> None:
    assert message in problems(write(simulation=simulation(**values), a=BODY))[0]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("every = 9999999999999", "a.every: input should be less than or equal to 1000000000, "
         "found 9999999999999"),
        ("max_step = 1e-12", "a.max_step: 1e-12 splits a step of 0.1 into too many"),
        ("start = { n = 2147483648 }", "a.start.n: n is 2147483648, not from -2147483648 to "
         "2147483647"),
        ('start = { v = { value = 1, unit = "10**10**10" } }', "a.start.v: '10**10**10' is not a "
         "unit"),
        ('start = { v = { value = 1, unit = "0 m" } }', "a.start.v: '0 m' is not a unit"),
    ],
)  # fmt: skip
def test_value_of_an_instance_is_refused(write, problems, body: str, message: str) -> None:
    assert message in problems(write(a=f"{BODY}\n{body}"))[0]


@pytest.mark.parametrize("name", [LONG, "\\u0000", "/dev/zero", "."])
@pytest.mark.parametrize("key", ["fmu", "component"])
def test_name_of_no_file_is_refused(write, problems, name: str, key: str) -> None:
    value = name if key == "fmu" else f"{name}.py:Block"
    (problem,) = problems(write(a=f'{key} = "{value}"'))
    assert problem.startswith(f"system.toml:8: instances.a.{key}: ")


@pytest.mark.parametrize("name", [LONG, "\\u0000", "/dev/zero", ".", "gone.toml"])
def test_base_that_is_no_file_is_refused(write, problems, tmp_path: Path, name: str) -> None:
    path = tmp_path / "derived.toml"
    path.write_text(f'\nextends = "{name}"', encoding="utf-8")
    (problem,) = problems(path)
    assert problem.startswith("derived.toml:2: extends: there is no file ")


def test_more_copies_than_can_be_made_are_refused(write, problems) -> None:
    rest = '[repeat.i]\ncount = 1000000000\n[repeat.i.instances."a{i}"]\n' + BODY
    assert problems(write(rest=rest)) == [
        "system.toml:8: repeat.i.count: input should be less than or equal to 100000, "
        "found 1000000000"
    ]


@pytest.mark.parametrize("rule", [
    {"file": "/dev/zero"}, {"file": "\0"}, {"file": LONG}, {"file": "."},
    {"random": [], "seed": 1}, {"random": {}, "seed": 1},
])  # fmt: skip
def test_rule_for_copies_is_refused(rule: dict[str, Any]) -> None:
    with pytest.raises(Refused, match=r"is not a file|cannot be read|is not a distribution"):
        spread(rule, 2, Path("."), "")


@pytest.mark.parametrize(
    ("table", "columns", "message"),
    [
        ("x,y\n1,2\n", None, "starts.csv has 1 rows for 2 copies"),
        ("", None, "starts.csv has 0 rows for 2 copies"),
        ("x,y\n1,2\n3,4\n", ["z"], "starts.csv has no column z"),
        ("x,y\n1,2\n3,4\n", [["x"]], "starts.csv has no column ['x']"),
        ("1,2\n3,4\n", ["x"], "starts.csv has no column x"),
        ("x,y\n1,2\n3,high\n", None, "row 3 of starts.csv is not all numbers"),
        ("x,y\n1,2\n3\n", ["y"], "row 3 of starts.csv is not all numbers"),
        ("x" * 200_000, None, "starts.csv cannot be read: field larger than field limit"),
    ],
)
def test_table_for_copies_is_refused(
    tmp_path: Path, table: str, columns: list[Any] | None, message: str
) -> None:
    (tmp_path / "starts.csv").write_text(table, encoding="utf-8")
    rule = {"file": "starts.csv"} | ({} if columns is None else {"columns": columns})
    with pytest.raises(Refused) as caught:
        spread(rule, 2, tmp_path, "")
    assert message in caught.value.what


def test_offset_of_thousands_of_digits_is_no_place_of_a_template(write, problems) -> None:
    text = f"a{{i}}.y -> a{{i+{'9' * 5000}}}.u"
    rest = f'[repeat.i]\ncount = 2\nconnections = ["{text}"]\n[repeat.i.instances."a{{i}}"]\n{BODY}'
    assert "there is no instance a{i+999" in problems(write(rest=rest))[0]


@pytest.mark.parametrize("unit", ["10**10**10", "9^99999999", "0*m", "m/0", "-m", "1e400 m", ""])
def test_unit_without_a_meaning_is_refused_at_once(unit: str) -> None:
    with pytest.raises(UnitError, match="is not a unit"):
        unit_of(unit)


def test_structure_that_cannot_be_built_is_refused() -> None:
    with pytest.raises(BuildError, match="neighbours: 1000000000 is more than 10000"):
        load_block("AttitudeConsensusController", {"neighbours": 10**9})


# --- figures: beside the results, each its own file -----------------------------------------------

NAME = "input should be a name without a folder that ends in .png, .svg or .pdf, found"


@pytest.mark.parametrize(
    "file", ["../x.png", "/x.png", "sub/x.png", "a\\\\x.png", "x", "results.h5", "x.xyz", ".png",
             "\\u0000.png", f"{LONG}.png"],
)  # fmt: skip
def test_figure_lies_beside_the_results(write, problems, file: str) -> None:
    rest = f'[[plots]]\ntitle = "x"\nsignals = ["*"]\nfile = "{file}"'
    (problem,) = problems(write(rest=rest, a=BODY))
    assert problem.startswith(f"system.toml:13: plots.0.file: {NAME} ")


def test_figures_do_not_overwrite_each_other(write, problems) -> None:
    plot = '[[plots]]\ntitle = "{}"\nsignals = ["*"]\n'
    assert problems(write(rest=plot.format("A b") + plot.format("a-B"), a=BODY)) == [
        "system.toml:14: plots.1.title: a-b.png is the file of plots.0 already; "
        "give it another title or file"
    ]


@pytest.mark.parametrize("title", ["", "..", "/", "a/../b", "\0", LONG, "日本"])
def test_title_gives_a_name_of_a_file(title: str) -> None:
    assert 0 < len(slug(title)) <= 80
    assert set(slug(title)) <= set("abcdefghijklmnopqrstuvwxyz0123456789-")


@pytest.mark.parametrize("name", ["../a", "a/b", "a.b", ".", "..", "", "\0", "a\n"])
def test_name_of_an_instance_is_no_path(name: str) -> None:
    data = {"simulation": {"stop_time": 1.0, "step": 0.1}, "instances": {name: {"fmu": "x.fmu"}}}
    with pytest.raises(ValueError, match="String should match pattern"):
        Config.model_validate(data)


# --- the command line -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("a.u=" + "[" * 2000, "is not a value"),
        ("a.u=" + "9" * 5000, "is not a value"),
        ("a.u=1\nb = 2", "is not a value"),
        (f"a.u={10**30}", "is not a value"),
        ("repeat.i=3", "nothing repeats over i"),
    ],
)
def test_setting_is_refused(write, setting: str, message: str) -> None:
    done = invoke("explain", write(a=BODY), "--set", setting)
    assert done.exit_code == 2
    assert message in done.stderr


@pytest.mark.parametrize(
    ("rest", "message"),
    [
        ("start = 5", "instances.a.start: input should be a valid dictionary, found 5"),
        ('[repeat]\ni = "x"', "repeat.i: input should be a valid dictionary or instance"),
    ],
)
def test_setting_of_what_is_wrong_in_the_config_is_refused(write, rest: str, message: str) -> None:
    done = invoke("explain", write(a=f"{BODY}\n{rest}"), "--set", "a.u=1", "--set", "repeat.i=2")
    assert done.exit_code == 2
    assert message in done.stderr


@pytest.mark.parametrize("every", ["inf", "1e-300", "1e300"])
def test_interval_of_checkpoints_is_refused(write, tmp_path: Path, every: str) -> None:
    done = invoke("run", write(a=BODY), "--out", tmp_path / "o", "--checkpoint-every", every)
    assert done.exit_code == 2
    assert f"--checkpoint-every: {float(every):g} is not from 1e-15 to 1e+15" in done.stderr


@pytest.mark.parametrize("file", [LONG, "gone.fmu", "."])
def test_verify_names_files_that_are_not_there(file: str) -> None:
    done = invoke("verify", file)
    assert (done.exit_code, done.stderr) == (2, f"there is no file {file}\n")


def test_number_of_a_structure_is_written_in_digits(tmp_path: Path) -> None:
    for value in ("²", "9" * 5000, "-1", "1.0"):
        done = invoke("build", "Gyro", "--out", tmp_path, "--structure", f"history={value}")
        assert (done.exit_code, done.stderr) == (2, "--structure takes name=number\n")


def test_signs_that_a_terminal_does_not_know_are_written_out() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "sightline.orchestrator.cli", "info", "Gyro"],
        capture_output=True, text=True, env={**os.environ, "PYTHONIOENCODING": "ascii"},
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    assert "\\u03a9" in done.stdout


def test_nothing_in_a_config_steers_the_terminal_or_adds_a_line(write, problems) -> None:
    assert problems(write(["a.y\\n1 problem\\u001b[2J -> a.u"], a=BODY)) == [
        'system.toml: connection "a.y\\n1 problem\\x1b[2J -> a.u": '
        "is not of the form a.x -> b.y; elements: a.x[1] -> b.y[2]"
    ]


# --- results files --------------------------------------------------------------------------------


def results_file(path: Path, **changed: Any) -> Path:
    sound: dict[str, Any] = {
        "config": "", "conversions": "", "fmus": "", "time": np.arange(3.0), "a/x": np.arange(3.0)
    }  # fmt: skip
    with h5py.File(path, "w") as file:
        for name, value in (sound | changed).items():
            if value is not None:
                file[name] = value
        file["a/x"].attrs.update(unit="$", frame="", description="")
        file.attrs.update(complete=True, steps=2, rejected_steps=0)
    return path


@pytest.mark.parametrize(
    "names", [["x", "x/y"], ["x/y", "x"], ["."], [".."], ["/x"], ["a//b"], ["a/./b", "a/b"],
              ["%2F"], ["ä", "x y", "x(1)", "x%"]],
)  # fmt: skip
def test_results_hold_variables_of_any_name(
    write, make_fmu, tmp_path: Path, names: list[str]
) -> None:
    make_fmu("strange", [variable(name, "output") for name in names])
    system = System.from_toml(write(a='fmu = "strange.fmu"'))
    with ResultsWriter(tmp_path, system.graph, system.selection.recorded, "") as writer:
        writer.append(np.zeros(1), np.arange(float(len(names)))[None])
    results = read(tmp_path / "results.h5")
    assert {n: float(results[n][0]) for n in results.series} == {
        f"a.{name}": number for number, name in enumerate(names)
    }


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"time": None}, "Unable to synchronously open object (object 'time' doesn't exist)"),
        ({"time": "noon"}, "/time does not hold numbers"),
        ({"config": 3.0}, "string datatype"),
        ({"a/x": "much"}, "/a/x does not hold numbers"),
    ],
)
def test_file_of_another_form_is_no_results_file(
    tmp_path: Path, changed: dict[str, Any], message: str
) -> None:
    path = results_file(tmp_path / "x.h5", **changed)
    done = invoke("plot", path)
    assert done.exit_code == 1
    assert done.stderr.startswith(f"{path} is not a results file: ")
    assert message in done.stderr


def test_file_that_claims_more_than_it_holds_is_refused(tmp_path: Path) -> None:
    path = results_file(tmp_path / "x.h5")
    with h5py.File(path, "a") as file:
        del file["time"]
        file.create_dataset("time", shape=(10**12,), dtype="f8", chunks=(1024,))
    with pytest.raises(OSError, match="/time claims to hold more than the file can"):
        read(path)


def test_config_in_results_names_no_file_elsewhere(tmp_path: Path) -> None:
    config = '[[plots]]\ntitle = "x"\nsignals = ["*"]\nfile = "../x.png"'
    done = invoke("plot", results_file(tmp_path / "x.h5", config=config))
    assert done.exit_code == 2
    assert "should be a name without a folder" in done.stderr


def test_dollars_begin_no_mathematics(tmp_path: Path) -> None:
    path = results_file(tmp_path / "x.h5")
    done = invoke("plot", path, "-s", "*", "--title", "$\\frac{$", "--out", tmp_path / "x.svg")
    assert done.exit_code == 0


def test_zeros_have_no_logarithmic_scale(tmp_path: Path) -> None:
    path = results_file(tmp_path / "x.h5", **{"a/x": np.zeros(3)})
    done = invoke("plot", path, "-s", "*", "--scale", "log", "--out", tmp_path / "x.svg")
    assert (done.exit_code, done.stderr) == (0, "")


def test_folder_is_no_checkpoint(write, tmp_path: Path) -> None:
    done = invoke("run", write(a=BODY), "--out", tmp_path / "o", "--resume", tmp_path)
    assert done.exit_code == 2
    assert done.stderr.splitlines()[-2] == "1 problem"
    assert f"--resume {tmp_path}: is not a snapshot: " in done.stderr
