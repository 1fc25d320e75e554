"""What the documents of the examples say of `sightline verify` is what it says."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SWAP = Path(__file__).parent.parent / "examples" / "swap"
README = (SWAP / "README.md").read_text(encoding="utf-8")


@pytest.mark.skipif(
    shutil.which("cc") is None or sys.platform != "linux", reason="compiles an FMU for Linux"
)
def test_foreign_fmu_made_as_told_passes_and_fails_what_is_told(tmp_path: Path) -> None:
    folder = shutil.copytree(SWAP, tmp_path / "swap")
    commands = re.findall(r"```console\n(mkdir .*?)```", README, re.DOTALL)[0]
    subprocess.run(["sh", "-ec", commands], cwd=folder, check=True)

    call = [sys.executable, "-m", "sightline.orchestrator.cli", "verify", "foreign.fmu"]
    said = subprocess.run(call, cwd=folder, capture_output=True, text=True).stdout

    passed, failed = re.findall(r"(\d+) passed, (\d+) failed", said)[0]
    assert failed == "1"
    assert re.findall(r"FAILED +([\w.]+)", said) == ["calls.illegal"]
    assert f"{passed} pass and one, `calls.illegal`, fails" in " ".join(README.split())
    for told in ("NaN", "back in time", "value reference", "fixed parameter"):
        assert told in said
        assert told in README
