"""The free rigid body against invariants and closed forms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from sightline.components.dynamics.free_rigid_body import FreeRigidBody
from sightline.components.maths import rotate, unit

BODY = FreeRigidBody()
INERTIA = np.array([[0.116, -0.032, 0.0010], [-0.032, 0.109, 0.00014], [0.0010, 0.00014, 0.114]])
STATES = ("position", "velocity", "attitude", "angular_velocity")
SPLITS = (3, 6, 10)


def fly(duration, **values):
    """States after each of 20 equal parts of the duration, from the given values."""
    values = BODY.start_values() | {name: np.asarray(v, float) for name, v in values.items()}

    def rate(_, x):
        states = dict(zip(STATES, np.split(x, SPLITS), strict=True))
        rates = BODY.evaluate("derivatives", values | states)
        return np.concatenate([rates[name] for name in STATES])

    start = np.concatenate([values[name] for name in STATES])
    solution = solve_ivp(rate, (0.0, duration), start, "DOP853", rtol=1e-12, atol=1e-13,
                         t_eval=np.linspace(0.0, duration, 21))
    return solution.t, dict(zip(STATES, np.split(solution.y, SPLITS), strict=True))


def refused(**values):
    """Messages of the requirements that do not hold."""
    values = BODY.start_values() | {name: np.asarray(v, float) for name, v in values.items()}
    return [m for m, holds in BODY.evaluate("requirements", values).items() if not holds]


def test_inertial_angular_momentum_is_conserved_without_torque():
    _, x = fly(60.0, inertia=INERTIA, angular_velocity=[0.5, -1.0, 0.8])
    momentum = np.stack([rotate(unit(q), INERTIA @ w)
                         for q, w in zip(x["attitude"].T, x["angular_velocity"].T, strict=True)])
    np.testing.assert_allclose(momentum, np.tile(momentum[0], (21, 1)), atol=1e-11)


def test_kinetic_energy_is_conserved_without_torque():
    _, x = fly(60.0, inertia=INERTIA, angular_velocity=[0.5, -1.0, 0.8])
    w = x["angular_velocity"]
    energy = 0.5 * np.sum(w * (INERTIA @ w), axis=0)
    np.testing.assert_allclose(energy, energy[0], rtol=1e-11)


def test_the_quaternion_keeps_its_norm():
    _, x = fly(60.0, inertia=INERTIA, angular_velocity=[0.5, -1.0, 0.8])
    np.testing.assert_allclose(np.linalg.norm(x["attitude"], axis=0), 1.0, atol=1e-10)


def test_an_axisymmetric_body_precesses_as_in_closed_form():
    transverse, axial = 2.0, 1.0  # kg m2
    t, x = fly(20.0, inertia=np.diag([transverse, transverse, axial]),
               angular_velocity=[0.3, 0.0, 1.5])
    phase = (axial - transverse) / transverse * 1.5 * t  # body-frame precession
    expected = np.stack([0.3 * np.cos(phase), 0.3 * np.sin(phase), np.full_like(t, 1.5)])
    np.testing.assert_allclose(x["angular_velocity"], expected, atol=1e-11)


def test_an_axisymmetric_body_turns_as_in_closed_form():
    transverse, axial = 2.0, 1.0  # kg m2
    t, x = fly(20.0, inertia=np.diag([transverse, transverse, axial]),
               angular_velocity=[0.3, 0.0, 1.5])
    momentum = np.array([transverse * 0.3, 0.0, axial * 1.5])
    precession = Rotation.from_rotvec(np.outer(t, momentum / transverse))
    spin = Rotation.from_rotvec(np.outer((1.0 - axial / transverse) * 1.5 * t, [0.0, 0.0, 1.0]))
    np.testing.assert_allclose(Rotation.from_quat(x["attitude"].T).as_matrix(),
                               (precession * spin).as_matrix(), atol=1e-10)


def test_a_constant_force_gives_a_parabola():
    quarter_turn = Rotation.from_rotvec([0.0, 0.0, np.pi / 2])
    t, x = fly(10.0, mass=4.0, force=[2.0, 0.0, 0.0], disturbance_force=[0.0, 0.0, 1.0],
               attitude=quarter_turn.as_quat(), position=[1.0, 2.0, 3.0],
               velocity=[0.1, 0.2, 0.3])
    acceleration = np.array([0.0, 0.5, 0.25])  # body x points along inertial y
    expected = (np.array([1.0, 2.0, 3.0]) + np.outer(t, [0.1, 0.2, 0.3])
                + 0.5 * np.outer(t**2, acceleration))
    np.testing.assert_allclose(x["position"].T, expected, atol=1e-10)


def test_control_and_disturbance_torque_add():
    values = BODY.start_values() | {"torque": np.array([1.0, 2.0, 3.0]),
                                    "disturbance_torque": np.array([0.5, -1.0, 0.0])}
    rate = BODY.evaluate("derivatives", values)["angular_velocity"]
    np.testing.assert_array_equal(rate, [1.5, 1.0, 3.0])


def test_projection_restores_the_norm_of_the_quaternion():
    attitude = BODY.evaluate("project", {"attitude": np.array([0.0, 0.6, 0.0, 1.6])})["attitude"]
    assert np.linalg.norm(attitude) == pytest.approx(1.0, abs=1e-15)


@pytest.mark.parametrize(("inertia", "message"), [
    ([[1.0, 0.2, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], "inertia must be symmetric"),
    (np.diag([1.0, 1.0, 0.0]), "inertia must be positive definite"),
    (np.diag([1.0, -1.0, 1.0]), "inertia must be positive definite"),
    (np.diag([1.0, 1.0, 2.1]),
     "inertia must satisfy the triangle inequality of its principal moments"),
    (np.full((3, 3), np.nan), "inertia must be symmetric"),
])
def test_an_impossible_inertia_is_refused(inertia, message):
    assert message in refused(inertia=inertia)


def test_the_inertia_of_a_thin_plate_is_accepted():
    assert refused(inertia=np.diag([1.0, 1.0, 2.0])) == []


def test_an_attitude_that_is_not_a_unit_quaternion_is_refused():
    assert refused(attitude=[0.0, 0.0, 0.0, 1.1]) == ["attitude must be a unit quaternion"]
