"""The README is true: its commands run and litter nothing, its block builds, its Python works."""

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
WRITTEN = {"built", "results"}  # folders that the commands and sources write into
SOURCES = [text for kind, text in BLOCKS if kind == "python"]  # the first one is a block


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as the README's reader has it, with the FMUs that its commands build."""
    folder = tmp_path_factory.mktemp("reader")
    (folder / "examples").symlink_to(ROOT / "examples")
    (folder / "damping.py").write_text(SOURCES[0], encoding="utf-8")
    for command in COMMANDS:
        if command.startswith("sightline build"):
            run(command, folder)
    return folder


def run(command: str, folder: Path) -> None:
    """Run a command of the README."""
    call = [sys.executable, "-m", "sightline.orchestrator.cli", *shlex.split(command)[1:]]
    done = subprocess.run(call, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"


def left_by_others(folder: Path) -> set[str]:
    """What stands in a folder besides what the reader put there and the folders of results."""
    return {p.name for p in folder.iterdir()} - WRITTEN - {"examples", "damping.py"}


def test_the_first_two_blocks_are_one_line_each() -> None:
    assert [text.count("\n") for _, text in BLOCKS[:2]] == [1, 1]


def test_commands_run_one_after_another_and_write_nowhere_else(folder: Path) -> None:
    for command in COMMANDS:
        if not command.startswith("sightline build"):
            run(command, folder)
    assert left_by_others(folder) <= {"__pycache__"}


@pytest.mark.parametrize("text", SOURCES[1:])
def test_python_example_runs_and_writes_nowhere_else(text: str, folder: Path) -> None:
    subprocess.run([sys.executable, "-c", text], cwd=folder, check=True)
    assert left_by_others(folder) <= {"__pycache__"}


def test_git_ignores_what_commands_write() -> None:
    ignored = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    assert {f"/{name}/" for name in WRITTEN} | {"__pycache__/"} <= set(ignored)


@pytest.mark.parametrize(
    "document", ["README.md", "orchestrator/README.md", "components/README.md"]
    + [f"examples/{path.parent.name}/README.md" for path in ROOT.glob("examples/*/README.md")]
)  # fmt: skip
def test_links_lead_to_files(document: str) -> None:
    text = (ROOT / document).read_text(encoding="utf-8")
    places = {link.partition("#")[0] for link in re.findall(r"\]\(([^)\s]+)\)", text)}
    folder = (ROOT / document).parent
    assert {p for p in places if not (folder / p).exists()} == set()
