"""Every row of the CPM's errata that can be computed: the printed form fails, what is used here holds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from cutjoint.papers.cpm import CpmModel, CpmRotaryModel, InferredCpmModel, Parameters, forward, per_limb, rotary
from cutjoint.papers.cpm import equations as eq
from cutjoint.papers.cpm.errata import ERRATA
from cutjoint.papers.cpm.published import CIRCLE, FORCE_LIMIT, SETTLING_TIME, TABLE_3
from cutjoint.papers.scalars import solve_symmetric

TOOL, V, A = np.array([0.5, 0.4, 0.35]), np.array([0.3, -0.4, 0.5]), np.array([1.0, -2.0, 1.5])
START_V = np.array([0.0, CIRCLE.radius * CIRCLE.omega, 0.0])
START_A = np.array([-CIRCLE.radius * CIRCLE.omega**2, 0.0, 0.0])
PD, PD_GRAVITY, FEEDFORWARD, COMPUTED_TORQUE = TABLE_3


def test_every_row_has_its_test():
    computed = {f"test_{row.key}" for row in ERRATA if row.computed}
    assert computed == {name for name in globals() if name.startswith("test_")} - {"test_every_row_has_its_test"}
    assert len({row.key for row in ERRATA}) == len(ERRATA)


def energies(tool, v, slope, down=1.0):
    """Kinetic and potential energy, equations (18) and (19), from nothing but the angles of the closed limbs."""
    p = Parameters()

    def angles(t):
        return np.array(eq.limb_angles(p, tuple(tool + t * v), (1, -1, 1)))

    rates, (one, two, _) = slope(angles), angles(0.0)
    kinetic = p.A * v @ v + p.B * rates @ rates
    return kinetic, -down * (p.C * (np.sin(one) + np.cos(two)) + p.E * tool[2])


def lagrange_force(slope):
    """Force at TOOL, V, A from Lagrange's equations by differences: d/dt(dT/dv) - dT/dq + dV/dq."""
    force = []
    for e in np.eye(3):

        def momentum(t, e=e):
            tool, v = TOOL + t * V + 0.5 * t * t * A, V + t * A
            return 0.5 * (energies(tool, v + e, slope)[0] - energies(tool, v - e, slope)[0])

        def difference(s, e=e):
            kinetic, potential = energies(TOOL + s * e, V, slope)
            return kinetic - potential

        force.append(slope(momentum, 1e-3) - slope(difference, 1e-3))
    return np.array(force)


def test_gravity_points_along_z(slope):
    m = CpmModel()
    there = m.close(TOOL)

    def gradient(down):
        return np.array([slope(lambda s, e=e: energies(TOOL + s * e, V, slope, down)[1]) for e in np.eye(3)])

    downward, upward = gradient(1.0), gradient(-1.0)
    k = m.terms(there).gravity
    np.testing.assert_allclose(k, downward, rtol=0, atol=1e-9)
    assert np.abs(k - upward).max() > 70.0
    assert m.forward_dynamics(there, np.zeros(3), np.zeros(3))[2] > 5.0


def test_line_before_39(slope):
    m = CpmModel()
    there = m.close(TOOL)
    expected, terms = lagrange_force(slope), m.terms(there, V)
    np.testing.assert_allclose(m.inverse_dynamics(there, V, A), expected, rtol=1e-6, atol=1e-6)
    printed = terms.mass @ V + m.coriolis_matrix(there, V) @ TOOL + terms.gravity
    assert np.abs(printed - expected).max() > 1.0


def test_coriolis_term(slope):
    m = CpmModel()
    there = m.close(TOOL)
    rate = slope(lambda t: m.terms(m.close(TOOL + t * V)).mass)
    skew = rate - 2.0 * m.coriolis_matrix(there, V)
    np.testing.assert_allclose(skew + skew.T, 0.0, rtol=0, atol=1e-9)
    halved = rate - m.coriolis_matrix(there, V)
    assert np.abs(halved + halved.T).max() > 0.1


def test_decay_rate():
    k_p, k_d = COMPUTED_TORQUE.k_p, COMPUTED_TORQUE.k_d
    assert k_d == pytest.approx(2.0 * np.sqrt(k_p), rel=1e-12)
    t, c1, c2 = np.linspace(0.0, 0.1, 11), 0.02, 0.3

    def residual(rate):
        """What (c1 + c2 t) exp(-rate t) leaves of equation (44), over its largest term."""
        line, decay = c1 + c2 * t, np.exp(-rate * t)
        e, de, dde = line * decay, (c2 - rate * line) * decay, (rate * rate * line - 2.0 * rate * c2) * decay
        return np.abs(dde + k_d * de + k_p * e).max() / np.abs(k_p * e).max()

    assert residual(k_d / 2.0) < 1e-14
    assert residual(k_p / 2.0) > 1.0


def test_gamma_elements(slope):
    """The elements as printed, in the paper's own frame, against the closed limbs in all eight branches."""
    p = Parameters()
    x, y, z = TOOL
    for signs in product((1, -1), repeat=3):
        one, two, three = eq.limb_angles(p, tuple(TOOL), signs)
        d1 = ((y - p.L) * np.sin(one) - z * np.cos(one)) * p.L1
        d2 = (z * np.sin(two) + (p.L - x) * np.cos(two)) * p.L1
        d3 = (x * np.sin(three) + np.cos(three) * (y - p.D + p.L)) * p.L1
        printed = -np.array(
            [
                [0, (y - p.L1 * np.cos(one) - p.L) / d1, (z - p.L1 * np.sin(one)) / d1],
                [(x - p.L1 * np.sin(two) - p.L) / d2, 0, (z - p.L1 * np.cos(two)) / d2],
                [(x - p.L1 * np.cos(three)) / d3, (y - p.D + p.L1 * np.sin(three) + p.L) / d3, 0],
            ]
        )
        truth = [
            slope(lambda s, e=e, signs=signs: np.array(eq.limb_angles(p, tuple(TOOL + s * e), signs)))
            for e in np.eye(3)
        ]
        np.testing.assert_allclose(printed, np.transpose(truth), rtol=0, atol=1e-9)
        m = CpmModel(signs=signs)
        np.testing.assert_allclose(m.gamma(m.close(TOOL)), printed, rtol=1e-12, atol=1e-14)


def start_force(model, k_d, *, gravity=False, feedforward=False):
    """Largest force at the start of the circle, at rest, under a PD law."""
    terms = model.terms(model.home, START_V if feedforward else None)
    force = k_d * START_V
    if gravity or feedforward:
        force = force + terms.gravity
    if feedforward:
        force = force + terms.mass @ START_A + terms.coriolis
    return np.abs(force).max()


def test_initial_state():
    m = CpmModel()
    laws = {PD: {}, PD_GRAVITY: {"gravity": True}, FEEDFORWARD: {"feedforward": True}}
    for (row, law), peak in zip(laws.items(), (119.85, 119.98, 119.85), strict=True):
        assert start_force(m, row.k_d, **law) == pytest.approx(peak, abs=0.005)
        assert start_force(m, row.k_d + 1, **law) > FORCE_LIMIT
        # A centimetre beside the path the printed gains break the limit.
        beside = row.k_d * START_V + row.k_p * np.array([0.0, 0.01, 0.0])
        assert beside.max() > FORCE_LIMIT
    # Moving with the path from the start, no law needs half the limit and nothing bounds K_D.
    terms = m.terms(m.home, START_V)
    assert np.abs(terms.mass @ START_A + terms.coriolis + terms.gravity).max() < 0.5 * FORCE_LIMIT


def circle(t, count):
    """Position, velocity and acceleration of the circle, for `count` robots at once."""
    w, r, one = CIRCLE.omega, CIRCLE.radius, np.ones(count)
    c, s = r * np.cos(w * t) * one, r * np.sin(w * t) * one
    centre = np.array(CIRCLE.centre)[:, None] * one
    return centre + np.array([c, s, 0 * c]), np.array([-w * s, w * c, 0 * c])


def late_errors(signs, k_p, gravity, dt=4e-3):
    """Largest error per axis from 0.3 s on: PD control of the inferred code, a column for each robot."""
    p, k = Parameters(), InferredCpmModel.coefficients(Parameters())
    signs, k_p, gravity = tuple(np.transpose(signs)), np.array(k_p), np.array(gravity)
    count = len(k_p)

    def acceleration(t, q, v):
        wanted, speed = circle(t, count)
        limbs = eq.limbs(p, tuple(wanted), eq.limb_angles(p, tuple(wanted), signs, np), np)
        force = k_p * (wanted - q) + 436.0 * (speed - v)
        force = force + gravity * np.array(eq.gravity(k, limbs, eq.gamma(limbs)))
        limbs = eq.limbs(p, tuple(q), eq.limb_angles(p, tuple(q), signs, np), np)
        gamma = eq.gamma(limbs)
        drift = eq.coriolis(k, gamma, eq.gamma_dot(p, limbs, tuple(v)), tuple(v))
        force = force - np.array(drift) - np.array(eq.gravity(k, limbs, gamma))
        return np.array(solve_symmetric(eq.mass(k, gamma), tuple(force)))

    q, v = circle(0.0, count)[0], np.zeros((3, count))
    worst = np.zeros(count)
    for step in range(round(CIRCLE.duration / dt)):
        t = step * dt
        a1 = acceleration(t, q, v)
        v2 = v + 0.5 * dt * a1
        a2 = acceleration(t + 0.5 * dt, q + 0.5 * dt * v, v2)
        v3 = v + 0.5 * dt * a2
        a3 = acceleration(t + 0.5 * dt, q + 0.5 * dt * v2, v3)
        v4 = v + dt * a3
        a4 = acceleration(t + dt, q + dt * v3, v4)
        q, v = q + dt / 6.0 * (v + 2 * v2 + 2 * v3 + v4), v + dt / 6.0 * (a1 + 2 * a2 + 2 * a3 + a4)
        if t + dt >= SETTLING_TIME:
            worst = np.maximum(worst, np.abs(circle(t + dt, count)[0] - q).max(axis=0))
    return worst


def test_elbow_branch():
    """Limb 1 by the force limit, limb 2 by the claim for PD, limb 3 by the gain that would have done."""
    for signs in product((1, -1), repeat=3):
        force = start_force(CpmModel(signs=signs), PD_GRAVITY.k_d, gravity=True)
        assert (force <= FORCE_LIMIT) == (signs[0] == 1)
    branches = [(1, -1, 1), (1, 1, 1), (1, 1, -1), (1, -1, 1), (1, -1, 1), (1, -1, -1)]
    gains = [PD.k_p, PD.k_p, PD.k_p, PD_GRAVITY.k_p, 8300.0, 8300.0]
    error = late_errors(branches, gains, [0, 0, 0, 1, 1, 1])
    assert error[0] <= PD.bound
    assert (error[1:3] > 1.2 * PD.bound).all()
    assert error[3] <= PD_GRAVITY.bound < error[4]
    assert error[5] < 0.98 * PD_GRAVITY.bound


def test_sudden_change():
    """The robot is at rest, the path is not: the desired velocity steps by 0.2749 m/s at t = 0."""
    p, v = circle(0.0, 1)
    np.testing.assert_allclose(p[:, 0], CpmModel().home.q, rtol=0, atol=1e-15)
    assert np.linalg.norm(v) == pytest.approx(0.2749, abs=5e-5)


def computed_torque_force(model, k_d):
    """Largest force at the start; the position error is zero there, so K_P plays no part."""
    terms = model.terms(model.home)
    return np.abs(terms.mass @ (START_A + k_d * START_V) + terms.gravity).max()


def test_computed_torque_force():
    m = CpmModel()
    assert computed_torque_force(m, COMPUTED_TORQUE.k_d) == pytest.approx(132.69, abs=0.005)
    assert computed_torque_force(m, 91.0) < FORCE_LIMIT < computed_torque_force(m, 92.0)


def test_inferred_code(slope):
    """It gives all four derivative gains as the largest integers under the limit; and it cannot be a mechanism."""
    m = InferredCpmModel()
    for row, law in ((PD, {}), (PD_GRAVITY, {"gravity": True}), (FEEDFORWARD, {"feedforward": True})):
        assert start_force(m, row.k_d, **law) < FORCE_LIMIT < start_force(m, row.k_d + 1, **law)
    k_d = COMPUTED_TORQUE.k_d
    assert computed_torque_force(m, k_d) < FORCE_LIMIT < computed_torque_force(m, k_d + 1)
    there = m.close(TOOL)
    rate = slope(lambda t: m.terms(m.close(TOOL + t * V)).mass)
    skew = rate - 2.0 * m.coriolis_matrix(there, V)
    assert np.abs(skew + skew.T).max() > 0.1
    power = slope(lambda t: 0.5 * (V + t * A) @ m.terms(m.close(TOOL + t * V + t * t * A / 2)).mass @ (V + t * A))
    power += slope(lambda t: m.potential_energy(m.close(TOOL + t * V + t * t * A / 2)))
    assert abs(power - m.inverse_dynamics(there, V, A) @ V) > 1e-3


def test_limb_energies(slope):
    """The sums are (18) and (19) only with the tool's; (16) holds for the limb along z and not for the one along y."""
    m, p = CpmModel(), Parameters()
    there = m.close(TOOL)
    found = m.limb_energies(there, V)
    kinetic, potential = energies(TOOL, V, slope)
    assert found.kinetic.sum() == pytest.approx(kinetic, rel=1e-9)
    assert found.potential.sum() == pytest.approx(potential, rel=1e-12)
    assert found.kinetic[:3].sum() == pytest.approx(kinetic - 0.5 * p.m4 * V @ V, rel=1e-9)
    level = m.limb_energies(m.close(TOOL), [0.0, 0.0, 0.5]).kinetic
    slide = 0.5 * (p.m1 + p.m2 + p.m3) * 0.25
    assert level[2] == pytest.approx(slide, rel=1e-12)  # along its own axis the third limb moves as one body
    assert abs(level[1] - slide) > 0.01


def test_constraint_functions(slope):
    """(31) holds with the multiplier that the derivatives 1 and -Gamma belong to, and not with that of (3) itself."""
    m, p = CpmModel(), Parameters()
    there = m.close(TOOL)
    one = m.angles(there)[0, 0]

    def root(t, e):
        return np.array(eq.limb_angles(p, tuple(TOOL + t * e), m.signs))

    constraint = -np.transpose([slope(lambda t, e=e: root(t, e)) for e in np.eye(3)])
    np.testing.assert_allclose(constraint, -m.gamma(there), rtol=0, atol=1e-9)

    def third(angle, tool):
        return (tool[1] - p.L1 * np.cos(angle) - p.L) ** 2 + (tool[2] - p.L1 * np.sin(angle)) ** 2 - p.L2**2

    by_angle = slope(lambda t: third(one + t, TOOL))
    by_tool = np.array([slope(lambda t, e=e: third(one, TOOL + t * e)) for e in np.eye(3)])
    twice = 2.0 * eq.limbs(p, tuple(TOOL), tuple(m.angles(there)[:, 0]))[0].denominator
    assert by_angle == pytest.approx(twice, rel=1e-9)
    np.testing.assert_allclose(by_tool, -twice * m.gamma(there)[0], rtol=0, atol=1e-9)
    # (36) to (38) give the multipliers of either, from what the actuators leave to the limbs; (31) takes only the first
    left = 2.0 * p.A * A - [0.0, 0.0, p.E] - m.inverse_dynamics(there, V, A)
    moments = np.linalg.solve(constraint.T, left)
    one_needs = 2.0 * p.B * (m.gamma(there) @ A + m.gamma_dot(there, V) @ V)[0] - p.C * np.cos(one)
    np.testing.assert_allclose(m.multipliers(there, V, A), moments, rtol=1e-7)
    assert one_needs == pytest.approx(moments[0], rel=1e-7)
    assert abs(one_needs - moments[0] / twice) > 0.5 * abs(one_needs)


def test_rotary_polynomial():
    """16 whatever the motors do, an even number of real solutions, up to eight with tables 1 and 2."""
    rng, p, counts = np.random.default_rng(1), Parameters(), []
    for _ in range(1500):
        angles = rng.uniform(-np.pi, np.pi, 3)
        assert forward.polynomial(forward.cylinders(p, angles))[0] == pytest.approx(16.0, rel=1e-15)
        counts.append(len(forward.solutions(p, angles)))
    assert set(counts) == {0, 2, 4, 6, 8}
    for ahead, behind in rotary.inverse_kinematics(p, tuple(TOOL)):
        assert abs(np.sin(0.5 * (ahead - behind))) > 0.1
    assert len({tuple(np.round(at.q, 9)) for at in CpmRotaryModel().working_modes(TOOL)}) == 8


def test_rotary_singularities():
    """The smaller side of type 2 in the box of the strokes, mode by mode, and the circle."""
    p, rng = Parameters(), np.random.default_rng(2)
    tool = rng.uniform(0.0, 0.9, (3, 40000))
    ends = np.array([np.hypot(u, w) for u, w in eq.limb_ends(p, tuple(tool))])
    tool = tool[:, ((ends > p.reach[0]) & (ends < p.reach[1])).all(axis=0)]
    t = np.linspace(0.0, CIRCLE.duration, 2001)
    ring = np.array([np.cos(CIRCLE.omega * t), np.sin(CIRCLE.omega * t), 0.0 * t])
    path = np.array(CIRCLE.centre)[:, None] + CIRCLE.radius * ring

    def measures(points, signs):
        limbs = eq.limbs(p, tuple(points), eq.limb_angles(p, tuple(points), signs, np), np)
        return np.broadcast_to(rotary.type_2(per_limb.second_angles(p, limbs, np), np), points.shape[1])

    smaller, crossed = [], []
    for signs in product((1, -1), repeat=3):
        negative = float(np.mean(measures(tool, signs) < 0))
        smaller.append(min(negative, 1.0 - negative))
        along = measures(path, signs)
        crossed.append(along.min() < 0.0 < along.max())
    assert min(smaller) == pytest.approx(0.105, abs=0.006)
    assert max(smaller) == pytest.approx(0.49, abs=0.01)
    assert sum(crossed) == 2
