"""Native FMUs for the tests of this folder, each built once per session."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from sightline.components import Component
from sightline.components.catalogue import blocks
from sightline.fmus.native.target import compiler_available

from .blocks import Everything, Gain, Iterating, Oscillator
from .driver import Fmi, Native

OWN = {c.__name__: c for c in (Everything, Oscillator, Gain, Iterating)}
ALL: dict[str, type[Component]] = {**OWN, **blocks()}
Builder = Callable[[str, Fmi], Native]


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    assert compiler_available(), "the tests of the native target need a C compiler"


@pytest.fixture(scope="session")
def native(tmp_path_factory: pytest.TempPathFactory) -> Builder:
    """The FMU of a block by name, built on first use."""
    root: Path = tmp_path_factory.mktemp("native")
    built: dict[tuple[str, Fmi], Native] = {}

    def build(name: str, fmi: Fmi) -> Native:
        if (name, fmi) not in built:
            built[name, fmi] = Native.build(ALL[name](), fmi, root)
        return built[name, fmi]

    return build


@pytest.fixture(params=[2, 3], ids=["fmi2", "fmi3"])
def fmi(request: pytest.FixtureRequest) -> Fmi:
    version: Fmi = request.param
    return version


EVERY = [(n, v) for n in sorted(ALL) for v in (2, 3)]


@pytest.fixture(params=EVERY, ids=lambda p: f"{p[0]}-{p[1]}")
def every_fmu(request: pytest.FixtureRequest, native: Builder) -> Native:
    """The FMU of every block, in both versions."""
    return native(*request.param)


SOME = (*OWN, "FreeRigidBody", "Gyro", "ThrusterCluster")
PARAMS = [pytest.param((n, v), id=f"{n}-{v}",
                       marks=[] if v == 2 or n in SOME else [pytest.mark.external])
          for n, v in EVERY]  # fmt: skip


@pytest.fixture(params=PARAMS)
def block_fmu(request: pytest.FixtureRequest, native: Builder) -> Native:
    """The FMU of every block; in FMI 3.0 of some, and of all with the external tests."""
    return native(*request.param)


@pytest.fixture
def everything(native: Builder, fmi: Fmi) -> Native:
    return native("Everything", fmi)


@pytest.fixture
def oscillator(native: Builder, fmi: Fmi) -> Native:
    return native("Oscillator", fmi)
