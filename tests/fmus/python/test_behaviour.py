"""A Python FMU, run alone, does what its block does; and nothing it is given breaks it."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path

import fmpy
import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.stats import kstest

from sightline.components.actuation.thruster_allocation import ThrusterAllocation
from sightline.components.dynamics.free_rigid_body import FreeRigidBody
from sightline.components.sensors.line_of_sight_sensor import LineOfSightSensor
from sightline.fmus.build import build

from .slaves import Slave, instantiate, loaded

INERTIA = np.array([[0.116, -0.032, 0.001], [-0.032, 0.109, 0.00014], [0.001, 0.00014, 0.114]])


@pytest.fixture
def body(body_fmu: Path):
    with loaded(body_fmu) as (description, folder):
        yield instantiate(description, folder)


@pytest.fixture
def user(user_fmu: Path):
    with loaded(user_fmu) as (description, folder):
        yield instantiate(description, folder)


def test_simulated_by_fmpy_the_rigid_body_follows_scipy(body_fmu: Path) -> None:
    block = FreeRigidBody()
    values = block.start_values() | {
        "inertia": INERTIA, "mass": np.array(10.0), "force": np.array([1.0, 2.0, 3.0]),
        "torque": np.array([0.01, 0.0, -0.02]), "angular_velocity": np.array([0.3, -0.2, 0.5]),
    }
    names = ("position", "velocity", "attitude", "angular_velocity")
    sizes = np.cumsum([3, 3, 4])

    def rate(t: float, x: np.ndarray) -> np.ndarray:
        state = dict(zip(names, np.split(x, sizes), strict=True))
        rates = block.evaluate("derivatives", values | state)
        return np.concatenate([rates[n] for n in names])

    truth = solve_ivp(rate, (0, 2), np.concatenate([values[n] for n in names]),
                      method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    start = {f"{p}[{i + 1}]": v for p in ("force", "torque", "angular_velocity")
             for i, v in enumerate(values[p])}
    start |= {f"inertia[{i + 1},{j + 1}]": INERTIA[i, j] for i in range(3) for j in range(3)}
    result = fmpy.simulate_fmu(str(body_fmu), stop_time=2.0, step_size=0.01, output_interval=2.0,
                               start_values=start | {"mass": 10.0})
    final = result[-1]
    ours = [final[f"{n}[{i + 1}]"] for n in names for i in range(values[n].size)]
    np.testing.assert_allclose(ours, truth, rtol=0, atol=2e-9)  # RK4 at 10 ms: h^4 / 5!


def test_the_adaptive_solver_meets_its_tolerance(body: Slave) -> None:
    body.set(inertia=INERTIA, angular_velocity=[0.3, -0.2, 0.5], relative_tolerance=1e-12,
             absolute_tolerance=1e-14)
    body.fmu.setInteger(body.references["solver"], [2])
    body.initialise()
    before = INERTIA @ [0.3, -0.2, 0.5]
    body.fmu.doStep(0.0, 20.0)
    after = INERTIA @ body.get("angular_velocity")
    assert np.linalg.norm(after) == pytest.approx(np.linalg.norm(before), rel=1e-10)


def test_outputs_follow_inputs_that_are_set_after_the_step(fmu_cache: None) -> None:
    block = LineOfSightSensor()
    with loaded(build("LineOfSightSensor", target="python")) as (description, folder):
        sensor = instantiate(description, folder)
        sensor.initialise()
        sensor.fmu.doStep(0.0, 0.1)
        q = np.array([0.1, -0.3, 0.2, 0.9]) / math.sqrt(0.95)
        values = block.start_values() | {"target_position": np.array([3.0, 4.0, 5.0]),
                                         "attitude": q}
        sensor.set(target_position=values["target_position"], attitude=q)
        expected = block.evaluate("outputs", values)["line_of_sight"]
        np.testing.assert_array_equal(sensor.get("line_of_sight"), expected)


def test_the_allocation_fmu_equals_the_block_bit_for_bit(fmu_cache: None) -> None:
    block = ThrusterAllocation()
    force, torque = np.array([1.0, -2.0, 0.5]), np.array([0.1, 0.2, -0.3])
    expected = block.evaluate("outputs", block.start_values() | {"force": force, "torque": torque})
    with loaded(build("ThrusterAllocation", target="python")) as (description, folder):
        fmu = instantiate(description, folder)
        fmu.set(force=force, torque=torque)
        fmu.initialise()
        np.testing.assert_array_equal(fmu.get("command"), expected["command"])


def test_ticks_fall_on_multiples_of_the_period(user: Slave) -> None:
    user.initialise()
    counts = []
    for i in range(10):
        user.fmu.doStep(i * 0.07, 0.07)
        counts.append(int(user.get("ticks")[0]))
    # ticks at 0, 0.1, ..., 0.6 have departed at 0.07, 0.14, ..., 0.70 (0.70's own is pending)
    assert counts == [1, 2, 3, 3, 4, 5, 5, 6, 7, 7]


def test_one_long_step_takes_every_tick(user: Slave) -> None:
    user.initialise()
    user.fmu.doStep(0.0, 1.05)
    assert user.get("ticks")[0] == 11


def test_noise_does_not_depend_on_the_communication_step(user_fmu: Path) -> None:
    series = []
    for step, every in ((0.1, 1), (0.025, 4), (0.05, 2)):
        with loaded(user_fmu) as (description, folder):
            slave = instantiate(description, folder)
            slave.initialise()
            rows = []
            for i in range(20 * every):
                slave.fmu.doStep(i * step, step)
                if (i + 1) % every == 0:
                    rows.append(slave.get("pull"))
            series.append(rows)
    np.testing.assert_array_equal(series[0], series[1])
    np.testing.assert_array_equal(series[0], series[2])


def test_noise_differs_between_instances_seeds_and_axes(user_fmu: Path) -> None:
    rows = []
    with loaded(user_fmu) as (description, folder):
        for name, seed in (("one", 1), ("two", 1), ("one", 2)):
            slave = instantiate(description, folder, name)
            slave.fmu.setInteger(slave.references["seed"], [seed])
            slave.initialise()
            rows.append(slave.get("pull"))
    assert np.unique(rows).size == 9


def test_noise_is_normal(user: Slave) -> None:
    user.initialise()
    rows = []
    for i in range(1000):
        user.fmu.doStep(i * 0.1, 0.1)
        rows.append(user.get("pull"))
    assert kstest(np.ravel(rows), "norm").pvalue > 0.01


def trajectory(slave: Slave, first: int, last: int) -> list[float]:
    values: list[float] = []
    for i in range(first, last):
        slave.set(force=[math.sin(i), 1.0, -0.5 * i])
        slave.fmu.doStep(i * 0.07, 0.07)
        values += [*slave.get("speed"), *slave.get("pull"), *slave.get("ticks")]
    return values


def test_a_restored_state_continues_bit_for_bit(user: Slave) -> None:
    user.initialise()
    trajectory(user, 0, 13)
    state = user.fmu.getFMUstate()
    first = trajectory(user, 13, 40)
    user.fmu.setFMUstate(state)
    assert trajectory(user, 13, 40) == first


def test_a_serialised_state_continues_in_a_new_process(user: Slave, user_fmu: Path) -> None:
    user.initialise()
    trajectory(user, 0, 13)
    data = user.fmu.serializeFMUstate(user.fmu.getFMUstate())
    expected = trajectory(user, 13, 20)
    script = f"""
import json, math, sys
sys.modules["sightline"] = None  # the FMU must not need the installed package
sys.path.insert(0, {str(Path(__file__).parent)!r})
from slaves import instantiate, loaded
from pathlib import Path
with loaded(Path({str(user_fmu)!r})) as (description, folder):
    slave = instantiate(description, folder)
    slave.initialise()
    slave.fmu.setFMUstate(slave.fmu.deSerializeFMUstate(bytes.fromhex({data.hex()!r})))
    values = []
    for i in range(13, 20):
        slave.set(force=[math.sin(i), 1.0, -0.5 * i])
        slave.fmu.doStep(i * 0.07, 0.07)
        values += [*slave.get("speed"), *slave.get("pull"), *slave.get("ticks")]
print(json.dumps(values))
"""
    output = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True).stdout
    assert json.loads(output) == expected


def test_fmus_of_two_blocks_and_instances_of_one_live_in_one_process(fmu_cache: None) -> None:
    with loaded(build("Gyro", target="python")) as first, \
            loaded(build("FreeRigidBody", target="python")) as second:
        slaves = [instantiate(*first, "a"), instantiate(*second, "b"), instantiate(*first, "c")]
        slaves[0].set(angular_velocity=[1.0, 2.0, 3.0])
        slaves[1].set(angular_velocity=[4.0, 5.0, 6.0])
        for slave in slaves:
            slave.initialise()
        assert slaves[0].get("measured_angular_velocity").tolist() == [1.0, 2.0, 3.0]
        assert slaves[1].get("angular_velocity").tolist() == [4.0, 5.0, 6.0]
        assert slaves[2].get("measured_angular_velocity").tolist() == [0.0, 0.0, 0.0]


def test_reset_gives_the_start_values(body: Slave) -> None:
    body.set(angular_velocity=[1.0, 2.0, 3.0])
    body.initialise()
    body.fmu.doStep(0.0, 0.1)
    body.fmu.reset()
    assert body.get("angular_velocity").tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"mass": math.nan}, "mass = nan: must be finite"),
        ({"mass": -1.0}, "mass = -1: must be at least 1e-09"),
        ({"inertia": np.zeros((3, 3))}, "inertia must be positive definite"),
        ({"inertia": np.diag([1.0, 1.0, 3.0])},
         "inertia must satisfy the triangle inequality of its principal moments"),
        ({"inertia": [[1, 0.5, 0], [0, 1, 0], [0, 0, 1]]}, "inertia must be symmetric"),
        ({"attitude": [0, 0, 0, 2]}, "attitude must be a unit quaternion"),
    ],
)
def test_wrong_parameters_are_refused_at_initialisation(
    body: Slave, values: dict[str, object], message: str
) -> None:
    body.set(**values)
    with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
        body.initialise()
    assert message in "\n".join(body.log)


def test_a_nan_input_discards_the_step_and_is_named(body: Slave) -> None:
    body.initialise()
    body.set(force=[0.0, math.nan, 0.0])
    with pytest.raises(Exception, match="fmi2DoStep failed with status 2"):
        body.fmu.doStep(0.0, 0.1)
    assert body.log == ["force[2] = nan: must be finite"]


def test_an_input_out_of_range_discards_the_step(user: Slave) -> None:
    user.initialise()
    user.set(level=11.0)
    with pytest.raises(Exception, match="fmi2DoStep failed with status 2"):
        user.fmu.doStep(0.0, 0.1)
    assert user.log == ["level = 11: must be at most 10"]


def test_a_result_that_is_not_a_number_is_an_error_not_a_value(user: Slave) -> None:
    user.initialise()
    user.set(level=-4.0)
    with pytest.raises(Exception, match="fmi2GetReal"):
        user.get("pull")
    assert "pull is not finite" in "\n".join(user.log)


def test_a_zero_line_of_sight_discards_the_step(fmu_cache: None) -> None:
    with loaded(build("LineOfSightSensor", target="python")) as (description, folder):
        sensor = instantiate(description, folder)
        sensor.initialise()
        sensor.set(target_position=[0.0, 0.0, 0.0])
        with pytest.raises(Exception, match="fmi2DoStep failed with status 2"):
            sensor.fmu.doStep(0.0, 0.1)
        assert "target_position must differ from position" in sensor.log


def test_a_failed_instance_can_be_freed(body_fmu: Path) -> None:
    script = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from slaves import instantiate, loaded
from pathlib import Path
with loaded(Path({str(body_fmu)!r})) as (description, folder):
    for _ in range(20):
        slave = instantiate(description, folder)
        slave.set(mass=-1.0)
        try:
            slave.initialise()
        except Exception:
            slave.fmu.freeInstance()
print("alive")
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "alive\n"), done.stderr


def test_freed_instances_leave_next_to_nothing(body_fmu: Path) -> None:
    """pythonfmu itself keeps the name of the resources folder for each instance: one block."""
    script = f"""
import gc, sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from slaves import instantiate, loaded
from pathlib import Path

def left(count):
    gc.collect()
    before = sys.getallocatedblocks()
    for _ in range(count):
        instantiate(description, folder).fmu.freeInstance()
    gc.collect()
    return sys.getallocatedblocks() - before

with loaded(Path({str(body_fmu)!r})) as (description, folder):
    left(100)
    searched = list(sys.path)
    rounds = [left(300) for _ in range(5)]  # of which some have to do with caches of Python's
    print(min(rounds) < 1.5 * 300, sys.path == searched)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "True True\n"), done.stderr
