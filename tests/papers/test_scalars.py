"""The small algebra under the papers' equations, against numpy, and the equations on other scalars than numbers."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.papers import scalars


def rows(matrix):
    return tuple(tuple(row) for row in matrix.tolist())


def test_products_and_solutions(rng):
    for _ in range(20):
        a, x, y = rng.normal(size=(3, 3)), rng.normal(size=3), rng.normal(size=3)
        np.testing.assert_allclose(scalars.dot(x, y), x @ y, rtol=0, atol=1e-14)
        np.testing.assert_allclose(scalars.cross(x, y), np.cross(x, y), rtol=0, atol=1e-14)
        np.testing.assert_allclose(scalars.times(rows(a), x), a @ x, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(scalars.transposed(rows(a)), a.T)
        np.testing.assert_allclose(scalars.symmetric(scalars.gram(rows(a))), a.T @ a, rtol=0, atol=1e-14)
        np.testing.assert_allclose(a @ scalars.inverse(rows(a)), np.eye(3), rtol=0, atol=1e-11)
        spd = a.T @ a + np.eye(3)
        entries = (spd[0, 0], spd[0, 1], spd[0, 2], spd[1, 1], spd[1, 2], spd[2, 2])
        np.testing.assert_allclose(spd @ scalars.solve_symmetric(entries, x), x, rtol=0, atol=1e-13)


def test_both_roots_of_a_two_link_limb(rng):
    for u, w, part in rng.uniform(-1, 1, size=(20, 3)):
        k = 0.95 * part * np.hypot(u, w)
        angles = [scalars.two_link_angle(u, w, k, sign) for sign in (1, -1)]
        for angle, sign in zip(angles, (1, -1), strict=True):
            assert u * np.cos(angle) + w * np.sin(angle) == pytest.approx(k, abs=1e-14)
            assert np.sign(u * np.sin(angle) - w * np.cos(angle)) == sign
