"""Blocks that run in Python although there is a compiler: every command says so, and why."""

from __future__ import annotations

from pathlib import Path

import pytest

from sightline.fmus.native.target import compiler_available

from .test_cli import sightline

pytestmark = [
    pytest.mark.usefixtures("fmu_cache"),
    pytest.mark.skipif(not compiler_available(), reason="a native FMU needs a C compiler"),
]
SOURCE = '''import math
from sightline.components import Component, Input, Output, Structure


class Sine(Component):
    """The sine of a number, so many times."""

    times = Structure(1, doc="how often")
    u = Input((), "1", doc="number")
    y = Output("times", "1", doc="sine")

    def outputs(self, u, times):
        return {"y": [math.sin(u)] * times}
'''
NOTE = (
    "note: Sine runs as a Python FMU, slower: outputs: math.sin(u) (sine.py, line 13) takes the "
    "number of a value that is known only when the FMU runs; write np.sin instead of math.sin\n"
)


@pytest.fixture
def sine(tmp_path: Path) -> str:
    path = tmp_path / "sine.py"
    path.write_text(SOURCE, encoding="utf-8")
    return f"{path}:Sine"


@pytest.fixture
def system(write, sine: str) -> Path:
    table = f'component = "{sine}"'
    return write(one=table, two=table, three=f"{table}\nstructure = {{ times = 2 }}")


def test_build_says_why_an_fmu_is_not_native_and_succeeds(sine: str, tmp_path: Path) -> None:
    for _ in ("built", "from the cache"):
        done = sightline("build", sine, "--out", tmp_path)
        assert done.returncode == 0
        assert done.stderr == NOTE
        assert "Sine.fmu" in done.stdout


def test_build_of_fmi_3_says_why_it_cannot_be(sine: str, tmp_path: Path) -> None:
    done = sightline("build", sine, "--fmi", "3", "--out", tmp_path)
    assert done.returncode == 1
    assert "Sine.outputs cannot become native code: math.sin(u) (sine.py, line 13)" in done.stderr


def test_run_and_explain_say_it_once_for_all_copies(system: Path, tmp_path: Path) -> None:
    for command in (("run", system, "--out", tmp_path / "out"), ("explain", system)):
        done = sightline(*command)
        assert done.returncode == 0
        assert done.stderr.count(NOTE) == 1
        assert done.stderr.count("slower") == 1


def test_a_system_that_asks_for_python_is_not_told(write, sine: str) -> None:
    done = sightline("explain", write(one=f'component = "{sine}"\ntarget = "python"'))
    assert done.returncode == 0
    assert "slower" not in done.stderr
