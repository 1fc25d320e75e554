"""Runs of example 5.1 that several tools are compared with."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from .formation import Formation, Series, formation

STOP = 40.0  # s


@dataclass(frozen=True)
class Reference:
    """Our Jacobi run. ``tolerance``: what another tool's arithmetic of time may change."""

    system: Formation
    step: float
    count: int
    rows: Series
    tolerance: float


@pytest.fixture(
    scope="session",
    params=[
        pytest.param((0.01, 1e-12), id="10ms"),  # h is rounded: n·h, Σh and nanoseconds differ
        pytest.param((1 / 128, 0.0), id="128Hz"),  # h is exact: every bit must agree
    ],
)
def reference(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Reference:
    """Our run of the example at this step."""
    step, tolerance = request.param
    folder = tmp_path_factory.mktemp("formation")
    system = formation(folder, step, STOP)
    return Reference(system, step, round(STOP / step), system.run(folder / "run"), tolerance)
