"""The small algebra under the papers' equations, against numpy, and the equations on other scalars than numbers."""

from __future__ import annotations

import numpy as np
import pytest

from cutjoint.papers import cpm, omega3, scalars
from cutjoint.papers.cpm import equations as cpm_equations
from cutjoint.papers.omega3 import equations as omega3_equations


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


def test_the_equations_take_symbols():
    """Nothing in the equations decides on a value: they can be written down once with symbols."""
    casadi = pytest.importorskip("casadi")
    q, v = casadi.SX.sym("q", 3), casadi.SX.sym("v", 3)
    tool, rates = tuple(q[i] for i in range(3)), tuple(v[i] for i in range(3))

    p = cpm.Parameters()
    limbs = cpm_equations.limbs(p, tool, cpm_equations.limb_angles(p, tool, (1, -1, 1), casadi), casadi)
    gamma = cpm_equations.gamma(limbs)
    force = cpm_equations.coriolis(p.coefficients, gamma, cpm_equations.gamma_dot(p, limbs, rates), rates)
    mass = cpm_equations.mass(p.coefficients, gamma)
    traced = casadi.Function("cpm", [q, v], [casadi.vertcat(*force), casadi.vertcat(*mass)])
    model, speed = cpm.CpmModel(p), np.array([0.3, -0.2, 0.4])
    terms = model.terms(model.home, speed)
    coriolis, entries = (np.array(x).ravel() for x in traced(model.home.q, speed))
    np.testing.assert_allclose(coriolis, terms.coriolis, rtol=1e-12)
    np.testing.assert_allclose(entries, terms.mass[np.triu_indices(3)], rtol=1e-12)

    o = omega3.Parameters()
    arms = omega3_equations.arms(o, tool, casadi)
    at = omega3_equations.tool_position(omega3_equations.spheres(o, arms), 1, casadi)
    rods = omega3_equations.rods(arms, at)
    u_inverse = scalars.inverse(rods.u)
    jacobian = omega3_equations.jacobian(rods, u_inverse)
    drift = omega3_equations.drift(arms, rods, u_inverse, jacobian, rates)
    force = omega3_equations.coriolis(o.coefficients, jacobian, drift)
    held = omega3_equations.gravity(o.coefficients, arms, jacobian)
    traced = casadi.Function("omega3", [q, v], [casadi.vertcat(*force), casadi.vertcat(*held), casadi.vertcat(*at)])
    robot = omega3.Omega3Model(o)
    there = robot.close(robot.home.q + np.array([0.1, -0.2, 0.05]))
    coriolis, gravity, position = (np.array(x).ravel() for x in traced(there.q, speed))
    np.testing.assert_allclose(coriolis, robot.terms(there, speed).coriolis, rtol=1e-11)
    np.testing.assert_allclose(gravity, robot.terms(there).gravity, rtol=1e-11)
    np.testing.assert_allclose(position, robot.tool(there).position, rtol=0, atol=1e-15)
