"""The README is true: its commands run, its block builds, its Python works."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from sightline.orchestrator import System
from sightline.orchestrator.config.model import Simulation

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"```(\w+)\n(.*?)```", README, re.DOTALL)
COMMANDS = [
    line[line.index("sightline "):]
    for kind, text in BLOCKS
    if kind == "console"
    for line in text.splitlines()
    if "sightline " in line
]
SOURCES = [text for kind, text in BLOCKS if kind == "python"]  # the first one is a block
TEMPLATES = [text for kind, text in BLOCKS if kind == "toml"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as the README's reader has it."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "examples").symlink_to(ROOT / "examples")
    (folder / "damping.py").write_text(SOURCES[0], encoding="utf-8")
    return folder


def test_the_first_two_blocks_are_one_line_each() -> None:
    assert [text.count("\n") for _, text in BLOCKS[:2]] == [1, 1]


def test_commands_run_one_after_another(folder: Path) -> None:
    for command in COMMANDS:
        arguments = shlex.split(command)[1:]
        call = [sys.executable, "-m", "sightline.orchestrator.cli", *arguments]
        done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"


@pytest.mark.parametrize("text", TEMPLATES)
def test_template_is_a_system(text: str, tmp_path: Path) -> None:
    simulation = "\n[simulation]\nstop_time = 1.0\nstep = 0.1\n"
    (tmp_path / "system.toml").write_text(text + simulation, encoding="utf-8")
    system = System.from_toml(tmp_path / "system.toml", {"repeat.i": 4})
    assert len(system.graph.nodes) == 12


def test_table_of_simulation_has_all_keys_and_their_defaults() -> None:
    rows = README.partition("| `[simulation]` |")[2].partition("\n\n")[0].splitlines()[2:]
    told = {cells[1].strip(" `"): cells[2].strip(" `") for cells in (r.split("|") for r in rows)}
    fields = Simulation.model_fields.items()
    defaults = {n: None if f.is_required() else f.default for n, f in fields}
    assert {n: tomllib.loads(f"v = {t}")["v"] if t else None for n, t in told.items()} == defaults


@pytest.mark.parametrize("text", SOURCES[1:])
def test_python_example_runs(text: str, folder: Path) -> None:
    build = [sys.executable, "-m", "sightline.orchestrator.cli", "build", "FreeRigidBody"]
    subprocess.run([*build, "--out", "fmus"], cwd=folder, check=True, capture_output=True)
    subprocess.run([sys.executable, "-c", text], cwd=folder, check=True)
