"""Which target a build takes if nobody says, and what it says of its choice."""

from __future__ import annotations

from pathlib import Path

import pytest

from sightline.fmus.build import build
from sightline.fmus.native.target import compiler_available

pytestmark = [
    pytest.mark.usefixtures("fmu_cache"),
    pytest.mark.skipif(not compiler_available(), reason="a native FMU needs a C compiler"),
]
SOURCE = '''import math
import numpy as np
from sightline.components import Component, Input, Output


class Sine(Component):
    """The sine of a number."""

    u = Input((), "1", doc="number")
    y = Output((), "1", doc="sine")

    def outputs(self, u):
        return {"y": LIBRARY.sin(u)}
'''
NOTE = (
    "Sine runs as a Python FMU, slower: outputs: math.sin(u) (sine.py, line 13) takes the number "
    "of a value that is known only when the FMU runs; write np.sin instead of math.sin"
)


def sine(folder: Path, library: str) -> str:
    path = folder / "sine.py"
    path.write_text(SOURCE.replace("LIBRARY", library), encoding="utf-8")
    return f"{path}:Sine"


def test_a_block_that_cannot_be_traced_gets_a_python_fmu_and_says_why_cached_or_not(
    tmp_path: Path,
) -> None:
    reference = sine(tmp_path, "math")
    notes: list[str] = []
    begun: list[int] = []
    paths = [build(reference, note=notes.append, begun=lambda: begun.append(1)) for _ in range(2)]
    assert notes == [NOTE, NOTE]
    assert begun == [1]
    assert paths == [build(reference, target="python")] * 2


def test_a_block_that_can_be_traced_gets_a_native_fmu_cached_or_not(tmp_path: Path) -> None:
    notes: list[str] = []
    native = build(sine(tmp_path, "np"), target="native")
    assert build(sine(tmp_path, "np"), note=notes.append) == native
    assert notes == []


@pytest.mark.parametrize("library", ["np", "math"])
def test_a_python_fmu_that_was_asked_for_needs_no_reason(tmp_path: Path, library: str) -> None:
    notes: list[str] = []
    build(sine(tmp_path, library), target="python", note=notes.append)
    assert notes == []
