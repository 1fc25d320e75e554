"""All FMUs of the catalogue pass: Python and native, FMI 2.0 and FMI 3.0, against each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import pytest

from sightline.components.catalogue import blocks
from sightline.fmus.build import build
from sightline.fmus.verify.bench import Options, Workshop, verify

EFFORT = 0.02  # enough for every check; `sightline verify` tries fifty times as much
ON_THE_BLOCK = ("archive", "description", "dependencies", "calls.legal", "state.serialize",
                "inputs", "derivatives")  # fmt: skip
OTHERS: tuple[tuple[Literal["python", "native"], Literal[2, 3]], ...] = (
    ("native", 3), ("python", 2),
)  # fmt: skip
TYPICAL = ("FreeRigidBody", "KeplerOrbit", "LineOfSightSensor", "PulseModulator", "RangeSensor",
           "WaypointGuidance")  # with and without states, samples, noise, discrete states


@pytest.mark.parametrize("name", sorted(blocks()))
def test_native_fmu_of_a_block_passes_every_check(
    name: str, shop: Workshop, fmu_cache: None
) -> None:
    (report,) = verify([build(name, target="native")], Options(effort=EFFORT), shop=shop)
    assert report.failures == ()


@pytest.mark.parametrize("name", sorted(blocks()))
def test_other_fmus_of_a_block_pass_and_agree_with_it(
    name: str, shop: Workshop, fmu_cache: None
) -> None:
    """Checks whose answer depends on the block: the others look at the runtimes."""
    assert _failures(name, ON_THE_BLOCK, shop) == []


@pytest.mark.parametrize("name", TYPICAL)
def test_other_fmus_of_typical_blocks_pass_every_check(
    name: str, shop: Workshop, fmu_cache: None
) -> None:
    assert _failures(name, (), shop) == []


def _failures(name: str, only: Sequence[str], shop: Workshop) -> list[str]:
    """What fails in the FMUs of other targets and versions, by themselves and against the first."""
    lead = build(name, target="native")
    others = [build(name, target=target, fmi=fmi) for target, fmi in OTHERS]
    compared = list(verify([lead, *others], Options(("agreement",), effort=EFFORT), shop=shop))
    assert [r.result("agreement").tried for r in compared[1:]] == [{"FMUs": 1}, {"FMUs": 2}]
    alone = verify(others, Options(only, effort=EFFORT), shop=shop)
    reports = [*compared, *alone]
    return [f"FMI {r.version}: {f}" for r in reports for f in r.failures]
