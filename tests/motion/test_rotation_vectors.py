"""Rates of rotation vectors against those of scipy's rotations, for small and large ones."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cutjoint.motion.rotation_vectors import RightJacobian, product, quaternion_of_vector, triple

SIZES = [0.0, 1e-12, 1e-7, 1e-4, 1e-2, 0.3, 1.0, 2.5, 3.1, 3.2, 5.0, 6.5, 20.0]


@pytest.fixture(params=SIZES)
def vectors(request):
    """Rotation vector of one size, its rate and another vector."""
    rng = np.random.default_rng(int(10 * request.param))
    direction = rng.normal(size=3)
    return request.param * direction / np.linalg.norm(direction), rng.normal(size=3), rng.normal(size=3)


def test_it_turns_as_the_rotation_does(vectors):
    phi, rate, _ = vectors
    h = 1e-4

    def turn(s):
        return (Rotation.from_rotvec(phi).inv() * Rotation.from_rotvec(phi + s * rate)).as_rotvec()

    wanted = (8.0 * (turn(h) - turn(-h)) - turn(2 * h) + turn(-2 * h)) / (12.0 * h)
    assert np.allclose(RightJacobian(tuple(phi.tolist())).times(tuple(rate)), wanted, rtol=0.0, atol=1e-10)


def test_its_change_is_its_derivative(vectors):
    phi, rate, other = vectors
    h = 1e-4

    def at(s):
        return np.array(RightJacobian(tuple((phi + s * rate).tolist())).times(tuple(other)))

    wanted = (8.0 * (at(h) - at(-h)) - at(2 * h) + at(-2 * h)) / (12.0 * h)
    found = RightJacobian(tuple(phi.tolist())).change(tuple(rate), tuple(other))
    assert np.allclose(found, wanted, rtol=0.0, atol=1e-10)


@pytest.mark.parametrize("size", [one for one in SIZES if one < 6.0])
def test_solving_is_the_inverse(size):
    rng = np.random.default_rng(int(10 * size))
    direction, rate = rng.normal(size=(2, 3))
    phi = size * direction / np.linalg.norm(direction)
    jacobian = RightJacobian(tuple(phi.tolist()))
    assert np.allclose(jacobian.solve(jacobian.times(tuple(rate))), rate, rtol=0.0, atol=1e-13)


def test_many_are_as_one():
    rng = np.random.default_rng(0)
    phi, rate, other = rng.uniform(-1.7, 1.7, (3, 3, 40))
    whole = RightJacobian(triple(phi))
    for k in range(40):
        one = RightJacobian(tuple(phi[:, k].tolist()))
        v, w = tuple(rate[:, k].tolist()), tuple(other[:, k].tolist())
        assert np.allclose(np.array(whole.times(triple(rate)))[:, k], one.times(v), rtol=0.0, atol=1e-14)
        assert np.allclose(np.array(whole.solve(triple(rate)))[:, k], one.solve(v), rtol=0.0, atol=1e-14)
        assert np.allclose(
            np.array(whole.change(triple(rate), triple(other)))[:, k], one.change(v, w), rtol=0.0, atol=1e-13
        )


def test_products_of_quaternions_are_scipys():
    one, two = Rotation.random(2, random_state=0)
    found = Rotation.from_quat(product(tuple(one.as_quat()), tuple(two.as_quat())))
    assert np.allclose(found.as_matrix(), (one * two).as_matrix(), rtol=0.0, atol=1e-14)
    vector = one.as_rotvec()
    found = Rotation.from_quat(quaternion_of_vector(tuple(vector)))
    assert np.allclose(found.as_matrix(), one.as_matrix(), rtol=0.0, atol=1e-14)
