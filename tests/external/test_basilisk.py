"""The free rigid body against Basilisk's spacecraft: other code, other attitude coordinates."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.orchestrator.fmi.archive import read

STEP, STOP = 0.01, 60.0  # s
MASS = 10.0
INERTIA = np.array([[0.116, -0.032, 0.0010], [-0.032, 0.109, 0.00014], [0.0010, 0.00014, 0.114]])
POSITION, VELOCITY = np.array([1.0, 2.0, 3.0]), np.array([0.1, -0.2, 0.3])
RODRIGUES = np.array([0.1, 0.2, -0.3])  # modified Rodrigues parameters, body to inertial
ANGULAR_VELOCITY = np.array([0.3, -0.2, 0.1])
FORCE, TORQUE = np.array([0.01, 0.02, -0.03]), np.array([1e-3, -2e-3, 5e-4])


def quaternions(rodrigues: np.ndarray) -> np.ndarray:
    """Unit quaternions, scalar last and not negative, of rows of modified Rodrigues parameters."""
    square = np.sum(rodrigues**2, axis=1, keepdims=True)
    return _one_sign(np.hstack([2.0 * rodrigues, 1.0 - square]) / (1.0 + square))


def _one_sign(quaternions: np.ndarray) -> np.ndarray:
    return quaternions * np.where(quaternions[:, 3:] < 0.0, -1.0, 1.0)


@pytest.fixture(scope="module")
def basilisk() -> dict[str, np.ndarray]:
    """Basilisk's trajectory: RK4 with the same step."""
    from Basilisk.simulation import extForceTorque, spacecraft, svIntegrators
    from Basilisk.utilities import SimulationBaseClass, macros

    def column(vector: np.ndarray) -> list[list[float]]:
        return [[float(x)] for x in vector]

    simulation = SimulationBaseClass.SimBaseClass()
    task = simulation.CreateNewTask("task", macros.sec2nano(STEP))
    simulation.CreateNewProcess("process").addTask(task)
    craft = spacecraft.Spacecraft()
    craft.hub.mHub, craft.hub.IHubPntBc_B = MASS, INERTIA.tolist()
    craft.hub.r_CN_NInit, craft.hub.v_CN_NInit = column(POSITION), column(VELOCITY)
    craft.hub.sigma_BNInit, craft.hub.omega_BN_BInit = column(RODRIGUES), column(ANGULAR_VELOCITY)
    wrench = extForceTorque.ExtForceTorque()
    wrench.extForce_B, wrench.extTorquePntB_B = column(FORCE), column(TORQUE)
    craft.addDynamicEffector(wrench)
    integrator = svIntegrators.svIntegratorRK4(craft)
    craft.setIntegrator(integrator)
    recorder = craft.scStateOutMsg.recorder()
    for model in (craft, wrench, recorder):
        simulation.AddModelToTask("task", model)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(STOP))
    simulation.ExecuteSimulation()
    return {
        "position": recorder.r_BN_N,
        "velocity": recorder.v_BN_N,
        "attitude": quaternions(recorder.sigma_BN),
        "angular_velocity": recorder.omega_BN_B,
    }


@pytest.fixture(scope="module")
def ours() -> dict[str, np.ndarray]:
    """The native FMU's trajectory."""
    path: Path = build("FreeRigidBody", target="native")
    ports = read(path).ports
    start = {
        "mass": [MASS], "inertia": INERTIA.ravel(), "position": POSITION, "velocity": VELOCITY,
        "attitude": quaternions(RODRIGUES[np.newaxis])[0], "angular_velocity": ANGULAR_VELOCITY,
        "force": FORCE, "torque": TORQUE,
    }  # fmt: skip
    states = ("position", "velocity", "attitude", "angular_velocity")
    result = fmpy.simulate_fmu(
        str(path),
        fmi_type="CoSimulation",
        stop_time=STOP,
        step_size=STEP,
        output_interval=STEP,
        start_values={
            label: value
            for name, values in start.items()
            for label, value in zip(ports[name].labels(), values, strict=True)
        },
        output=[label for name in states for label in ports[name].labels()],
    )
    rows = {n: np.column_stack([result[x] for x in ports[n].labels()]) for n in states}
    return rows | {"attitude": _one_sign(rows["attitude"])}


@pytest.mark.parametrize("state", ["position", "velocity", "attitude", "angular_velocity"])
def test_a_forced_and_tumbling_body_moves_as_in_basilisk(
    state: str, ours: dict[str, np.ndarray], basilisk: dict[str, np.ndarray]
):
    size = np.max(np.abs(basilisk[state]))

    assert ours[state].shape == (round(STOP / STEP) + 1, basilisk[state].shape[1])
    # RK4 in quaternions here, in Rodrigues parameters there: (|Ω|h/2)^5/120 in each of 6000 steps
    assert np.max(np.abs(ours[state] - basilisk[state])) <= 1e-9 * size
