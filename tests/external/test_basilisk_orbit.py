"""Orbits of a chief and its deputy, about a point mass and an oblate planet, against Basilisk's."""

from __future__ import annotations

from pathlib import Path

import fmpy
import numpy as np
import pytest

from sightline.fmus.build import build
from sightline.orchestrator import Builder

STEP, STOP, EVERY = 1.0, 57200.0, 100  # s, s, steps from sample to sample
MU, RADIUS = 3.986004418e14, 6378137.0  # m3/s2, m
POSITION = np.array([6.718137e6, 0.0, 0.0])  # m; perigee of an ellipse of 95 min
VELOCITY = np.array([0.0, 5.0e3, 6.0e3])  # m/s
OFFSET, DRIFT = np.array([1e3, -1e3, 2e3]), np.array([0.5, -1.0, 0.2])  # m, m/s; the deputy's
DEGREE_TWO = """{radius:.17g},{mu:.17g},0,2,2,1,0,0
0,0,1,0
1,0,0,0
1,1,0,0
2,0,{c20:.17g},0
2,1,0,0
2,2,0,0
"""


@pytest.fixture(scope="module", params=[0.0, 1.08262668e-3], ids=["point mass", "oblate"])
def oblateness(request: pytest.FixtureRequest) -> float:
    """J2 of the planet."""
    return float(request.param)


@pytest.fixture(scope="module")
def harmonics(oblateness: float, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The planet's gravity as a file of normalised spherical harmonics."""
    path = tmp_path_factory.mktemp("planet") / "degree_two.txt"
    text = DEGREE_TWO.format(radius=RADIUS, mu=MU, c20=-oblateness / np.sqrt(5.0))
    path.write_text(text, encoding="utf-8")
    return path


def basilisk(harmonics: Path, position: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Basilisk's positions and velocities: RK4 with the same step."""
    from Basilisk.simulation import gravityEffector, spacecraft, svIntegrators
    from Basilisk.utilities import SimulationBaseClass, macros

    simulation = SimulationBaseClass.SimBaseClass()
    task = simulation.CreateNewTask("task", macros.sec2nano(STEP))
    simulation.CreateNewProcess("process").addTask(task)
    craft = spacecraft.Spacecraft()
    planet = gravityEffector.GravBodyData()
    planet.planetName, planet.mu, planet.radEquator, planet.isCentralBody = "p", MU, RADIUS, True
    planet.useSphericalHarmonicsGravityModel(str(harmonics), 2)
    craft.gravField.gravBodies = spacecraft.GravBodyVector([planet])
    craft.hub.r_CN_NInit = [[float(x)] for x in position]
    craft.hub.v_CN_NInit = [[float(x)] for x in velocity]
    integrator = svIntegrators.svIntegratorRK4(craft)
    craft.setIntegrator(integrator)
    recorder = craft.scStateOutMsg.recorder(macros.sec2nano(EVERY * STEP))
    for model in (craft, recorder):
        simulation.AddModelToTask("task", model)
    simulation.InitializeSimulation()
    simulation.ConfigureStopTime(macros.sec2nano(STOP))
    simulation.ExecuteSimulation()
    return np.hstack([recorder.r_BN_N, recorder.v_BN_N])


@pytest.fixture(scope="module", params=["native", "python"])
def ours(request: pytest.FixtureRequest, oblateness: float) -> np.ndarray:
    """The FMU's positions and velocities."""
    path: Path = build("TwoBodyOrbit", target=request.param)
    start = {"oblateness": oblateness, "equatorial_radius": RADIUS, "gravitational_parameter": MU}
    for name, vector in (("position", POSITION), ("velocity", VELOCITY)):
        start |= {f"{name}[{i + 1}]": value for i, value in enumerate(vector)}
    result = fmpy.simulate_fmu(
        str(path), fmi_type="CoSimulation", stop_time=STOP, step_size=EVERY * STEP,
        output_interval=EVERY * STEP, start_values=start,
        output=[f"{name}[{i}]" for name in ("position", "velocity") for i in (1, 2, 3)],
    )  # fmt: skip
    return np.column_stack([result[name] for name in result.dtype.names[1:]])


@pytest.fixture(scope="module")
def chief(harmonics: Path) -> np.ndarray:
    """The chief's positions and velocities in Basilisk."""
    return basilisk(harmonics, POSITION, VELOCITY)


def test_an_orbit_of_ten_revolutions_is_that_of_basilisk(
    ours: np.ndarray, chief: np.ndarray
) -> None:
    assert ours.shape == chief.shape == (round(STOP / STEP / EVERY) + 1, 6)
    # the same RK4 of the same equations: roundings, which grow along the track to 1e-5 m
    np.testing.assert_allclose(ours[:, :3], chief[:, :3], rtol=0, atol=1e-4)  # m
    np.testing.assert_allclose(ours[:, 3:], chief[:, 3:], rtol=0, atol=1e-7)  # m/s


def test_a_deputy_moves_as_the_difference_of_two_craft_in_basilisk(
    oblateness: float, harmonics: Path, chief: np.ndarray
) -> None:
    planet = {"oblateness": oblateness, "equatorial_radius": RADIUS, "gravitational_parameter": MU}
    builder = Builder(stop_time=STOP, step=STEP, coupling="quadratic")
    builder.record(every=EVERY * STEP)
    builder.add("chief", "TwoBodyOrbit", parameters=planet,
                start={"position": POSITION.tolist(), "velocity": VELOCITY.tolist()})
    builder.add("deputy", "RelativeOrbit", parameters=planet,
                start={"relative_position": OFFSET.tolist(), "relative_velocity": DRIFT.tolist()})
    builder.connect("chief.position -> deputy.chief_position",
                    "chief.velocity -> deputy.chief_velocity")
    results = builder.system().simulate()

    expected = basilisk(harmonics, POSITION + OFFSET, VELOCITY + DRIFT) - chief
    assert np.max(np.linalg.norm(expected[:, :3], axis=1)) > 5e4  # m; they have drifted far apart
    np.testing.assert_allclose(results["deputy.relative_position"], expected[:, :3], rtol=0,
                               atol=1e-3)  # m; roundings of two absolute orbits
    np.testing.assert_allclose(results["deputy.relative_velocity"], expected[:, 3:], rtol=0,
                               atol=1e-6)  # m/s
