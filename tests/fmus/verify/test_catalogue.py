"""All FMUs of the catalogue pass: Python and native, FMI 2.0 and FMI 3.0, against each other."""

from __future__ import annotations

from pathlib import Path

import pytest

from sightline.components.catalogue import blocks
from sightline.fmus.build import build
from sightline.fmus.verify.bench import Options, Workshop, verify

KINDS = (("native", 2), ("native", 3), ("python", 2))
EFFORT = 0.02  # enough for every check; `sightline verify` tries fifty times as much


@pytest.mark.parametrize("name", sorted(blocks()))
def test_fmus_of_a_block_pass_and_agree(name: str, shop: Workshop, fmu_cache: None) -> None:
    files: list[Path] = [build(name, target=t, fmi=f) for t, f in KINDS]  # type: ignore[arg-type]
    reports = list(verify(files, Options(effort=EFFORT), shop=shop))
    assert [f"{r.file.name}: {f}" for r in reports for f in r.failures] == []
    assert [r.result("agreement").tried for r in reports[1:]] == [{"FMUs": 1}, {"FMUs": 2}]
