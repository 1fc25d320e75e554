"""The README is true: its commands run, its block builds, its Python works."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest

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
SOURCES = [text for kind, text in BLOCKS if kind == "python"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as the README's reader has it."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "examples").symlink_to(ROOT / "examples")
    (folder / "damping.py").write_text(SOURCES[0], encoding="utf-8")
    return folder


def test_the_first_two_blocks_are_one_line_each() -> None:
    assert [text.count("\n") for _, text in BLOCKS[:2]] == [1, 1]


@pytest.mark.parametrize("command", COMMANDS)
def test_command_runs(command: str, folder: Path) -> None:
    arguments = shlex.split(command)[1:]
    call = [sys.executable, "-m", "sightline.orchestrator.cli", *arguments]
    done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


def test_python_example_runs(folder: Path) -> None:
    build = [sys.executable, "-m", "sightline.orchestrator.cli", "build", "FreeRigidBody"]
    subprocess.run([*build, "--out", "fmus"], cwd=folder, check=True, capture_output=True)
    subprocess.run([sys.executable, "-c", SOURCES[1]], cwd=folder, check=True)
