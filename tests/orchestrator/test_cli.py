"""The command line: exit codes, texts, files; never a traceback."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

import pytest

from .test_run import BLOCKS, LOOP, block

pytestmark = pytest.mark.usefixtures("fmu_cache")


def sightline(*args: str | Path, columns: int = 100) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, "-m", "sightline.orchestrator.cli", *map(str, args)],
        capture_output=True, text=True, check=False,
        env={**os.environ, "COLUMNS": str(columns)},
    )  # fmt: skip
    assert "Traceback" not in done.stdout + done.stderr
    return done


@pytest.fixture
def system(write) -> Path:
    plots = (
        '[[plots]]\ntitle = "State & rate"\nsignals = ["*"]\n'
        '[[plots]]\ntitle = "x"\nfile = "mine.png"\nsignals = ["plant.x"]\n'
    )
    tables = {
        "control": block("Gain"), "plant": block("Integrator", "start = { x = 1.0 }"),
    }  # fmt: skip
    return write(LOOP, plots, **tables)


def test_run_leaves_results_table_and_figures_and_says_so(system: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = sightline("run", system, "--out", out, "--csv")
    assert done.returncode == 0
    assert done.stdout == (
        f"results in {out}: results.h5 (11 samples of 2 signals), results.csv, results_units.csv, "
        "state-rate.png, mine.png\n"
    )
    with (out / "results.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))
    assert rows[0] == ["time", "control.y", "plant.x"]
    assert [float(v) for v in rows[1]] == [0.0, -1.0, 1.0]
    assert len(rows) == 12
    with (out / "results_units.csv").open(encoding="utf-8") as file:
        units = list(csv.reader(file))
    assert [row[:2] for row in units] == [
        ["column", "unit"], ["time", "s"], ["control.y", "m/s"], ["plant.x", "m"],
    ]  # fmt: skip
    assert all((out / name).stat().st_size > 5000 for name in ("state-rate.png", "mine.png"))


def test_set_changes_parameters_and_start_values(system: Path, tmp_path: Path) -> None:
    done = sightline(
        "run", system, "--out", tmp_path, "--csv", "--set", "plant.x=2", "--set", "control.k=-0.5"
    )
    assert done.returncode == 0
    assert (tmp_path / "results.csv").read_text().splitlines()[1] == "0.0,-1.0,2.0"


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("plant.x", "--set plant.x: is not of the form instance.name=value"),
        ("plant.x=", "--set plant.x=: '' is not a value"),
        ("plant.xx=1", "--set plant.xx: plant has no parameter or start value xx"),
        ("plant.x=nan", "instances.plant.start.x: x is nan, not a finite number"),
    ],
)
def test_wrong_setting_is_bad_usage(
    system: Path, tmp_path: Path, setting: str, message: str
) -> None:
    done = sightline("run", system, "--out", tmp_path / "out", "--set", setting)
    assert done.returncode == 2
    assert message in done.stderr
    assert not (tmp_path / "out").exists()


def test_wrong_config_is_bad_usage_with_all_problems(write, tmp_path: Path) -> None:
    path = write(
        ["plant.y -> control.x"], control=block("Gani"), plant=block("Integrator", "satrt = {}"),
        gone='fmu = "gone.fmu"',
    )  # fmt: skip
    done = sightline("run", path, "--out", tmp_path / "out")
    assert done.returncode == 2
    assert "4 problems" in done.stderr
    assert "plant (Integrator) has no port y; its outputs: x" in done.stderr
    assert "defines no block Gani; did you mean Gain?" in done.stderr
    assert "instances.plant.satrt: unknown key; did you mean start" in done.stderr
    assert "gone.fmu does not exist" in done.stderr


def test_failed_run_exits_with_one_and_names_what_there_is(write, tmp_path: Path) -> None:
    path = write(
        ["plant.x -> control.x"],
        plant=block("Integrator", "start = { u = 1.0 }"),
        control=block("Gain", "parameters = { limit = 0.45 }"),
    )
    done = sightline("run", path, "--out", tmp_path)
    assert done.returncode == 1
    assert "control at t = 0.4 s: the step of 0.1 s ended with discard" in done.stderr
    assert done.stdout == (
        f"results until then in {tmp_path}: results.h5 (5 samples of 2 signals), log.txt\n"
    )


def test_plot_redraws_the_figures_of_the_config(system: Path, tmp_path: Path) -> None:
    sightline("run", system, "--out", tmp_path)
    done = sightline("plot", tmp_path / "results.h5", "--out", tmp_path / "f", "--format", "svg")
    assert done.returncode == 0
    assert done.stdout == f"{tmp_path}/f/state-rate.svg\n{tmp_path}/f/mine.svg\n"


def test_plot_draws_chosen_signals_to_a_file(system: Path, tmp_path: Path) -> None:
    sightline("run", system, "--out", tmp_path)
    out = tmp_path / "x.png"
    done = sightline("plot", tmp_path / "results.h5", "-s", "plant.*", "--until", "0.5", "-o", out)
    assert (done.returncode, done.stdout) == (0, f"{out}\n")
    assert out.stat().st_size > 5000


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-s", "plnt.x"], '--signals: "plnt.x" names no recorded signal; did you mean plant.x?'),
        (["-s", "plant.x", "--kind", "angle"],
         "angle needs two or more signals that are quaternions of 4 elements, the last one the "
         "reference; found plant.x"),
        (["-o", "x.png"], "--out x.png is one figure: say what is in it with --signals"),
    ],
)  # fmt: skip
def test_wrong_plot_is_bad_usage(
    system: Path, tmp_path: Path, arguments: list[str], message: str
) -> None:
    sightline("run", system, "--out", tmp_path)
    done = sightline("plot", tmp_path / "results.h5", *arguments)
    assert (done.returncode, done.stderr) == (2, f"{message}\n")


def test_plot_of_another_file_fails(system: Path) -> None:
    done = sightline("plot", system)
    assert done.returncode == 1
    assert done.stderr.startswith(f"{system} is not a results file: ")


def test_building_is_said_only_when_something_is_built(write, tmp_path: Path) -> None:
    path = write(plant=block("Integrator", "structure = {}"))
    text = Path(BLOCKS).read_text(encoding="utf-8").replace("x' = u", "x' = u, once")
    (tmp_path / "own.py").write_text(text, encoding="utf-8")
    path.write_text(path.read_text().replace(BLOCKS.as_posix(), "own.py"))
    said = [sightline("run", path, "--out", tmp_path / "out").stderr for _ in range(2)]
    assert ["building" in text for text in said] == [True, False]


def test_folder_that_cannot_be_written_is_said_to_be(system: Path, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    done = sightline("run", system, "--out", tmp_path / "file")
    assert done.returncode == 1
    assert "cannot write to" in done.stderr


def test_list_shows_blocks_by_family() -> None:
    done = sightline("list")
    assert done.returncode == 0
    dynamics = done.stdout.partition("dynamics\n")[2]
    assert "  FreeRigidBody  " in dynamics


def test_info_shows_ports_units_and_frames() -> None:
    done = sightline("info", "FreeRigidBody")
    assert done.returncode == 0
    for text in ("inertia", "kg.m2", "inertial", "angular_velocity", "source: "):
        assert text in done.stdout


def test_info_lists_the_settings_of_the_fmu_and_no_start_of_outputs() -> None:
    done = sightline("info", "FreeRigidBody")
    outputs = next(x for x in done.stdout.splitlines() if x.startswith("outputs"))
    assert outputs.split() == ["outputs", "shape", "unit", "frame", "what"]
    for text in ("settings of the FMU", "solver_step", "relative_tolerance"):
        assert text in done.stdout


def test_info_tells_start_values_with_all_their_digits() -> None:
    rows = [x.split() for x in sightline("info", "TwoBodyOrbit").stdout.splitlines()]
    (parameter,) = (row for row in rows if row[:1] == ["gravitational_parameter"])
    assert float(parameter[3]) == 3.986004418e14
    assert ["[0", "7702.726184243932", "0]"] in rows  # on its own below velocity


def test_info_of_a_matrix_breaks_between_rows_only() -> None:
    lines = sightline("info", "FreeRigidBody", columns=60).stdout.splitlines()
    first = next(i for i, x in enumerate(lines) if x.startswith("inertia ")) + 1
    assert [x.strip() for x in lines[first : first + 3]] == ["[[1 0 0]", "[0 1 0]", "[0 0 1]]"]


def test_version_is_that_of_the_installed_package() -> None:
    done = sightline("--version")
    assert (done.returncode, done.stdout) == (0, f"sightline {version('sightline')}\n")


def test_info_of_an_unknown_block_names_the_nearest() -> None:
    done = sightline("info", "FreeRigidBdy")
    assert done.returncode == 2
    assert "did you mean 'FreeRigidBody'" in done.stderr


def test_build_writes_an_fmu(tmp_path: Path) -> None:
    done = sightline("build", "RangeSensor", "--target", "python", "--out", tmp_path)
    assert done.returncode == 0
    assert (tmp_path / "RangeSensor.fmu").is_file()
    assert done.stdout.startswith(f"{tmp_path / 'RangeSensor.fmu'} (")


def test_build_of_an_unknown_block_fails(tmp_path: Path) -> None:
    done = sightline("build", "RangeSensr", "--out", tmp_path)
    assert done.returncode == 1
    assert "did you mean 'RangeSensor'?" in done.stderr


@pytest.mark.parametrize("command", ["list", "info", "build", "run", "explain", "plot", "demo"])
def test_help_of_each_command_shows_an_example(command: str) -> None:
    done = sightline(command, "--help")
    assert done.returncode == 0
    assert f"Example:  sightline {command}" in done.stdout


def test_unknown_command_is_bad_usage() -> None:
    assert sightline("fly").returncode == 2


def test_help_imports_none_of_the_heavy_packages() -> None:
    script = (
        "import sys; from sightline.orchestrator.cli import app\n"
        "try: app(['--help'])\n"
        "except SystemExit: pass\n"
        "heavy = {'numpy', 'casadi', 'matplotlib', 'fmpy', 'h5py', 'pint', 'pydantic', 'scipy'}\n"
        "sys.exit(' '.join(heavy & set(sys.modules)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_long_note_is_cut_and_says_where_all_of_it_is(tmp_path: Path) -> None:
    positions = [[0.123456 * k, 0.0, 0.0] for k in range(12)]
    config = tmp_path / "system.toml"
    config.write_text(
        '[simulation]\nstop_time = 0.1\nstep = 0.1\n[instances.t]\ncomponent = "ThrusterCluster"\n'
        f'parameters = {{ positions = {{ value = {positions}, unit = "mm" }} }}\n'
    )
    done = sightline("run", config, "--out", tmp_path / "out")
    (note,) = (line for line in done.stderr.splitlines() if "t.positions" in line)
    assert note.startswith("note: t.positions: [[0.0, 0.0, 0.0], [0.123456, 0.0, 0.0],")
    assert note.endswith(" ...; sightline explain tells all of it")
    assert len(note) <= 240
    assert "0.001358016, 0, 0] m" in sightline("explain", config).stdout


def test_explain_draws_a_picture_of_the_kind_asked_for(system: Path, tmp_path: Path) -> None:
    picture = tmp_path / "pictures" / "wiring.svg"
    done = sightline("explain", system, "--graph", picture)
    assert done.returncode == 0
    assert done.stdout.endswith(f"\npicture in {picture}\n")
    assert ElementTree.parse(picture).getroot().tag == "{http://www.w3.org/2000/svg}svg"


def test_a_picture_that_cannot_be_made_is_told(system: Path, tmp_path: Path) -> None:
    unknown = sightline("explain", system, "--graph", tmp_path / "wiring.xyz")
    assert unknown.returncode == 2
    assert "xyz" in unknown.stderr
    (tmp_path / "file").touch()
    refused = sightline("explain", system, "--graph", tmp_path / "file" / "wiring.svg")
    assert refused.returncode == 1
    assert refused.stderr.startswith("cannot write the picture: ")


def test_what_an_earlier_run_left_goes_with_its_results(system: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert sightline("run", system, "--out", out, "--csv").returncode == 0
    assert (out / "mine.png").is_file()
    done = sightline("run", system, "--out", out, "--set", "plant.x=1e999")
    assert done.returncode == 2  # refused: nothing was touched
    assert (out / "mine.png").is_file()
    (out / "kept.txt").touch()
    done = sightline("run", system, "--out", out, "--set", "simulation.stop_time=0.2")
    assert done.returncode == 0
    assert not (out / "results.csv").exists()
    assert (out / "kept.txt").exists()
