"""FMUs for the tests of this folder, built once per session into a cache of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from sightline.components.catalogue import blocks
from sightline.fmus.build import build

USER_BLOCK = '''
import numpy as np
import sightline.components.maths as maths
from sightline.components import Component, Input, Output, Parameter, Noise, SamplePeriod
from sightline.components import DiscreteState, State


class UserBlock(Component):
    """A block of a user's own: counts its ticks, integrates its input, adds noise."""

    force = Input(3, "N", frame="body", doc="input")
    level = Input((), "m", min=-10.0, max=10.0, doc="limited input")
    gain = Parameter((), "1/kg", 2.0, tunable=True, doc="gain")
    ticks = DiscreteState((), "1", output=True, doc="ticks so far")
    speed = State(3, "m/s", output=True, doc="integral of the input")
    pull = Output(3, "N", frame="body", doc="input with noise, at ticks")
    noise = Noise(3, doc="white noise")
    sample_period = SamplePeriod(start=0.1)

    def derivatives(self, force, gain):
        return {"speed": gain * force + maths.cross(force, force)}

    def outputs(self, force, noise, level):
        return {"pull": force + noise + np.sqrt(level)}

    def update(self, ticks):
        return {"ticks": ticks + 1.0}
'''


@pytest.fixture(scope="session")
def user_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A block in a file outside the project."""
    path = tmp_path_factory.mktemp("user") / "user_block.py"
    path.write_text(USER_BLOCK, encoding="utf-8")
    return path


@pytest.fixture(params=sorted(blocks()), scope="session")
def python_fmu(request: pytest.FixtureRequest, fmu_cache: None) -> Path:
    """The Python FMU of each block of the catalogue."""
    return build(request.param, target="python")


@pytest.fixture(scope="session")
def body_fmu(fmu_cache: None) -> Path:
    """The Python FMU of the free rigid body."""
    return build("FreeRigidBody", target="python")


@pytest.fixture(scope="session")
def user_fmu(user_file: Path, fmu_cache: None) -> Path:
    """The Python FMU of the user's block."""
    return build(f"{user_file}:UserBlock", target="python")
