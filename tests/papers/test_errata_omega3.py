"""Every row of the Omega-3's errata that can be computed: the printed form fails, what is used here holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cutjoint.errors import LimbReachError
from cutjoint.papers.omega3 import Omega3Model, Parameters
from cutjoint.papers.omega3 import equations as eq
from cutjoint.papers.omega3.errata import ERRATA
from cutjoint.papers.omega3.published import CURVE

TOOL, V, A = np.array([0.11, 0.02, -0.03]), np.array([2.0, -1.5, 3.0]), np.array([10.0, 20.0, -15.0])


def test_every_row_has_its_test():
    computed = {f"test_{row.key}" for row in ERRATA if row.computed}
    assert computed == {name for name in globals() if name.startswith("test_")} - {"test_every_row_has_its_test"}
    assert len({row.key for row in ERRATA}) == len(ERRATA)


def rotation(i):
    """Equation (9)."""
    c, s = np.cos(2 * np.pi * i / 3), np.sin(2 * np.pi * i / 3)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def rods(model, q):
    """The three rods u_i as rows, from the forward kinematics."""
    at = model.close(q)
    return np.array(eq.rods(eq.arms(model.parameters, tuple(q)), tuple(model.tool(at).position)).u)


def test_table_1_last_row():
    """The general loop (2), with joints where they are: only R = R_A - R_B gives rods of length L_B."""
    true = Parameters()

    def rod_lengths(radius):
        """True length of the rods where the shifted chains (3) close with this R."""
        model = Omega3Model(replace(true, R_A=true.R_B + radius))
        at, found = model.reach(TOOL), []
        for i, theta in enumerate(at.q):
            arm = np.array([true.L_A * np.sin(theta), 0.0, true.R_A + true.L_A * np.cos(theta)])
            platform = TOOL + rotation(i) @ [0.0, 0.0, true.R_B]
            found.append(np.linalg.norm(platform - rotation(i) @ arm))
        return np.array(found)

    np.testing.assert_allclose(rod_lengths(true.R_A - true.R_B), true.L_B, rtol=0, atol=1e-15)
    assert np.abs(rod_lengths(0.03525) - true.L_B).max() > 1e-3


def test_sign_in_17(rng, slope):
    m = Omega3Model()
    q = m.reach(TOOL).q
    u, du = rods(m, q), slope(lambda t: rods(m, q + t * V))
    plus = np.einsum("ij,ij->i", u, du) + np.einsum("ij,ij->i", du, u)
    np.testing.assert_allclose(plus, 0.0, rtol=0, atol=1e-11)
    any_u, any_du = rng.normal(size=(2, 3))
    assert any_u @ any_du - any_du @ any_u == 0.0  # as printed: true of any two vectors,
    assert abs(any_u @ any_du) > 0.01  # so (18) does not follow


def test_rate_in_19(slope):
    m = Omega3Model()
    at = m.reach(TOOL)
    truth = slope(lambda t: rods(m, at.q + t * V))
    arms, velocity = eq.arms(m.parameters, tuple(at.q)), m.tool(at).jacobian @ V
    for i in range(3):
        b = np.array(arms[i].b)
        np.testing.assert_allclose(velocity + b * V[i], truth[i], rtol=0, atol=1e-10)
        assert np.abs(velocity + b * V - truth[i]).max() > 1e-2  # the vector of all rates, component by component
        assert np.outer(b, V).shape != truth[i].shape  # or as a product of vectors


def test_gravity_in_33(slope):
    m = Omega3Model()
    p, at = m.parameters, m.reach(TOOL)
    j = m.tool(at).jacobian
    with pytest.raises(ValueError, match="mismatch"):
        j.T @ np.array([0.0, -p.m_E * p.g])
    height = [slope(lambda s, e=e: m.tool(m.close(at.q + s * e)).position[2]) for e in np.eye(3)]
    potential_slope = p.m_E * p.g * np.array(height)
    np.testing.assert_allclose(-j.T @ [0.0, 0.0, -p.m_E * p.g], potential_slope, rtol=0, atol=1e-10)
    for wrong in ([-p.m_E * p.g, 0.0, 0.0], [0.0, -p.m_E * p.g, 0.0]):
        assert np.abs(-j.T @ wrong - potential_slope).max() > 1e-2


def test_component_of_36(slope):
    m = Omega3Model()
    p, q = m.parameters, m.reach(TOOL).q
    massless = Omega3Model(replace(p, m_payload=0.0, m_P=0.0, m_R=0.0))
    gravity = massless.terms(massless.close(q)).gravity
    for i, theta in enumerate(q):
        c, s = np.cos(theta), np.sin(theta)
        about_y = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
        weight = p.m_SC * rotation(i).T @ [0.0, 0.0, -p.g]
        torque = np.cross(about_y @ [0.0, 0.0, p.arm_com], weight)

        def height(t, i=i, theta=theta):
            return (rotation(i) @ [np.sin(theta + t), 0.0, np.cos(theta + t)])[2] * p.arm_com

        assert torque[1] == pytest.approx(-p.m_SC * p.g * float(slope(height)), abs=1e-11)
        assert gravity[i] == pytest.approx(-torque[1], abs=1e-15)
        assert i == 0 or np.abs(torque[[0, 2]]).max() > 1e-4


def test_dots_in_42(slope):
    """Power: torque' rates = change of kinetic and potential energy."""
    m = Omega3Model()
    at = m.reach(TOOL)

    def energy(t):
        there, v = m.close(at.q + t * V + 0.5 * t * t * A), V + t * A
        velocity = m.tool(there).jacobian @ v
        p = m.parameters
        return 0.5 * (p.m_E * velocity @ velocity + p.I_arm * v @ v) + m.potential_energy(there)

    power, terms, j = float(slope(energy)), m.terms(at, V), m.tool(at).jacobian
    assert m.inverse_dynamics(at, V, A) @ V == pytest.approx(power, rel=1e-9)
    angles_for_accelerations = terms.mass @ at.q + terms.coriolis + terms.gravity
    j_for_j_dot = terms.mass @ A + m.parameters.m_E * j.T @ j @ V + terms.gravity
    not_transposed = terms.mass @ A + m.parameters.m_E * j @ m.tool(at, V).drift + terms.gravity
    for printed in (angles_for_accelerations, j_for_j_dot, not_transposed):
        assert abs(printed @ V - power) > 1e-3 * abs(power)


def test_scalar_in_42():
    m = Omega3Model()
    at, p = m.reach(TOOL), m.parameters
    j = m.tool(at).jacobian
    velocity = j @ V
    kinetic = 0.5 * p.m_E * velocity @ velocity + 0.5 * p.I_arm * sum(rate * rate for rate in V)
    assert 0.5 * V @ m.terms(at).mass @ V == pytest.approx(kinetic, rel=1e-13)
    printed = p.I_arm + p.m_E * j.T @ j
    assert abs(0.5 * V @ printed @ V - kinetic) > 0.01 * kinetic


def path_torques(model):
    """Torques along the desired path (43), shape (200, 3) [N m]."""
    at, torques = model.home, []
    for t in np.linspace(0.0, CURVE.duration, 200, endpoint=False):
        w, y, z = CURVE.omega, CURVE.y, CURVE.z
        at = model.reach([CURVE.x, y * np.cos(w * t), z * np.sin(2 * w * t)], at)
        j = model.tool(at).jacobian
        v = np.linalg.solve(j, [0.0, -w * y * np.sin(w * t), 2 * w * z * np.cos(2 * w * t)])
        pull = np.array([0.0, -w * w * y * np.cos(w * t), -4 * w * w * z * np.sin(2 * w * t)])
        torques.append(model.inverse_dynamics(at, v, np.linalg.solve(j, pull - model.tool(at, v).drift)))
    return np.array(torques)


def test_units():
    """Millimetres for the tables and metres for the path cannot both be meant."""
    true = Parameters()
    printed = {name: 1000.0 * getattr(true, name) for name in ("L_A", "L_B", "R_A", "R_B")}
    model = Omega3Model(replace(true, **printed))
    for t in np.linspace(0.0, CURVE.duration, 21):
        tool = [CURVE.x, CURVE.y * np.cos(CURVE.omega * t), CURVE.z * np.sin(2 * CURVE.omega * t)]
        assert len(Omega3Model().working_modes(tool)) == 8
        with pytest.raises(LimbReachError):
            model.working_modes(tool)


def test_open_arm():
    """What the arm is taken for moves the torque by several percent of its peak."""
    true = Parameters()
    base, radius, mass = path_torques(Omega3Model()), true.L_A, true.m_SC
    ring = 2.0 * radius / np.pi
    shapes = {
        "half ring": (ring, mass * (radius**2 - ring**2), 0.07, 0.09),
        "slender rod": (radius / 2.0, mass * radius**2 / 12.0, 0.005, 0.06),
        "none": (0.0, 0.0, 0.12, 0.16),
    }
    for com, inertia, least, most in shapes.values():
        other = path_torques(Omega3Model(replace(true, arm_com=com, arm_inertia=inertia)))
        moved = np.abs(other - base).max(axis=0) / np.abs(base).max(axis=0)
        assert least < moved.min()
        assert moved.max() < most
    disc = mass * radius**2 / 2.0  # about the pivot, parallel axis theorem (37)
    assert true.arm_inertia + mass * true.arm_com**2 == pytest.approx(disc, rel=1e-14)
