"""One line of a config swaps the controller: other blocks, a user's own, and foreign FMUs."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.orchestrator.results.file import Results
from sightline.orchestrator.system import System

EXAMPLE = Path(__file__).parents[2] / "examples" / "swap"
PUBLISHED = 'component = "LineOfSightFormationController"'
LINES = {
    "published": PUBLISHED,
    "baseline": 'component = "LineOfSightPdController"',
    "block": 'component = "own_block.py:OwnBlock"',
    "script": 'fmu = "PythonScript.fmu"',
    "foreign": 'fmu = "foreign.fmu"',
}
SAME_LAW = ("block", "script", "foreign")
PORTS = ("position", "velocity", "attitude", "angular_velocity")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="compiles an FMU in C")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the example with its FMUs built as the README says."""
    path = tmp_path_factory.mktemp("swap")
    shutil.copytree(EXAMPLE, path, dirs_exist_ok=True)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", "python_script.py"]
    subprocess.run(command, cwd=path, check=True)
    binary = f"foreign{fmpy.sharedLibraryExtension}"
    subprocess.run(
        ["cc", "-O2", "-shared", "-fPIC", "foreign.c", "-o", binary], cwd=path, check=True
    )
    with zipfile.ZipFile(path / "foreign.fmu", "w") as archive:
        archive.write(path / "foreign.xml", "modelDescription.xml")
        archive.write(path / binary, f"binaries/{fmpy.platform}/{binary}")
    return path


@pytest.fixture(scope="module")
def runs(folder: Path) -> dict[str, Results]:
    """The example's run with each line, 200 s."""
    text = (folder / "system.toml").read_text(encoding="utf-8")
    assert text.count(PUBLISHED) == 1
    found = {}
    for name, line in LINES.items():
        config = folder / f"{name}.toml"
        config.write_text(text.replace(PUBLISHED, line), encoding="utf-8")
        found[name] = System.from_toml(config).simulate(folder / name)
    return found


@pytest.mark.parametrize("name", LINES)
def test_every_controller_brings_the_craft_to_their_distance_facing(
    runs: dict[str, Results], name: str
) -> None:
    assert runs[name]["range1.range"][-1] == pytest.approx(20.0, abs=0.5)  # still swinging
    assert runs[name]["monitor.alignment_error"][-1] < 1e-6


@pytest.mark.parametrize("name", SAME_LAW)
@pytest.mark.parametrize("port", PORTS)
def test_the_same_law_gives_the_same_trajectory(
    runs: dict[str, Results], name: str, port: str
) -> None:
    for craft in ("craft1", "craft2"):
        signal = f"{craft}.{port}"
        # rounding, which the start near an unstable equilibrium amplifies
        np.testing.assert_allclose(
            runs[name][signal], runs["published"][signal], rtol=0, atol=1e-9, err_msg=signal
        )


def test_the_baseline_takes_another_way(runs: dict[str, Results]) -> None:
    apart = runs["baseline"]["craft2.position"] - runs["published"]["craft2.position"]
    assert np.abs(apart).max() > 0.1  # m


def test_the_template_gives_the_run_of_the_written_out_example(
    runs: dict[str, Results], tmp_path: Path
) -> None:
    written_out = EXAMPLE.parent / "los_formation" / "system.toml"
    other = System.from_toml(written_out, {"simulation.step": 0.05}).simulate(tmp_path)
    for port in PORTS:
        np.testing.assert_allclose(
            runs["published"][f"craft2.{port}"], other[f"craft2.{port}"], rtol=0, atol=1e-9
        )
