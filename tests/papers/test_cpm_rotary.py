"""The CPM with rotary motors: inverse and forward kinematics, singularities, dynamics, on robots of random size.

Second derivations: the printed equations (3), (6), (9); the algebra of their common zeros, which has dimension eight;
the linear model (39) turned into motor angles by the velocity map.
"""

from __future__ import annotations

import pickle
from itertools import product

import numpy as np
import pytest

from cutjoint.errors import ClosureError, InputError, LimbReachError, SingularError
from cutjoint.papers.cpm import CpmModel, CpmRotaryModel, Parameters, forward, rotary, tracking
from cutjoint.papers.cpm import equations as eq
from cutjoint.papers.cpm.published import CIRCLE
from cutjoint.papers.cpm.rotary_model import SMALLEST_MEASURE

MODES = tuple(product((1, -1), repeat=3))


def concentric(p):
    """Motor angles at which the three cylinders share their centre: theta_21 = theta_11 - pi / 2 leaves a quadratic."""
    sums = p.D - 2 * p.L
    c = np.roots([2.0, -2.0 * (p.D - p.L), p.L**2 + sums**2 - p.L1**2]).min()
    one = np.arccos(c / p.L1)
    return np.array([one, one - 0.5 * np.pi, np.arctan2(sums - c, p.L - c)])


EIGHT = concentric(Parameters())
"""Motor angles of the paper's robot that eight positions of the tool belong to."""


def residuals(p, angles, tool):
    """(3), (6), (9) as printed, left less right, over L2^2; tool may be complex."""
    (one, two, three), (x, y, z) = angles, tool
    squares = [
        (y - p.L1 * np.cos(one) - p.L) ** 2 + (z - p.L1 * np.sin(one)) ** 2,
        (z - p.L1 * np.cos(two)) ** 2 + (x - p.L1 * np.sin(two) - p.L) ** 2,
        (x - p.L1 * np.cos(three)) ** 2 + (y - p.D + p.L1 * np.sin(three) + p.L) ** 2,
    ]
    return np.array([square / p.L2**2 - 1.0 for square in squares])


# ---- the algebra of the three cylinders, from the printed equations --------------------------------------------------

MONOMIALS = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 1, 1))


def squares(p, angles):
    """x^2, y^2, z^2 as polynomials of first degree, from (3), (6), (9): {axis: {monomial: coefficient}}, in L2."""
    one, two, three = angles
    centre = {
        0: {1: p.L + p.L1 * np.cos(one), 2: p.L1 * np.sin(one)},
        1: {2: p.L1 * np.cos(two), 0: p.L + p.L1 * np.sin(two)},
        2: {0: p.L1 * np.cos(three), 1: p.D - p.L - p.L1 * np.sin(three)},
    }
    linear = []
    for limb in range(3):
        row = np.zeros(4)  # constant, x, y, z
        row[0] = 1.0
        for axis, place in centre[limb].items():
            row[1 + axis] = 2.0 * place / p.L2
            row[0] -= (place / p.L2) ** 2
        linear.append(row)
    one_, two_, three_ = linear  # y^2 + z^2, z^2 + x^2, x^2 + y^2
    found = [(two_ + three_ - one_) / 2, (three_ + one_ - two_) / 2, (one_ + two_ - three_) / 2]
    return [dict(zip(MONOMIALS[:4], row, strict=True)) for row in found]


def multiplication(p, angles, direction):
    """Matrix (8, 8) of multiplying by a linear form, modulo the three equations."""
    square = squares(p, angles)

    def reduced(monomial, factor, into):
        for axis in range(3):
            if monomial[axis] > 1:
                rest = tuple(m - 2 * (k == axis) for k, m in enumerate(monomial))
                for other, value in square[axis].items():
                    reduced(tuple(a + b for a, b in zip(rest, other, strict=True)), factor * value, into)
                return
        into[MONOMIALS.index(monomial)] += factor

    matrix = np.zeros((8, 8))
    for column, monomial in enumerate(MONOMIALS):
        for axis, value in enumerate(direction):
            reduced(tuple(m + (k == axis) for k, m in enumerate(monomial)), value, matrix[:, column])
    return matrix


def algebraic_solutions(p, angles):
    """All eight tool positions, complex, shape (8, 3) [m]: left eigenvectors of a multiplication are the monomials."""
    _, vectors = np.linalg.eig(multiplication(p, angles, (0.61, -0.37, 0.83)).T)
    return (vectors[1:4] / vectors[0]).T * p.L2


@pytest.fixture
def held(rng, sized_cpm):
    """Motor angles of random robots that some posture has: (parameters, signs, tool, angles)."""
    made = []
    for _ in range(150):
        one = sized_cpm()
        made.append((one.p, one.signs, one.tool, np.array(eq.limb_angles(one.p, tuple(one.tool), one.signs))))
    return made


# ---- inverse kinematics ----------------------------------------------------------------------------------------------


def test_two_solutions_a_limb_and_no_third(held):
    turn = np.linspace(-np.pi, np.pi, 20001)[:-1]
    for p, _, tool, _ in held[:40]:
        pairs = rotary.inverse_kinematics(p, tuple(tool))
        for angles in zip(*pairs, strict=True):
            assert np.abs(residuals(p, angles, tool)).max() < 1e-13
        for limb, pair in enumerate(pairs):
            assert abs(np.sin(0.5 * (pair[0] - pair[1]))) > 1e-3
            left = residuals(p, (turn,) * 3, tool)[limb]
            assert int((np.sign(left) != np.sign(np.roll(left, 1))).sum()) == 2


def test_eight_working_modes_of_one_tool_position(held):
    done = 0
    for p, _, tool, _ in held:
        model = CpmRotaryModel(p)
        try:
            modes = model.working_modes(tool)
        except SingularError:
            continue
        done += 1
        assert [model.branch(at).signs for at in modes] == list(MODES)
        assert len({tuple(np.round(at.q, 9)) for at in modes}) == 8
        for at in modes:
            assert np.abs(residuals(p, at.q, tool)).max() < 1e-13
    assert done > 100


# ---- forward kinematics ----------------------------------------------------------------------------------------------


def test_the_polynomial_is_of_degree_eight_everywhere(rng):
    """Its leading coefficient does not know the motors: 16 for any size of robot and any angles."""
    for _ in range(200):
        scale = 10.0 ** rng.uniform(-3, 3)
        p = Parameters(*(scale * rng.uniform(0.05, 2.0, 4)))
        found = forward.polynomial(forward.cylinders(p, rng.uniform(-np.pi, np.pi, 3)))
        assert found.shape == (9,)
        assert found[0] == pytest.approx(16.0, rel=1e-15)


def test_every_root_is_a_solution_complex_ones_too(held):
    """The other two unknowns follow from a root by a linear equation each, and close (3), (6), (9)."""
    for p, _, _, angles in held:
        c = forward.cylinders(p, angles)
        for x in np.roots(forward.polynomial(c)):
            q = 1 + c.a**2 + c.b**2 - 2 * c.d**2 - 2 * x * x
            f, g = 1 - (x - c.d) ** 2, 1 - (x + c.d) ** 2
            if abs(c.b * q) < 1e-2 or abs(c.a) < 1e-2:
                continue
            z = (4 * c.a**2 * f - 4 * c.b**2 * g - q * q) / (4 * c.b * q)
            y = -(2 * c.b * z + q) / (2 * c.a)
            tool = np.array([x, y, z]) * p.L2 + np.array(c.origin)
            assert np.abs(residuals(p, angles, tool)).max() < 1e-6 * max(1.0, abs(x)) ** 4


def orbit(coefficients, loops, first=0):
    """The roots that a root becomes when the parameters are led around closed loops in the complex numbers."""
    start = np.roots(coefficients(loops[0](0.0)))
    ways = []
    for loop in loops:
        now = start
        for t in np.linspace(0.0, 1.0, 801)[1:]:
            new = np.roots(coefficients(loop(t)))
            nearest = np.abs(now[:, None] - new[None, :]).argmin(axis=1)
            assert len(set(nearest)) == len(start), "a step too long"
            now = new[nearest]
        ways.append(np.abs(now[:, None] - start[None, :]).argmin(axis=1))
    reached = {first}
    while more := {int(way[i]) for way in ways for i in reached} - reached:
        reached |= more
    return reached


def test_no_lower_degree_would_do():
    """All eight solutions are branches of one function of the motors: led around loops, one becomes every other.

    If the polynomial had a factor, roots of the factor would only become one another.
    """
    rng = np.random.default_rng(3)

    def loop(centre, radius):
        there = rng.normal(size=3) + 1j * rng.normal(size=3)
        return lambda t: centre + radius * (np.exp(2j * np.pi * t) - 1.0) * there

    centre = np.array([0.4, 0.7, 0.3])
    loops = [loop(centre, radius) for radius in (0.3, 0.6, 0.9)]
    eighth = lambda abd: forward.polynomial(forward.Cylinders(*abd, (0.0, 0.0, 0.0)))  # noqa: E731
    assert orbit(eighth, loops) == set(range(8))
    with_factor = lambda abd: np.polymul([1.0, 0.0, -abd[0], abd[1]], [1.0, 0.0, 0.0, 0.0, abd[2], 5.0])  # noqa: E731
    assert len(orbit(with_factor, loops)) < 8  # what it would look like


def test_real_solutions_are_those_of_the_algebra(held):
    """None is missing and none is too many, from zero to eight."""
    rng, counts = np.random.default_rng(5), set()
    cases = [(p, angles) for p, _, _, angles in held]
    cases += [(p, rng.uniform(-np.pi, np.pi, 3)) for p, _, _, _ in held]
    cases += [(Parameters(), EIGHT + 0.05 * rng.normal(size=3)) for _ in range(60)]
    for p, angles in cases:
        found, all_ = forward.solutions(p, angles), algebraic_solutions(p, angles) / p.L2
        real = all_[np.abs(all_.imag).max(axis=1) < 1e-6].real
        doubtful = np.sort(np.abs(all_.imag).max(axis=1))
        if ((doubtful > 1e-9) & (doubtful < 1e-3)).any():
            continue  # too near a singularity for the eigenvalues to tell real from complex
        counts.add(len(real))
        assert len(found) == len(real)
        for one in found / p.L2:
            assert np.linalg.norm(real - one, axis=1).min() < 1e-6
        for one in found:
            assert np.abs(residuals(p, angles, one)).max() < 1e-11
    assert counts == {0, 2, 4, 6, 8}


def test_eight_real_solutions_with_the_papers_own_sizes():
    """Three cylinders about one centre cross at the corners of a cube of edge sqrt(2) L2."""
    p = Parameters()
    found = forward.solutions(p, EIGHT)
    centre = found.mean(axis=0)
    corners = np.array(list(product((-1, 1), repeat=3))) * p.L2 / np.sqrt(2.0)
    np.testing.assert_allclose(found - centre, corners, rtol=0, atol=1e-12)
    modes = CpmRotaryModel().assembly_modes(EIGHT)
    assert len(modes) == 8
    assert sorted(CpmRotaryModel().branch(at).assembly for at in modes) == [-1] * 4 + [1] * 4
    for at in modes:
        assert np.abs(residuals(p, EIGHT, at.q_full[3:])).max() < 1e-14


def test_every_posture_is_among_its_forward_solutions(held):
    for p, _, tool, angles in held:
        found = forward.solutions(p, angles)
        assert np.linalg.norm(found - tool, axis=1).min() < 1e-9 * p.L2
        assert len(found) <= 8


def test_as_many_solutions_on_either_side_of_the_singularities(held):
    """The signs of the measure add up to zero: they do where there is no solution, and the sum cannot change."""
    some = 0
    for p, _, _, angles in held:
        model = CpmRotaryModel(p)
        try:
            modes = model.assembly_modes(angles)
        except SingularError:
            continue
        some += len(modes) > 2
        assert sum(model.branch(at).assembly for at in modes) == 0
        assert len(modes) % 2 == 0
    assert some > 5


def test_solutions_are_the_same_in_every_turn_of_the_motors(held):
    for p, _, _, angles in held[:20]:
        turned = forward.solutions(p, angles + 2 * np.pi * np.array([1, -2, 3]))
        np.testing.assert_allclose(turned, forward.solutions(p, angles), rtol=0, atol=1e-9 * p.L2)


def test_no_solution_where_the_elbows_are_too_far_apart():
    p = Parameters(D=5.0)
    assert forward.solutions(p, [0.5, 0.5, 0.5]).shape == (0, 3)
    assert CpmRotaryModel(Parameters()).assembly_modes([3.0, 3.0, 3.0]) == ()


# ---- singularities ---------------------------------------------------------------------------------------------------


def singular_between(p, signs, one, other):
    """The tool position of a type-2 singularity between two positions whose measures differ in sign."""

    def measure(s):
        tool = tuple(one + s * (other - one))
        limbs = rotary.limbs(p, tool, eq.limb_angles(p, tool, signs))
        return rotary.rods(p, limbs).volume

    low, high = 0.0, 1.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if measure(middle) * measure(0.0) > 0 else (low, middle)
    return one + high * (other - one), measure


def singular_postures(rng, sized_cpm, count):
    """Random singularities of type 2: (parameters, signs, tool there, positions before and after)."""
    while count:
        one = sized_cpm()
        other = one.tool + one.scale * rng.uniform(-0.15, 0.15, 3)
        model = CpmRotaryModel(one.p, one.signs)
        try:
            ends = [model._place(tuple(float(x) for x in tool), one.signs, (0.0,) * 3) for tool in (one.tool, other)]
        except (SingularError, LimbReachError):
            continue
        if model.branch(ends[0]).assembly != model.branch(ends[1]).assembly:
            tool, _ = singular_between(one.p, one.signs, one.tool, other)
            count -= 1
            yield one.p, one.signs, tool, ends


def test_both_forms_of_type_2_are_one(held):
    """det E over L2^3 from the rods, and the products of cosines and sines of theta_i2 (1) to (8)."""
    for p, signs, tool, angles in held:
        limbs = rotary.limbs(p, tuple(tool), tuple(angles))
        second = CpmModel(p, signs).angles(CpmModel(p, signs).close(tool))[:, 1]
        volume = rotary.rods(p, limbs).volume / p.L2**3
        assert volume == pytest.approx(float(rotary.type_2(tuple(second))), abs=1e-13)
        rods = np.array(rotary.rods(p, limbs).e)
        assert volume == pytest.approx(float(np.linalg.det(rods / p.L2)), abs=1e-13)


def test_type_2_two_positions_of_the_tool_meet_and_the_tool_gives_way(rng, sized_cpm):
    """Along the null vector of E the loops open with the square of the way; forward kinematics has a double root."""
    for p, signs, tool, ends in singular_postures(rng, sized_cpm, 40):
        angles = np.array(eq.limb_angles(p, tuple(tool), signs))
        limbs = rotary.limbs(p, tuple(tool), tuple(angles))
        rods = np.array(rotary.rods(p, limbs).e) / p.L2
        _, values, ways = np.linalg.svd(rods)
        assert values[2] < 1e-12
        for h in (1e-3, 1e-4):
            off = np.abs(residuals(p, angles, tool + h * p.L2 * ways[2])).max()
            assert 0.1 * h * h < off <= 2.0 * h * h
        distances = np.sort(np.linalg.norm(algebraic_solutions(p, angles) - tool, axis=1)) / p.L2
        assert distances[1] < 1e-4 < distances[2] or distances[2] < 0.05
        assert np.linalg.norm(forward.solutions(p, angles) - tool, axis=1).min() < 1e-5 * p.L2
        with pytest.raises(SingularError) as caught:
            CpmRotaryModel(p, signs).working_modes(tool)
        assert caught.value.kind == "type-2"
        model = CpmRotaryModel(p, signs)
        with pytest.raises(SingularError, match="only through a type-2 singularity"):
            model.reach(ends[1].q_full[3:], ends[0])


def test_past_a_singularity_two_solutions_are_gone(rng, sized_cpm):
    """On one side of a fold there are two more than on the other, however near; nothing open is ever handed out."""
    for p, signs, tool, _ in singular_postures(rng, sized_cpm, 15):
        angles = np.array(eq.limb_angles(p, tuple(tool), signs))
        rods = rotary.rods(p, rotary.limbs(p, tuple(tool), tuple(angles)))
        opening = np.linalg.svd(np.array(rods.e).T)[2][-1] * np.array(rods.drive)
        for h in (1e-6, 1e-8, 1e-10):
            step = h * opening / np.linalg.norm(opening)
            sides = [forward.solutions(p, angles + sign * step) for sign in (1, -1)]
            assert abs(len(sides[0]) - len(sides[1])) == 2
            for found, sign in zip(sides, (1, -1), strict=True):
                for one in found:
                    assert np.abs(residuals(p, angles + sign * step, one)).max() < 4e-12


def test_type_1_is_the_sine_of_the_elbow(held):
    for p, signs, tool, angles in held:
        both = CpmModel(p, signs).angles(CpmModel(p, signs).close(tool))
        found = rotary.type_1(p, rotary.rods(p, rotary.limbs(p, tuple(tool), tuple(angles))))
        np.testing.assert_allclose(found, np.sin(both[:, 1] - both[:, 0]), rtol=0, atol=1e-13)


def test_type_1_is_a_stretched_limb_which_the_motors_may_pass(held):
    """sin(theta_i2 - theta_i1) changes its sign, the dynamics stays what it is, the tool does not feel that motor."""
    passed = 0
    for p, signs, tool, _ in held[:45]:
        model = CpmRotaryModel(p, signs)
        limb = passed % 3
        try:
            start = model._place(tuple(tool.tolist()), signs, (0.0,) * 3)
            type_1, _ = model.singularities(start)
        except SingularError:
            continue
        second = CpmModel(p, signs).angles(CpmModel(p, signs).close(tool))
        target = np.array(start.q)
        target[limb] += 1.6 * ((second[limb, 1] - second[limb, 0] + np.pi) % (2 * np.pi) - np.pi)
        try:
            end = model.close(target, start)
        except (SingularError, ClosureError):
            continue
        now = model.singularities(end)[0]
        if now[limb] * type_1[limb] > 0:
            continue
        passed += 1
        low, high = 0.0, 1.0
        for _ in range(45):
            middle = 0.5 * (low + high)
            there = model.close(start.q + middle * (target - start.q), start)
            low, high = (middle, high) if model.singularities(there)[0][limb] * type_1[limb] > 0 else (low, middle)
        assert abs(model.singularities(there)[0][limb]) < 1e-9
        assert np.abs(model.tool(there).jacobian[:, limb]).max() < 1e-8 * p.L1
        a = np.array([0.3, -0.2, 0.5])
        effort = model.inverse_dynamics(there, a, a)
        np.testing.assert_allclose(model.forward_dynamics(there, a, effort), a, rtol=1e-8)
    assert passed > 3


def test_the_papers_circle_crosses_singularities_in_two_working_modes_of_eight():
    p, t = Parameters(), np.linspace(0.0, CIRCLE.duration, 4001)
    tool = tuple(
        c + CIRCLE.radius * f
        for c, f in zip(CIRCLE.centre, (np.cos(CIRCLE.omega * t), np.sin(CIRCLE.omega * t), 0 * t), strict=True)
    )
    crossing = []
    for signs in MODES:
        limbs = rotary.limbs(p, tool, eq.limb_angles(p, tool, signs, np), np)
        measure = rotary.rods(p, limbs).volume / p.L2**3
        if measure.min() < 0 < measure.max():
            crossing.append(signs)
        elif signs == (1, 1, 1):
            assert measure.min() > 0.45
    assert crossing == [(1, 1, -1), (-1, 1, -1)]


# ---- dynamics --------------------------------------------------------------------------------------------------------


@pytest.fixture
def moving(rng, held):
    """Postures of both models with speeds and accelerations: (rotary, linear, its posture, posture, v, a)."""
    made = []
    for p, signs, tool, _ in held * 2:
        model, linear = CpmRotaryModel(p, signs), CpmModel(p, signs)
        try:
            at = model._place(tuple(tool.tolist()), signs, (0.0,) * 3)
        except SingularError:
            continue
        if abs(model.singularities(at)[1]) > 0.05:
            made.append((model, linear, linear.close(tool), at, rng.normal(size=3), 5 * rng.normal(size=3)))
    assert len(made) > 200
    return made


def close_to(found, wanted, size=None):
    size = np.abs(wanted).max() if size is None else size
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-10 * size)


def test_jacobian_is_the_inverse_of_gamma(moving):
    for model, linear, there, at, v, a in moving:
        j = model.tool(at).jacobian
        close_to(linear.gamma(there) @ j, np.eye(3), 1.0 + np.abs(linear.gamma(there)).max() * np.abs(j).max())
        tool = model.tool(at, v)
        velocity = tool.jacobian @ v
        second = np.linalg.solve(linear.gamma(there), a - linear.gamma_dot(there, velocity) @ velocity)
        close_to(tool.jacobian @ a + tool.drift, second)


def test_dynamics_is_the_linear_models_by_the_velocity_map(moving):
    """torque = J' force at every motion: (39), its mass matrix and gravity turned into motor angles."""
    for model, linear, there, at, v, a in moving:
        tool = model.tool(at, v)
        velocity, acceleration = tool.jacobian @ v, tool.jacobian @ a + tool.drift
        force = linear.inverse_dynamics(there, velocity, acceleration)
        torque = tool.jacobian.T @ force
        close_to(model.inverse_dynamics(at, v, a), torque, np.abs(np.abs(tool.jacobian.T) @ np.abs(force)).max())
        terms, its = model.terms(at, v), linear.terms(there, velocity)
        close_to(terms.mass, tool.jacobian.T @ its.mass @ tool.jacobian)
        close_to(terms.gravity, tool.jacobian.T @ its.gravity, np.abs(tool.jacobian.T @ np.abs(its.gravity)).max())
        back = model.forward_dynamics(at, v, torque)
        close_to(back, a, np.abs(np.linalg.inv(terms.mass)).max() * np.abs(torque).max() + np.abs(a).max())
        assert model.potential_energy(at) == pytest.approx(linear.potential_energy(there), rel=1e-12)
        close_to(linear.forward_dynamics(there, velocity, force), acceleration)


def test_multipliers_are_what_the_motors_leave_over(moving):
    """(31) to (33) with torques, (36) to (38) without forces: what lambda does not give, the motors do."""
    for model, linear, there, at, v, a in moving[:60]:
        tool = model.tool(at, v)
        velocity, acceleration = tool.jacobian @ v, tool.jacobian @ a + tool.drift
        p = model.parameters
        needs = 2 * p.A * acceleration - [0.0, 0.0, p.E]
        multiplier = -np.linalg.solve(linear.gamma(there).T, needs)  # no force on a slider
        whole = linear.multipliers(there, velocity, acceleration)
        close_to(model.inverse_dynamics(at, v, a), whole - multiplier, np.abs(whole).max() + np.abs(multiplier).max())


# ---- branches --------------------------------------------------------------------------------------------------------


def test_closing_keeps_the_assembly_mode_and_comes_back(held, rng):
    """Reversible, and the same as a thousand small steps: the proof's step never lands on another solution."""
    walked = 0
    for p, signs, tool, _ in held[:60]:
        model = CpmRotaryModel(p, signs)
        try:
            start = model._place(tuple(tool.tolist()), signs, (0.0,) * 3)
            target = start.q + rng.uniform(-0.6, 0.6, 3)
            end = model.close(target, start)
        except (SingularError, ClosureError):
            continue
        walked += 1
        np.testing.assert_array_equal(end.q, target)
        assert model.branch(end).assembly == model.branch(start).assembly
        assert end.gap[0] < 1e-13 * p.L2
        assert np.linalg.norm([at.q_full[3:] - end.q_full[3:] for at in model.assembly_modes(target)], axis=1).min() < (
            1e-9 * p.L2
        )
        back = model.close(start.q, end)
        np.testing.assert_allclose(back.q_full, start.q_full, rtol=0, atol=1e-9 * max(1.0, p.L2))
        now = start
        for s in np.linspace(0.0, 1.0, 101)[1:]:
            now = model.close(start.q + s * (target - start.q), now)
        np.testing.assert_allclose(now.q_full, end.q_full, rtol=0, atol=1e-9 * max(1.0, p.L2))
    assert walked > 15


def test_a_way_along_a_singularity_ends(monkeypatch):
    """Nearer and nearer to a singularity the proved steps get shorter: their number is bounded."""
    model = CpmRotaryModel()
    target = model.home.q + np.array([0.2, -0.1, 0.3])
    assert model.close(target).q.tolist() == target.tolist()
    monkeypatch.setattr(tracking, "MOST_STEPS", 3)
    with pytest.raises(SingularError, match="type-2 singularity after"):
        model.close(target)


def test_models_can_be_sent_to_other_processes():
    model = CpmRotaryModel(signs=(1, -1, 1)).with_payload(0.3)
    other = pickle.loads(pickle.dumps(model))
    assert (other.signs, other.parameters) == (model.signs, model.parameters)
    np.testing.assert_array_equal(other.home.q_full, model.home.q_full)


def test_a_way_into_a_singularity_is_refused(held, rng):
    """It says how far it got; the tool is nearly there, and the step that would leave the branch is not taken."""
    kinds = []
    for p, signs, tool, _ in held[:80]:
        model = CpmRotaryModel(p, signs)
        try:
            start = model._place(tuple(tool.tolist()), signs, (0.0,) * 3)
        except SingularError:
            continue
        target = start.q + rng.normal(size=3)
        try:
            model.close(target, start)
        except (SingularError, ClosureError) as caught:
            error = caught
        else:
            continue
        kinds.append(type(error))
        if isinstance(error, SingularError):
            assert error.kind == "type-2"
            assert error.measure < error.limit == SMALLEST_MEASURE
            assert len(forward.solutions(p, target))
        else:
            assert 0.0 <= error.progress < 1.0
            assert error.gap[0] > 0.0
            assert not len(forward.solutions(p, target))
    assert min(kinds.count(SingularError), kinds.count(ClosureError)) > 5


def test_reach_stays_in_the_working_mode_and_turns_the_motors_as_the_line_does(held, rng):
    """The same angles as two hundred small steps of the tool, from a start some turns away."""
    long_way = 0
    for p, signs, tool, _ in held:
        model, other = CpmRotaryModel(p, signs), tool + p.L1 * rng.uniform(-1.5, 1.5, 3)
        try:
            start = model._place(tuple(tool.tolist()), signs, (2 * np.pi, -4 * np.pi, 0.0))
            at, now = model.reach(other, start), start
            for s in np.linspace(0.0, 1.0, 201)[1:]:
                now = model._place(tuple((tool + s * (other - tool)).tolist()), signs, tuple(now.q))
        except (SingularError, LimbReachError):
            continue
        long_way += 1
        assert model.branch(at).signs == signs
        np.testing.assert_allclose(at.q, now.q, rtol=0, atol=1e-11)
    assert long_way > 15


def test_a_first_rod_may_turn_by_much_more_than_its_limb():
    """Shorter than the second it swings round when the limb unfolds: here by more than a quarter of a turn."""
    p, ends, turned = (
        Parameters(L=0.1, L1=0.3, L2=0.6, D=1.2),
        np.array([[0.35, 0.326, 0.226], [0.35, 0.722, 0.622]]),
        0,
    )
    for signs in MODES:
        model = CpmRotaryModel(p, signs)
        now = start = model._place(tuple(ends[0].tolist()), signs, (20.0, -20.0, 0.0))
        try:
            at = model.reach(ends[1], start)
        except SingularError:
            continue
        for s in np.linspace(0.0, 1.0, 201)[1:]:
            now = model._place(tuple((ends[0] + s * (ends[1] - ends[0])).tolist()), signs, tuple(now.q))
        np.testing.assert_allclose(at.q, now.q, rtol=0, atol=1e-11)
        turned += abs(at.q[0] - start.q[0]) > 0.6 * np.pi
    assert turned > 0


def test_limits_of_a_limb_have_their_error():
    model = CpmRotaryModel()
    with pytest.raises(LimbReachError, match="limb 1 of cpm_rotary"):
        model.reach([0.4, 0.99, 0.3])
    edge = 0.873 - 1e-12
    with pytest.raises(SingularError) as caught:
        model.reach([0.4, 0.105 + edge * np.cos(0.8), edge * np.sin(0.8)])
    assert caught.value.kind == "type-1"


@pytest.mark.parametrize("angles", [[0.1, 0.2], [0.1, np.nan, 0.2], "abc"])
def test_bad_angles_are_refused(angles):
    with pytest.raises(InputError, match="angles"):
        forward.solutions(Parameters(), angles)
