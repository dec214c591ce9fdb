"""The Omega-3's equations on a thousand random states at once, its branches, symmetries and singularities."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cutjoint.errors import ClosureError, InputError, LimbReachError, SingularError, UnreachableError
from cutjoint.papers.omega3 import Omega3Model, Parameters
from cutjoint.papers.omega3 import equations as eq
from cutjoint.papers.omega3.model import SMALLEST_MEASURE
from cutjoint.papers.scalars import inverse, solve_symmetric, symmetric, times

THIRD = 2.0 * np.pi / 3.0


def turned(angle):
    """Rotation about the base normal x."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def matrices(rows):
    """Rows of arrays as an array (count, 3, 3)."""
    return np.moveaxis(np.array([list(row) for row in rows]), -1, 0)


def at(s, t=0.0):
    """Tool, arms, rods, inverse of the rods and Jacobian; the arms moved for a time t along v."""
    angles = np.array(eq.arm_angles(s.p, tuple(s.tool), tuple(s.signs), np)) + t * s.v
    arms = eq.arms(s.p, tuple(angles), np)
    spheres = eq.spheres(s.p, arms)
    start = eq.rods(eq.arms(s.p, eq.arm_angles(s.p, tuple(s.tool), tuple(s.signs), np), np), tuple(s.tool))
    tool = eq.tool_position(spheres, np.sign(start.volume), np)
    rods = eq.rods(arms, tool)
    u_inverse = inverse(rods.u)
    return tool, arms, rods, u_inverse, eq.jacobian(rods, u_inverse)


def test_derived_constants():
    p = Parameters()
    assert abs(p.R - 0.03975) < 1e-16
    assert p.m_E == pytest.approx(0.232395, rel=1e-14)
    assert p.arm_com == pytest.approx(29.71e-3, abs=5e-6)
    assert p.arm_inertia == pytest.approx(1.567e-4, abs=5e-8)
    assert p.I_arm == pytest.approx(3.306e-4, abs=5e-8)
    assert p.I_arm == pytest.approx(0.1 * 0.07**2 / 2 + 0.5 * 0.03493 * 0.07**2, rel=1e-14)
    assert p.rod_spacing == 0.04


def test_rods_keep_their_length_and_forward_undoes_inverse_kinematics(omega3_states):
    s = omega3_states
    tool, _, rods, _, _ = at(s)
    np.testing.assert_allclose(tool, s.tool, rtol=0, atol=1e-13)
    for u in rods.u:
        np.testing.assert_allclose(np.sqrt(sum(x * x for x in u)), s.p.L_B, rtol=0, atol=1e-14)
    assert (rods.volume > 0).all()
    assert (np.array(rods.ub) < 0).all()


def test_jacobian_is_the_derivative_of_the_forward_kinematics(omega3_states, slope):
    s = omega3_states
    velocity = np.einsum("nij,jn->in", matrices(at(s)[4]), s.v)
    np.testing.assert_allclose(velocity, slope(lambda t: np.array(at(s, t)[0])), rtol=0, atol=1e-9)


def test_jacobian_dot_is_the_derivative_of_the_jacobian(omega3_states, slope):
    s = omega3_states
    _, arms, rods, u_inverse, j = at(s)
    exact = matrices(eq.jacobian_dot(arms, rods, u_inverse, j, tuple(s.v)))
    np.testing.assert_allclose(exact, slope(lambda t: matrices(at(s, t)[4])), rtol=0, atol=1e-8)
    drift = np.array(eq.drift(arms, rods, u_inverse, j, tuple(s.v)))
    np.testing.assert_allclose(np.einsum("nij,jn->in", exact, s.v), drift, rtol=0, atol=1e-12)


def test_mass_is_positive_definite_and_its_rate_minus_twice_c_is_skew(omega3_states, slope):
    """C = m_E J' dJ/dt is the matrix for which it is."""
    s = omega3_states
    k = s.p.coefficients
    _, arms, rods, u_inverse, j = at(s)
    mass = matrices(symmetric(eq.mass(k, j)))
    assert np.linalg.eigvalsh(mass).min() >= s.p.I_arm * (1 - 1e-12)
    rate = slope(lambda t: matrices(symmetric(eq.mass(k, at(s, t)[4]))))
    jd = matrices(eq.jacobian_dot(arms, rods, u_inverse, j, tuple(s.v)))
    skew = rate - 2 * s.p.m_E * np.swapaxes(matrices(j), 1, 2) @ jd
    np.testing.assert_allclose(skew + np.swapaxes(skew, 1, 2), 0.0, rtol=0, atol=1e-10)


def test_forward_undoes_inverse_dynamics_at_a_thousand_states(omega3_states):
    s = omega3_states
    k = s.p.coefficients
    _, arms, rods, u_inverse, j = at(s)
    bias = np.array(eq.gravity(k, arms, j)) + np.array(
        eq.coriolis(k, j, eq.drift(arms, rods, u_inverse, j, tuple(s.v)))
    )
    torque = np.array(times(symmetric(eq.mass(k, j)), tuple(s.a))) + bias
    found = np.array(solve_symmetric(eq.mass(k, j), tuple(torque - bias)))
    np.testing.assert_allclose(found, s.a, rtol=0, atol=1e-10)


def test_arrays_and_numbers_give_the_same(omega3_states):
    s = omega3_states
    m = Omega3Model(s.p)
    j, jd = matrices(at(s)[4]), matrices(eq.jacobian_dot(*at(s)[1:], tuple(s.v)))
    for i in range(5):
        there = m.reach(s.tool[:, i])
        np.testing.assert_allclose(m.tool(there).jacobian, j[i], rtol=1e-11, atol=1e-14)
        np.testing.assert_allclose(m.jacobian_dot(there, s.v[:, i]), jd[i], rtol=1e-10, atol=1e-12)


def test_a_third_of_a_turn_permutes_the_limbs(rng):
    """Kinematics and inertia do not notice a turn by 120 degrees about the base normal; gravity does."""
    m, turn = Omega3Model(), turned(THIRD)
    for _ in range(20):
        tool, v = rng.uniform((0.095, -0.05, -0.05), (0.14, 0.05, 0.05)), rng.uniform(-3, 3, 3)
        here, there = m.reach(tool), m.reach(turn @ tool)
        np.testing.assert_allclose(there.q, np.roll(here.q, 1), rtol=0, atol=1e-13)
        before, after = m.tool(here, v), m.tool(there, np.roll(v, 1))
        np.testing.assert_allclose(after.jacobian, turn @ np.roll(before.jacobian, 1, axis=1), rtol=0, atol=1e-13)
        np.testing.assert_allclose(after.drift, turn @ before.drift, rtol=0, atol=1e-12)
        mass, other = m.terms(here, v), m.terms(there, np.roll(v, 1))
        np.testing.assert_allclose(other.mass, np.roll(mass.mass, (1, 1), axis=(0, 1)), rtol=0, atol=1e-15)
        np.testing.assert_allclose(other.coriolis, np.roll(mass.coriolis, 1), rtol=0, atol=1e-13)
        assert np.abs(other.gravity - np.roll(mass.gravity, 1)).max() > 1e-3


def test_a_mirror_exchanges_limbs_2_and_3(rng):
    """The plane y = 0 is a plane of symmetry of robot and gravity."""
    m, order = Omega3Model(), [0, 2, 1]
    for _ in range(20):
        tool, v, a = rng.uniform((0.095, -0.05, -0.05), (0.14, 0.05, 0.05)), rng.uniform(-3, 3, 3), rng.normal(size=3)
        here, there = m.reach(tool), m.reach(tool * [1, -1, 1])
        np.testing.assert_allclose(there.q, here.q[order], rtol=0, atol=1e-13)
        torque, mirrored = m.inverse_dynamics(here, v, a), m.inverse_dynamics(there, v[order], a[order])
        np.testing.assert_allclose(mirrored, torque[order], rtol=0, atol=1e-13)


def test_eight_working_modes():
    m = Omega3Model()
    tool = np.array([0.1, 0.01, 0.02])
    modes = m.working_modes(tool)
    assert [m.branch(mode).signs for mode in modes] == list(product((1, -1), repeat=3))
    for mode in modes:
        np.testing.assert_allclose(m.tool(mode).position, tool, rtol=0, atol=0)
        moved = m.reach(tool + np.array([0.003, -0.002, 0.001]), mode)
        assert m.branch(moved) == m.branch(mode)
        assert np.abs(moved.q - mode.q).max() < 0.3
        np.testing.assert_allclose(m.close(mode.q, mode).q_full, mode.q_full, rtol=0, atol=1e-12)
    assert m.branch(m.home).signs == m.signs == (-1, -1, -1)


def test_two_assembly_modes():
    m = Omega3Model()
    q = m.home.q + np.array([0.1, -0.05, 0.02])
    plus, minus = m.assembly_modes(q)
    assert m.branch(plus).assembly == 1
    assert m.branch(minus).assembly == -1
    elbows = np.array([arm.elbow for arm in eq.arms(m.parameters, tuple(q))])
    for mode in (plus, minus):
        tool = m.tool(mode).position
        np.testing.assert_allclose(np.linalg.norm(tool - elbows, axis=1), m.parameters.L_B, rtol=0, atol=1e-15)
        np.testing.assert_array_equal(m.close(q, mode).q_full, mode.q_full)
    normal = np.cross(elbows[1] - elbows[0], elbows[2] - elbows[0])
    mirror = (m.tool(plus).position - m.tool(minus).position) @ normal
    assert mirror == pytest.approx(
        np.linalg.norm(normal) * np.linalg.norm(m.tool(plus).position - m.tool(minus).position)
    )


def test_arm_angles_stay_near_those_of_the_start():
    """The arms may have been turned right round: reach answers within half a turn."""
    m = Omega3Model()
    wound = m.close(m.home.q + np.array([2 * np.pi, 0.0, -2 * np.pi]))
    np.testing.assert_allclose(m.reach(m.tool(wound).position, wound).q, wound.q, rtol=0, atol=1e-12)


def test_stretched_limbs_are_the_edge_of_the_workspace():
    m = Omega3Model()
    p = m.parameters
    edge = np.sqrt((p.L_A + p.L_B) ** 2 - p.R**2)
    with pytest.raises(LimbReachError) as beyond:
        m.reach([edge + 1e-6, 0, 0])
    assert isinstance(beyond.value, UnreachableError)
    assert beyond.value.bounds == pytest.approx((0.076, 0.216))
    assert beyond.value.reach > 0.216
    with pytest.raises(SingularError) as stretched:
        m.reach([edge - 1e-11, 0, 0])
    assert stretched.value.kind == "type-1"
    assert stretched.value.measure < stretched.value.limit == SMALLEST_MEASURE
    assert m.reach([edge - 1e-3, 0, 0]).gap[0] < 1e-15
    with pytest.raises(LimbReachError, match="sideways") as aside:
        m.reach([0.1, 0.2, 0.0])
    assert aside.value.bounds == (0.0, p.L_B)


@pytest.mark.parametrize("offset", [0.0, 1e-300, 1e-20, 1e-9])
@pytest.mark.parametrize("length", [1e-4, 0.1, 1e4])
def test_a_limb_folded_onto_its_own_motor_axis_is_singular_and_not_out_of_reach(length, offset):
    """Arm and rods as long as each other hold the tool on the motor axis at any angle: that is no lack of reach."""
    m = Omega3Model(Parameters(L_A=length, L_B=length, R_A=0.5 * length, R_B=0.3 * length))
    for limb in range(3):
        tool = turned(limb * THIRD) @ [offset * length, 0.0, m.parameters.R]
        with pytest.raises(SingularError, match=f"limb {limb + 1} ") as found:
            m.working_modes(tool)
        assert (found.value.kind, found.value.limit) == ("type-1", SMALLEST_MEASURE)
        assert found.value.measure <= 1e-7


def test_an_arm_may_move_through_type_1():
    """Stretched limbs stop the tool, not the arms: close() passes, the Jacobian there is singular."""
    m = Omega3Model()
    p = m.parameters
    angle = np.arctan2(np.sqrt((p.L_A + p.L_B) ** 2 - p.R**2), -p.R)
    there = m.close([angle] * 3)
    assert np.abs(m.tool(there).jacobian).max() < 1e-8
    assert m.branch(m.close([angle - 0.05] * 3)).signs == (-1, -1, -1)
    assert m.branch(m.close([angle + 0.05] * 3)).signs == (1, 1, 1)


def test_type_2_singularity():
    """Between two tool positions with the same elbows the rods come to lie in one plane."""
    m = Omega3Model(signs=(1, -1, -1))
    plus, minus = (
        m.working_modes(p)[3] for p in ([0.1128, -0.1015, 0.06475], [0.1314, -0.1070, 0.0763])
    )  # (+, -, -) is the fourth
    assert m.branch(plus) == ((1, -1, -1), 1)
    assert m.branch(minus) == ((1, -1, -1), -1)

    def measure(tool):
        arms = eq.arms(m.parameters, eq.arm_angles(m.parameters, tuple(tool), m.signs))
        return eq.rods(arms, tuple(tool)).volume / m.parameters.L_B**3

    low, high = m.tool(minus).position, m.tool(plus).position
    with pytest.raises(SingularError, match="only through a type-2 singularity"):
        m.reach(high, minus)
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if measure(middle) < 0 else (low, middle)
    with pytest.raises(SingularError) as found:
        m.reach(low, minus)
    assert found.value.kind == "type-2"
    assert found.value.measure < found.value.limit == SMALLEST_MEASURE
    angles = eq.arm_angles(m.parameters, tuple(low), m.signs)
    with pytest.raises((SingularError, ClosureError)):
        m.close(angles, minus)


def test_rods_too_short_to_meet(rng):
    """Where the circle through the elbows is wider than the rods they cannot meet; the error says by how much."""
    m = Omega3Model()
    p, refused = m.parameters, 0
    for angles in rng.uniform(-np.pi, np.pi, size=(200, 3)):
        a, b, c = (np.array(arm.elbow) for arm in eq.arms(p, tuple(angles)))
        sides = [np.linalg.norm(x) for x in (a - b, b - c, c - a)]
        radius = np.prod(sides) / (2.0 * np.linalg.norm(np.cross(b - a, c - a)))
        if radius > p.L_B:
            refused += 1
            with pytest.raises(ClosureError) as found:
                m.close(angles)
            assert found.value.gap[0] == pytest.approx(radius - p.L_B, rel=1e-6)
        else:
            assert m.close(angles).gap[0] < 1e-13
    assert 5 < refused < 195


@pytest.mark.parametrize("change", [{"L_A": 0.0}, {"L_B": -0.1}, {"m_R": -1.0}, {"arm_inertia": -1e-9}, {"g": np.nan}])
def test_impossible_parameters_are_refused_by_name(change):
    with pytest.raises(InputError, match=f"parameter {next(iter(change))} "):
        Parameters(**change)


@pytest.mark.parametrize("change", [{"arm_com": 0.035}, {"arm_inertia": 2e-4}, {"g": 9.7}])
def test_open_parameters_change_the_torque(change):
    a = np.array([1.0, -2.0, 3.0])
    m, other = Omega3Model(), Omega3Model(Parameters(**change))
    torque, changed = (x.inverse_dynamics(x.home, np.zeros(3), a) for x in (m, other))
    assert np.abs(changed - torque).max() > 1e-5
