"""Angles, energies and multipliers of single limbs (1) to (17), (31) to (38), against masses that Newton moves.

The rod A_i M_i is uniform: a sixth of its mass at either end and four sixths at its centre have the same mass, centre
and inertia.  The positions of all masses follow from equations (1) to (9) alone; their velocities and accelerations
from difference quotients, so nothing here knows Gamma.
"""

from __future__ import annotations

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from cutjoint.errors import InputError
from cutjoint.papers.cpm import CpmModel, InferredCpmModel, per_limb
from cutjoint.papers.cpm import equations as eq
from cutjoint.papers.cpm.model import LimbEnergies

AXES = np.eye(3)
TURN = (AXES[0], AXES[1], -AXES[2])
ALONG = (AXES[1], AXES[2], AXES[0])


def bent(p, signs, tool):
    """Pivot, elbow and wrist of each limb in space, (3, 3, 3): the circles about A_i and B_i cut each other."""
    x, y, z = tool
    wrists = np.array([[x, y - p.L, z], [x - p.L, y, z], [x, y + p.L, z]])
    pivots = np.array([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, p.D, z]])
    found = []
    for pivot, wrist, sign, axis in zip(pivots, wrists, signs, TURN, strict=True):
        span = wrist - pivot
        reach = np.linalg.norm(span)
        along = (reach**2 + p.L1**2 - p.L2**2) / (2 * reach)
        across = np.cross(axis, span / reach)
        elbow = pivot + along * span / reach + sign * np.sqrt(p.L1**2 - along**2) * across
        found.append((pivot, elbow, wrist))
    return np.array(found)


@pytest.fixture
def cases(rng, sized_cpm):
    made = []
    for _ in range(40):
        one = sized_cpm()
        v, a = one.scale * rng.uniform(-1, 1, 3), one.scale * rng.uniform(-4, 4, 3)
        model = CpmModel(one.p, one.signs)
        at = model.close(one.tool)
        made.append(SimpleNamespace(model=model, p=one.p, at=at, tool=one.tool, v=v, a=a, scale=one.scale))
    return made


def masses(case, t):
    """Mass and position of every mass of the robot a time t later: {body: [(kg, m), ...]}, bodies 1, 2, 3 and tool."""
    p, tool = case.p, case.tool + t * case.v + 0.5 * t * t * case.a
    found = {}
    for limb, (pivot, elbow, wrist) in enumerate(bent(p, case.model.signs, tool), start=1):
        rod = [(p.m1 / 6, pivot), (4 * p.m1 / 6, (pivot + elbow) / 2), (p.m1 / 6, elbow)]
        found[limb] = [(p.m3, pivot), *rod, (p.m2 / 2, elbow), (p.m2 / 2, wrist)]
    return found | {"tool": [(p.m4, tool)]}


def positions(case, t):
    return np.array([x for body in masses(case, t).values() for _, x in body])


def accelerations(case, h=2e-3):
    """Second derivative of all positions by the five-point stencil."""
    far, near = (positions(case, 2 * h) + positions(case, -2 * h)), (positions(case, h) + positions(case, -h))
    return (16 * near - far - 30 * positions(case, 0.0)) / (12 * h * h)


def test_both_angles_point_along_the_rods(cases):
    """Equations (1) to (8) as printed, and the rods in space."""
    for case in cases:
        p, (one, two, three) = case.p, case.model.angles(case.at)
        x = p.L1 * np.cos(three[0]) + p.L2 * np.cos(three[1])
        y = p.L1 * np.cos(one[0]) + p.L2 * np.cos(one[1]) + p.L
        z = p.L1 * np.sin(one[0]) + p.L2 * np.sin(one[1])
        np.testing.assert_allclose([x, y, z], case.tool, rtol=0, atol=1e-13 * case.scale)
        z = p.L1 * np.cos(two[0]) + p.L2 * np.cos(two[1])
        x = p.L1 * np.sin(two[0]) + p.L2 * np.sin(two[1]) + p.L
        y = p.D - p.L - p.L1 * np.sin(three[0]) - p.L2 * np.sin(three[1])
        np.testing.assert_allclose([x, y, z], case.tool, rtol=0, atol=1e-13 * case.scale)
        for limb, (pivot, elbow, wrist) in enumerate(bent(p, case.model.signs, case.tool)):
            side = np.cross(TURN[limb], ALONG[limb])
            for angle, rod in zip(case.model.angles(case.at)[limb], (elbow - pivot, wrist - elbow), strict=True):
                way = np.cos(angle) * ALONG[limb] + np.sin(angle) * side
                np.testing.assert_allclose(way, rod / np.linalg.norm(rod), rtol=0, atol=1e-12)


def test_the_branch_is_the_sign_between_the_two_angles(cases):
    """Models' convention: +1 where sin(theta_i1 - theta_i2) > 0."""
    for case in cases:
        first, second = case.model.angles(case.at).T
        np.testing.assert_array_equal(np.sign(np.sin(first - second)), case.model.signs)


def test_rates_of_both_angles_against_differences(cases, slope):
    for case in cases:

        def angles(t, case=case):
            found = case.model.angles(case.model.close(case.tool + t * case.v))
            return found - 2 * np.pi * np.round((found - case.model.angles(case.at)) / (2 * np.pi))

        rates = case.model.angle_rates(case.at, case.v)
        np.testing.assert_allclose(rates, slope(angles), rtol=0, atol=1e-8)


def test_energies_of_each_limb_are_those_of_its_masses(cases, slope):
    """Equations (12) to (17)."""
    for case in cases:
        speeds = iter(slope(lambda t, case=case: positions(case, t)))
        found = case.model.limb_energies(case.at, case.v)
        kinetic, potential = [], []
        for body in masses(case, 0.0).values():
            kinetic.append(sum(0.5 * m * np.sum(next(speeds) ** 2) for m, _ in body))
            potential.append(-case.p.g * sum(m * x[2] for m, x in body))
        np.testing.assert_allclose(found.kinetic, kinetic, rtol=1e-8)
        np.testing.assert_allclose(found.potential, potential, rtol=0, atol=1e-12 * np.abs(potential).max())


def test_the_energies_add_up_to_the_models(cases):
    """Equations (18) and (19), and v' M v / 2."""
    for case in cases:
        found = case.model.limb_energies(case.at, case.v)
        assert found.kinetic.shape == found.potential.shape == (4,)
        assert not found.kinetic.flags.writeable
        total = 0.5 * case.v @ case.model.terms(case.at).mass @ case.v
        assert found.kinetic.sum() == pytest.approx(total, rel=1e-13)
        size = np.abs(found.potential).max()
        assert found.potential.sum() == pytest.approx(case.model.potential_energy(case.at), abs=1e-13 * size)


def test_multipliers_are_the_moments_that_newton_asks_for(cases):
    """(31) to (35): what the first rod and the half of the second at its end need about the pivot, besides weight."""
    for case in cases:
        weightless = iter(accelerations(case) - case.p.g * AXES[2])
        wanted = []
        for limb, (body, axis) in enumerate(zip(masses(case, 0.0).values(), TURN, strict=False)):
            needs = [(m, x, next(weightless)) for m, x in body]
            pivot = needs[0][1]
            moment = sum(m * np.cross(x - pivot, a) for m, x, a in needs[:5])
            wanted.append(moment @ axis)
            assert limb < 3
        found = case.model.multipliers(case.at, case.v, case.a)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=2e-6 * np.abs(wanted).max())


def test_tensions_and_actuators_carry_everything_that_moves_with_the_tool(cases):
    """(36) to (38): in each direction the tool, one whole limb and the ends of the other two; rods pull along
    themselves."""
    for case in cases:
        rods = bent(case.p, case.model.signs, case.tool)
        pull = case.model.rod_tensions(case.at, case.v, case.a)
        along = (rods[:, 1] - rods[:, 2]) / case.p.L2
        force = case.model.inverse_dynamics(case.at, case.v, case.a) + pull @ along
        p, moving = case.p, case.p.m1 + 2 * case.p.m2 + case.p.m3 + case.p.m4
        needed = moving * (case.a - p.g * AXES[2])
        np.testing.assert_allclose(force, needed, rtol=0, atol=1e-11 * max(np.abs(needed).max(), np.abs(pull).max()))
        lever = np.einsum("ij,ij->i", np.cross(rods[:, 1] - rods[:, 0], -along), TURN)
        np.testing.assert_allclose(
            pull * lever, case.model.multipliers(case.at, case.v, case.a), rtol=1e-9, atol=1e-12 * np.abs(pull).max()
        )


def test_constraint_force_is_what_is_left_of_the_tools_equation(cases):
    for case in cases:
        g = eq.gamma(case.model.state(case.at).limbs)
        multiplier = case.model.multipliers(case.at, case.v, case.a)
        force = np.array(per_limb.constraint_force(g, tuple(multiplier)))
        needed = 2 * case.p.A * case.a - case.p.E * AXES[2]
        force += case.model.inverse_dynamics(case.at, case.v, case.a)
        np.testing.assert_allclose(
            force, needed, rtol=0, atol=1e-12 * (np.abs(needed).max() + np.abs(multiplier).max())
        )


def test_a_thousand_states_at_once_give_what_one_gives(cpm_states):
    s = cpm_states
    angles = eq.limb_angles(s.p, tuple(s.tool), tuple(s.signs), np)
    limbs = eq.limbs(s.p, tuple(s.tool), angles, np)
    second = np.array(per_limb.second_angles(s.p, limbs, np))
    for i in range(0, 1000, 97):
        model = CpmModel(s.p, [int(x) for x in s.signs[:, i]])
        np.testing.assert_allclose(second[:, i], model.angles(model.close(s.tool[:, i]))[:, 1], rtol=1e-13)


def test_the_inferred_code_has_multipliers_but_no_energies():
    """Its (36) to (38) close with its own weight; it is no mechanism, so there is no energy to share out."""
    model, v, a = InferredCpmModel(), np.array([0.3, -0.2, 0.4]), np.array([1.0, 2.0, -1.0])
    at = model.close([0.5, 0.4, 0.35])
    k = model.coefficients(model.parameters)
    force = k.inertia * a - k.weight * AXES[2] + model.gamma(at).T @ model.multipliers(at, v, a)
    np.testing.assert_allclose(model.inverse_dynamics(at, v, a), force, rtol=1e-13)
    with pytest.raises(InputError, match="no mechanism"):
        model.limb_energies(at, v)


def test_energies_pickle_whole():
    model = CpmModel()
    energies = model.limb_energies(model.home, [0.1, 0.2, 0.3])
    again = pickle.loads(pickle.dumps(energies))
    np.testing.assert_array_equal(again.kinetic, energies.kinetic)
    assert not again.potential.flags.writeable


def test_wrong_shapes_are_refused():
    model = CpmModel()
    for call in (model.limb_energies, model.angle_rates):
        with pytest.raises(InputError, match="v"):
            call(model.home, [0.1, 0.2])
    with pytest.raises(InputError, match="a"):
        model.multipliers(model.home, np.zeros(3), [np.nan, 0, 0])
    assert isinstance(model.limb_energies(model.home, np.zeros(3)), LimbEnergies)
