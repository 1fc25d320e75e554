"""Rotation maths against scipy."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sightline.components import maths

RNG = np.random.default_rng(1)
QUATERNIONS = list(Rotation.random(5, rng=RNG).as_quat())
VECTORS = list(RNG.standard_normal((5, 3)))
PAIRS = list(zip(QUATERNIONS, VECTORS, strict=True))
EXACT = {"rtol": 0.0, "atol": 1e-14}  # a few roundings of numbers of order 1


@pytest.mark.parametrize(("q", "v"), PAIRS)
def test_rotate_turns_from_body_to_inertial(q, v):
    np.testing.assert_allclose(maths.rotate(q, v), Rotation.from_quat(q).apply(v), **EXACT)


@pytest.mark.parametrize(("q", "v"), PAIRS)
def test_rotate_inverse_turns_from_inertial_to_body(q, v):
    expected = Rotation.from_quat(q).apply(v, inverse=True)
    np.testing.assert_allclose(maths.rotate_inverse(q, v), expected, **EXACT)


@pytest.mark.parametrize("q", QUATERNIONS)
def test_a_rotation_does_not_depend_on_the_sign_of_the_quaternion(q):
    np.testing.assert_array_equal(maths.rotate(-q, VECTORS[0]), maths.rotate(q, VECTORS[0]))


@pytest.mark.parametrize(("p", "q"), list(zip(QUATERNIONS, QUATERNIONS[::-1], strict=True)))
def test_a_product_of_quaternions_is_the_product_of_rotations(p, q):
    expected = (Rotation.from_quat(p) * Rotation.from_quat(q)).as_matrix()
    product = Rotation.from_quat(maths.multiply(p, q)).as_matrix()
    np.testing.assert_allclose(product, expected, **EXACT)


@pytest.mark.parametrize("q", QUATERNIONS)
def test_a_quaternion_times_its_conjugate_is_the_identity(q):
    np.testing.assert_allclose(maths.multiply(q, maths.conjugate(q)), maths.IDENTITY, **EXACT)


@pytest.mark.parametrize(("q", "rate"), PAIRS)
def test_the_quaternion_rate_is_that_of_a_turn_in_the_body_frame(q, rate):
    h = 1e-5  # s; central difference, error h²/24 |rate|³
    ahead, behind = Rotation.from_rotvec(0.5 * h * rate), Rotation.from_rotvec(-0.5 * h * rate)
    turned = maths.multiply(q, ahead.as_quat()) - maths.multiply(q, behind.as_quat())
    np.testing.assert_allclose(maths.quaternion_rate(q, rate), turned / h, atol=1e-10)


@pytest.mark.parametrize("v", VECTORS)
def test_a_small_rotation_agrees_with_the_rotation_vector_to_second_order(v):
    angles = 1e-3 * VECTORS[0]  # rad; the difference is |angles|³/12
    expected = Rotation.from_rotvec(angles).apply(v)
    np.testing.assert_allclose(maths.small_rotation(angles, v), expected, atol=1e-9)


@pytest.mark.parametrize("v", VECTORS)
def test_a_small_rotation_keeps_the_norm(v):
    turned = maths.small_rotation(np.array([0.3, -0.2, 0.5]), v)
    assert np.linalg.norm(turned) == pytest.approx(np.linalg.norm(v), rel=1e-15)


@pytest.mark.parametrize(("a", "b"), list(zip(VECTORS, VECTORS[::-1], strict=True)))
def test_cross_is_that_of_numpy(a, b):
    np.testing.assert_array_equal(maths.cross(a, b), np.cross(a, b))


def test_cross_of_matrices_is_that_of_their_columns():
    a, b = np.stack(VECTORS, axis=1), np.stack(VECTORS[::-1], axis=1)
    np.testing.assert_array_equal(maths.cross(a, b), np.cross(a, b, axis=0))


@pytest.mark.parametrize(("a", "b"), [((6,), (6,)), ((4, 6), (6,)), ((6,), (6, 3)),
                                      ((4, 6), (6, 3))])  # fmt: skip
def test_a_product_is_that_of_numpy(a, b):
    left, right = RNG.standard_normal(a), RNG.standard_normal(b)
    np.testing.assert_allclose(maths.product(left, right), left @ right, rtol=1e-13)


def test_a_product_is_summed_in_order_without_fused_operations():
    rounded = np.array([1e16, 1.0, -1e16, 1.0])  # 1e16 + 1 is 1e16
    assert maths.product(rounded, np.ones(4)) == 1.0
    third = np.array([1.0 / 3.0, -1.0])  # 1/3 times 3 rounds to 1; fused, a remainder is left
    assert maths.product(third, np.array([3.0, 1.0])) == 0.0


def test_a_reciprocal_is_the_quotient_of_positive_numbers():
    np.testing.assert_array_equal(maths.reciprocal(np.array([4.0, 3.0])), [0.25, 1.0 / 3.0])


def test_leading_minors_are_the_determinants_of_the_leading_blocks():
    m = RNG.standard_normal((3, 3))
    expected = [np.linalg.det(m[:n, :n]) for n in (1, 2, 3)]
    np.testing.assert_allclose(np.stack(maths.leading_minors(m)), expected, rtol=1e-13)


@pytest.mark.parametrize(("norm", "accepted"), [(1.0, True), (1.0 + 1e-7, True), (1.001, False)])
def test_a_unit_vector_has_norm_one_within_tolerance(norm, accepted):
    assert maths.is_unit(norm * QUATERNIONS[0]) == accepted


@pytest.mark.parametrize("rotation", [
    *(Rotation.from_quat(q) for q in QUATERNIONS),
    *(Rotation.from_rotvec(angle * np.eye(3)[axis]) for axis in range(3)
      for angle in (1e-9, np.pi, np.pi - 1e-9)),
], ids=str)
def test_a_quaternion_is_that_of_its_matrix_at_any_angle(rotation):
    q = Rotation.from_quat(maths.from_matrix(rotation.as_matrix()))
    np.testing.assert_allclose(q.as_matrix(), rotation.as_matrix(), **EXACT)
