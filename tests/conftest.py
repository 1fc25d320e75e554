"""A cache of built FMUs for the session, apart from the user's own; how much chance tries."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings

# the same examples at every run, or, with --hypothesis-profile=thorough, many that are new
settings.register_profile("usual", max_examples=25, derandomize=True, database=None)
settings.register_profile("thorough", max_examples=3000, database=None)
settings.load_profile("usual")


@pytest.fixture(scope="session", autouse=True)
def fmu_cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """SIGHTLINE_CACHE for the session, shared by its workers."""
    own = tmp_path_factory.getbasetemp()
    session = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SIGHTLINE_CACHE", str(session / "cache"))
        yield
