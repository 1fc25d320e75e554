"""Systems built and stepped in code: the same as their TOML, and errors that name what is wrong."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

import sightline.orchestrator
from sightline.orchestrator import Builder, ConfigError, System

from .test_run import BLOCKS

pytestmark = pytest.mark.usefixtures("fmu_cache")


@pytest.fixture
def builder(tmp_path: Path) -> Builder:
    """x' = -x, x(0) = 1."""
    build = Builder(folder=tmp_path, stop_time=1.0, step=0.1)
    build.add("control", f"{BLOCKS}:Gain", target="python", parameters={"k": np.float64(-1.0)})
    build.add("plant", f"{BLOCKS}:Integrator", target="python", start={"x": np.array(1.0)})
    build.connect("plant.x -> control.x", "control.y -> plant.u")
    return build


def test_results_are_arrays_with_units(builder) -> None:
    results = builder.system().simulate()
    np.testing.assert_allclose(results["plant.x"], 0.9 ** np.arange(11), rtol=1e-14)
    assert (results.unit("plant.x"), results.unit("control.y")) == ("m", "m/s")
    assert results.complete


def test_written_system_is_the_same_system(builder, tmp_path: Path) -> None:
    builder.record("plant.*", every=0.2)
    builder.plot("State", "plant.x", scale="log")
    builder.write(tmp_path / "written.toml")
    assert tomllib.loads((tmp_path / "written.toml").read_text(encoding="utf-8")) == builder.data
    one, other = (
        s.simulate() for s in (builder.system(), System.from_toml(tmp_path / "written.toml"))
    )
    np.testing.assert_array_equal(one["plant.x"], other["plant.x"])
    assert one.config == other.config


def test_all_mistakes_come_at_once(builder) -> None:
    builder.connect("plant.y -> control.x")
    builder.add("other", "FreeRigidBdy")
    with pytest.raises(ConfigError) as caught:
        builder.system()
    assert [str(p).partition(";")[0] for p in caught.value.problems] == [
        "instances.other.component: cannot be built: no block is named 'FreeRigidBdy'",
        'connection "plant.y -> control.x": plant (Integrator) has no port y',
        'connection "plant.y -> control.x": control.x is already driven by "plant.x -> control.x"',
    ]


def test_loop_of_ones_own_sees_every_step(builder) -> None:
    with builder.system().start() as running:
        seen = [(running.time, float(running["plant.x"]))]
        for time in running:
            seen.append((time, float(running["plant.x"])))
    results = builder.system().simulate()
    np.testing.assert_array_equal(seen, np.column_stack([results.time, results["plant.x"]]))


def test_steps_may_go_on_beyond_the_stop_time(tmp_path: Path) -> None:
    build = Builder(folder=tmp_path, stop_time=0.2, step=0.1)
    build.add("craft", "FreeRigidBody", start={"velocity": [1.0, 0.0, 0.0]})
    with build.system().start() as running:
        running.step(5)
        np.testing.assert_allclose(running["craft.position"], [0.5, 0.0, 0.0], rtol=1e-14)


def test_inputs_that_nothing_drives_are_set_while_running(tmp_path: Path) -> None:
    build = Builder(stop_time=1.0, step=0.5)
    build.add("plant", f"{BLOCKS}:Integrator", target="python")
    with build.system().start() as running:
        for rate in (1.0, 3.0):
            running.set("plant.u", rate)
            running.step()
        assert float(running["plant.x"]) == pytest.approx(2.0, rel=1e-15)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("plant.u", 1.0, "plant.u is driven by a connection"),
        ("plant.v", 1.0, "plant.v cannot be set while running; "),
        ("plnt.u", 1.0, "there is no instance plnt"),
        ("control.k", 1.0, "control.k cannot be set while running; "),
    ],
)
def test_what_cannot_be_set_is_refused(builder, name: str, value: float, message: str) -> None:
    with builder.system().start() as running, pytest.raises(ValueError, match=message):
        running.set(name, value)


def test_signal_that_is_not_recorded_is_named(builder) -> None:
    builder.record("plant.x")
    with builder.system().start() as running, pytest.raises(KeyError, match=r"is not recorded"):
        running["control.y"]


def test_public_names_are_these() -> None:
    assert sorted(sightline.orchestrator.__all__) == [
        "Builder", "ConfigError", "FmuError", "Problem", "RunError", "System",
    ]  # fmt: skip
    assert all(getattr(sightline.orchestrator, n) for n in sightline.orchestrator.__all__)
