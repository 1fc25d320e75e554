"""Who may import whom: components know numpy only, the master knows FMUs only."""

from __future__ import annotations

import ast
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BUILDERS = {"building.py", "cli.py"}  # of the orchestrator: commands that build what they name
SHARED = {  # for both packages: how an .fmu file is opened and read, what a unit's name means
    "sightline.fmus.safe_archive", "sightline.fmus.safe_description", "sightline.fmus.units",
}


def imports(path: Path) -> set[str]:
    """Modules that a file imports; relative ones start with the package they reach."""
    package = ["sightline", *path.relative_to(ROOT).parent.parts]
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            names.add(".".join([*base, *([node.module] if node.module else [])]))
    return names


def files(package: str) -> list[Path]:
    return sorted((ROOT / package).rglob("*.py"))


@pytest.mark.parametrize("path", files("components"), ids=str)
def test_components_import_numpy_and_the_standard_library_only(path: Path) -> None:
    foreign = {"casadi", "scipy", "fmpy", "pythonfmu", "pint", "h5py", "matplotlib"}
    assert not {n for n in imports(path) if n.split(".")[0] in foreign}
    assert not {n for n in imports(path) if n.startswith(("sightline.fmus", "sightline.orch"))}


@pytest.mark.parametrize("path", files("fmus"), ids=str)
def test_fmus_do_not_know_the_orchestrator(path: Path) -> None:
    assert not {n for n in imports(path) if n.startswith("sightline.orchestrator")}


@pytest.mark.parametrize("path", files("orchestrator"), ids=str)
def test_only_commands_of_the_orchestrator_reach_for_fmus_and_components(path: Path) -> None:
    reached = {n for n in imports(path) if n.startswith(("sightline.fmus", "sightline.comp"))}
    free = path.name in BUILDERS or path.parent.name == "commands"
    assert free or reached <= SHARED


@pytest.mark.parametrize("name", ["safe_archive", "safe_binary", "safe_xml"])
def test_what_both_packages_share_needs_the_standard_library_only(name: str) -> None:
    found = imports(ROOT / "fmus" / f"{name}.py")
    foreign = {n for n in found if n.split(".")[0] not in sys.stdlib_module_names}
    assert foreign <= {"sightline.fmus.safe_binary", "sightline.fmus.safe_xml"}


def test_top_level_holds_what_was_agreed_and_nothing_else() -> None:
    agreed = {"pyproject.toml", "README.md", "fmus", "components", "orchestrator", "tests",
              "examples", "LICENSE", "CHANGELOG.md"}
    made = {"build", "dist", "results"}  # by tools, ignored by git
    found = {p.name for p in ROOT.iterdir() if not p.name.startswith(".")}
    assert {n for n in found - made if not n.endswith(".egg-info")} == agreed


def test_every_subpackage_is_installed() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    listed = set(project["tool"]["setuptools"]["packages"])
    folders = {
        ".".join(["sightline", *init.parent.relative_to(ROOT).parts])
        for package in ("components", "fmus", "orchestrator")
        for init in (ROOT / package).rglob("__init__.py")
    }
    assert folders <= listed
