"""The CPM's equations on a thousand random states at once, in random branches, and its branches and limits."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cutjoint.errors import ClosureError, InputError, LimbReachError, SingularError, UnreachableError
from cutjoint.papers.cpm import CpmModel, InferredCpmModel, Parameters
from cutjoint.papers.cpm import equations as eq
from cutjoint.papers.cpm.model import SMALLEST_SINE
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.papers.scalars import solve_symmetric, symmetric, times


def matrices(rows):
    """Rows of arrays (and zeros) as an array (count, 3, 3)."""
    rows = [[np.broadcast_to(x, 1000) for x in row] for row in rows]
    return np.moveaxis(np.array(rows), -1, 0)


def at(s, t=0.0):
    """Angles and limbs of the states, moved for a time t along their velocity and acceleration."""
    tool = tuple(s.tool + t * s.v + 0.5 * t * t * s.a)
    angles = eq.limb_angles(s.p, tool, tuple(s.signs), np)
    return tool, angles, eq.limbs(s.p, tool, angles, np)


def test_derived_constants():
    p = Parameters()
    moving = 1.892994 + 2 * 0.695528 + 0.2 + 0.3
    rod, half = 1.892994 * 0.5**2 / 3.0, 0.5 * 0.695528 * 0.5**2
    found = (2 * p.A, p.E, 2 * p.B, p.C)
    expected = (moving, 9.81 * moving, rod + half, 9.81 * (1.892994 * 0.25 + 0.5 * 0.695528 * 0.5))
    assert found == pytest.approx(expected, rel=1e-15)
    assert p.reach == pytest.approx((0.127, 0.873), rel=1e-12)


def test_second_links_keep_their_length(cpm_states):
    """Equations (3), (6), (9), written as in the paper's frame."""
    s = cpm_states
    (x, y, z), (one, two, three), _ = at(s)
    p = s.p
    lengths = [
        np.hypot(y - p.L1 * np.cos(one) - p.L, z - p.L1 * np.sin(one)),
        np.hypot(z - p.L1 * np.cos(two), x - p.L1 * np.sin(two) - p.L),
        np.hypot(x - p.L1 * np.cos(three), y - p.D + p.L1 * np.sin(three) + p.L),
    ]
    np.testing.assert_allclose(lengths, p.L2, rtol=0, atol=1e-14)


def test_the_sign_is_that_of_the_denominator_and_its_size_that_of_the_elbow(cpm_states):
    s = cpm_states
    (x, y, z), angles, limbs = at(s)
    for sign, angle, limb, (u, w) in zip(s.signs, angles, limbs, eq.limb_ends(s.p, (x, y, z)), strict=True):
        second = np.arctan2(w - s.p.L1 * np.sin(angle), u - s.p.L1 * np.cos(angle))
        expected = s.p.L1 * s.p.L2 * np.sin(angle - second)
        np.testing.assert_allclose(limb.denominator, expected, rtol=0, atol=1e-14)
        np.testing.assert_array_equal(np.sign(limb.denominator), sign)


def test_gamma_is_the_derivative_of_the_angles(cpm_states, slope):
    s = cpm_states

    def angles(t):
        return np.array(eq.limb_angles(s.p, tuple(s.tool + t * s.v), tuple(s.signs), np))

    rates = np.einsum("nij,jn->in", matrices(eq.gamma(at(s)[2])), s.v)
    np.testing.assert_allclose(rates, slope(angles), rtol=0, atol=1e-9)


def test_gamma_dot_is_the_derivative_of_gamma(cpm_states, slope):
    s = cpm_states
    exact = matrices(eq.gamma_dot(s.p, at(s)[2], tuple(s.v)))
    np.testing.assert_allclose(exact, slope(lambda t: matrices(eq.gamma(at(s, t)[2]))), rtol=1e-8, atol=1e-8)


def test_mass_is_positive_definite_and_its_rate_minus_twice_g_is_skew(cpm_states, slope):
    s = cpm_states
    k = s.p.coefficients
    gamma = eq.gamma(at(s)[2])
    mass = matrices(symmetric(eq.mass(k, gamma)))
    assert np.linalg.eigvalsh(mass).min() >= 2 * s.p.A * (1 - 1e-12)
    rate = slope(lambda t: matrices(symmetric(eq.mass(k, eq.gamma(at(s, t)[2])))))
    coriolis = matrices(eq.coriolis_matrix(k, gamma, eq.gamma_dot(s.p, at(s)[2], tuple(s.v))))
    skew = rate - 2 * coriolis
    np.testing.assert_allclose(skew + np.swapaxes(skew, 1, 2), 0.0, rtol=0, atol=1e-9)


def test_forward_undoes_inverse_dynamics_at_a_thousand_states(cpm_states):
    s = cpm_states
    k = s.p.coefficients
    _, _, limbs = at(s)
    gamma = eq.gamma(limbs)
    bias = np.array(eq.gravity(k, limbs, gamma))
    bias += np.array(eq.coriolis(k, gamma, eq.gamma_dot(s.p, limbs, tuple(s.v)), tuple(s.v)))
    force = np.array(times(symmetric(eq.mass(k, gamma)), tuple(s.a))) + bias
    found = np.array(solve_symmetric(eq.mass(k, gamma), tuple(force - bias)))
    np.testing.assert_allclose(found, s.a, rtol=0, atol=1e-11)


def test_arrays_and_numbers_give_the_same(cpm_states):
    s = cpm_states
    gamma = matrices(eq.gamma(at(s)[2]))
    for i in range(5):
        model = CpmModel(s.p, tuple(int(x) for x in s.signs[:, i]))
        np.testing.assert_allclose(model.gamma(model.close(s.tool[:, i])), gamma[i], rtol=1e-12)


def test_coriolis_matrix_times_velocity_is_the_coriolis_vector():
    m, v = CpmModel(), np.array([0.3, -0.2, 0.5])
    there = m.close([0.5, 0.4, 0.35])
    np.testing.assert_allclose(m.coriolis_matrix(there, v) @ v, m.terms(there, v).coriolis, rtol=1e-13)
    skew = 2.0 * m.parameters.B * (m.gamma(there).T @ m.gamma_dot(there, v))
    np.testing.assert_allclose(m.coriolis_matrix(there, v), skew, rtol=1e-13)


def test_gravity_is_the_same_seen_from_limb_1_and_limb_2():
    """Exchanging x and y exchanges the first two limbs, which turns their elbows over."""
    for one, two in product((1, -1), repeat=2):
        here = CpmModel(signs=(one, two, 1))
        there = CpmModel(signs=(-two, -one, 1))
        k = here.terms(here.close([0.5, 0.35, 0.3])).gravity
        swapped = there.terms(there.close([0.35, 0.5, 0.3])).gravity
        np.testing.assert_allclose(swapped, k[[1, 0, 2]], rtol=0, atol=1e-12)


def test_desired_force_along_the_circle():
    """The force the project found for (39), limb signs (+, -, +); it depends on g = 9.81."""
    p, k = Parameters(), Parameters().coefficients
    t = np.linspace(0.0, CIRCLE.duration, 4001)
    w, r = CIRCLE.omega, CIRCLE.radius
    c, s, zero = r * np.cos(w * t), r * np.sin(w * t), 0.0 * t
    tool = (CIRCLE.centre[0] + c, CIRCLE.centre[1] + s, CIRCLE.centre[2] + zero)
    v, a = (-w * s, w * c, zero), (-w * w * c, -w * w * s, zero)
    limbs = eq.limbs(p, tool, eq.limb_angles(p, tool, (1, -1, 1), np), np)
    gamma = eq.gamma(limbs)
    force = np.array(times(symmetric(eq.mass(k, gamma)), a)) + np.array(eq.gravity(k, limbs, gamma))
    force += np.array(eq.coriolis(k, gamma, eq.gamma_dot(p, limbs, v), v))
    expected = [[-3.348, 1.506], [-4.143, 1.508], [-39.983, -33.013]]
    found = np.transpose([force.min(axis=1), force.max(axis=1)])
    np.testing.assert_allclose(found, expected, rtol=0, atol=5e-4)


def test_eight_working_modes():
    m = CpmModel()
    modes = m.working_modes(m.home.q)
    signs = [m.branch(mode) for mode in modes]
    assert signs == list(product((1, -1), repeat=3))
    assert len({tuple(np.round(mode.q_full[3:], 6)) for mode in modes}) == 8
    for mode, sign in zip(modes, signs, strict=True):
        moved = m.close(m.home.q + np.array([-0.05, 0.02, 0.03]), mode)
        assert m.branch(moved) == m.branch(m.reach(moved.q, mode)) == sign
        assert CpmModel(signs=sign).close(moved.q).q_full == pytest.approx(moved.q_full, abs=0)
    assert m.branch(m.home) == m.signs == (1, -1, 1)


@pytest.mark.parametrize(("limb", "across"), [(1, (0.4, None, None)), (2, (None, 0.4, None)), (3, (None, None, 0.3))])
def test_limits_of_a_limb(limb, across):
    """Each limb reaches 0.127 to 0.873 m; just beyond there is no posture, just before it is singular."""
    m = CpmModel()
    p = m.parameters

    def tool(reach):
        c, s = reach * np.cos(0.8), reach * np.sin(0.8)
        return {1: (0.4, p.L + c, s), 2: (p.L + s, 0.4, c), 3: (c, p.D - p.L - s, 0.3)}[limb]

    beyond = 1e-6
    for bound, out in ((0.127, -beyond), (0.873, beyond)):
        with pytest.raises(LimbReachError) as found:
            m.reach(tool(bound + out))
        assert isinstance(found.value, UnreachableError)
        assert isinstance(found.value, ClosureError)
        assert found.value.limb == limb
        assert found.value.cut == f"limb {limb}"
        assert found.value.reach == pytest.approx(bound + out, abs=1e-12)
        assert found.value.bounds == pytest.approx((0.127, 0.873))
        assert found.value.gap[0] == pytest.approx(beyond, rel=1e-6)
        with pytest.raises(SingularError) as stuck:
            m.close(tool(bound - 1e-12 * np.sign(out)))
        assert stuck.value.kind == "limb"
        assert stuck.value.measure < stuck.value.limit == SMALLEST_SINE


def test_the_inferred_code_differs_as_stated():
    paper, code = CpmModel(), InferredCpmModel()
    v = np.array([0.2, -0.3, 0.4])
    there = paper.close([0.5, 0.4, 0.35])
    mine, its = paper.terms(there, v), code.terms(there, v)
    gamma = paper.gamma(there)
    np.testing.assert_allclose(mine.mass - its.mass, paper.parameters.B * gamma.T @ gamma, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(its.coriolis, mine.coriolis)
    np.testing.assert_allclose(mine.gravity - its.gravity, [0, 0, -0.2 * 9.81], rtol=0, atol=1e-12)
    a = np.array([1.0, -2.0, 0.5])
    np.testing.assert_allclose(code.forward_dynamics(there, v, code.inverse_dynamics(there, v, a)), a, rtol=1e-12)
    assert type(code.with_payload(0.5)) is InferredCpmModel
    assert code.with_payload(0.5).terms(there).gravity[2] - its.gravity[2] == pytest.approx(-0.5 * 9.81)


@pytest.mark.parametrize("change", [{"L1": 0.0}, {"L2": -0.1}, {"m1": -1.0}, {"m4": float("nan")}, {"g": float("inf")}])
def test_impossible_parameters_are_refused_by_name(change):
    with pytest.raises(InputError, match=f"parameter {next(iter(change))} "):
        Parameters(**change)


@pytest.mark.parametrize("signs", [(1, 1), (1, 0, 1), (1, 2, 1)])
def test_impossible_signs_are_refused(signs):
    with pytest.raises(InputError, match="signs"):
        CpmModel(signs=signs)
