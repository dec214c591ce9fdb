"""Laws of dampers, friction, springs, rotors, stops and bushings, over random robots of all joint and cut types."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.ball_rods import ankle
from kit.physics import physics_of, with_physics
from kit.quickly import few
from kit.random_robots import random_robot

from cutjoint.chain import ClosedChain
from cutjoint.description import JointPhysics, Limits, load_description
from cutjoint.errors import ActuationError, CutjointError
from cutjoint.robots import load

SEEDS = few(range(40), 0, 1, 2, 3, 4, 5)
SHIPPED = ["fourbar", "fivebar", "stewart", "cpm", "omega3"]


def drawn(seed: int, folder: Path, bushings: float = 0.4) -> ClosedChain:
    """A random robot with random physics everywhere, and bushings in place of some cuts."""
    rng = np.random.default_rng(seed)
    plan = random_robot(rng, int(rng.integers(2, 7)), int(rng.integers(1, 4)), folder)
    return ClosedChain(with_physics(load_description(plan.write(folder)), rng, bushings))


def spread(chain: ClosedChain, rng: np.random.Generator) -> np.ndarray:
    """A configuration of the open tree, loops open."""
    return np.asarray(chain.integrate(chain.home.q_full, rng.normal(scale=0.2, size=chain.nv)))


@pytest.mark.parametrize("seed", SEEDS)
def test_springs_are_the_gradient_of_their_energy(seed: int, tmp_path: Path) -> None:
    chain, rng = drawn(seed, tmp_path, bushings=1.0), np.random.default_rng(seed + 100)
    k, h = chain._k, 1e-3
    for _ in range(3):
        q, way = spread(chain, rng), rng.normal(size=chain.nv)
        way /= np.abs(way).max()
        there = [k.spring_energy(np.asarray(chain.integrate(q, s * h * way))) for s in (-2, -1, 1, 2)]
        slope = (there[0] - 8.0 * there[1] + 8.0 * there[2] - there[3]) / (12.0 * h)
        force = k.at(q).springs
        assert slope == pytest.approx(force @ way, abs=2e-9 * (np.abs(force) @ np.abs(way) + k.spring_energy(q)))


@pytest.mark.parametrize("seed", SEEDS)
def test_friction_takes_power_and_is_odd(seed: int, tmp_path: Path) -> None:
    chain, rng = drawn(seed, tmp_path), np.random.default_rng(seed + 100)
    for size in (1e-4, 0.1, 3.0):
        q, v = spread(chain, rng), size * rng.normal(size=chain.nv)
        placed = chain._k.at(q)
        assert placed.friction(v) @ v > 0.0
        assert placed.friction(-v) == pytest.approx(-placed.friction(v), rel=1e-14)
        assert chain.full_dissipation(q, v) == pytest.approx(placed.friction(v) @ v)


@pytest.mark.parametrize("seed", SEEDS)
def test_full_coordinates_keep_the_books_of_power(seed: int, tmp_path: Path) -> None:
    """d(kinetic + potential)/dt = effort v - dissipation, along the motion that forward dynamics gives."""
    chain, rng = drawn(seed, tmp_path), np.random.default_rng(seed + 100)
    k = chain._k
    from cutjoint.chain.rank import null_space

    home = chain.home
    motions = null_space(k.at(home.q_full).scaled)
    if not motions.shape[1]:
        pytest.skip("a structure")
    v = k.column_scale * (motions @ rng.normal(size=motions.shape[1]))
    effort = rng.normal(size=chain.nv)
    try:
        found = chain.full_forward_dynamics(home, v, effort)
    except CutjointError:
        pytest.skip("a motion that moves no mass")
    mass = k.tree.mass_matrix(home.q_full)
    power = v @ (mass @ found.acceleration + k.tree.bias(home.q_full, v) + k.at(home.q_full).springs)
    given = effort @ v - chain.full_dissipation(home, v)
    terms = np.abs(v) @ (np.abs(mass) @ np.abs(found.acceleration) + np.abs(effort)) + abs(given)
    assert power == pytest.approx(given, abs=1e-10 * terms)


@pytest.mark.parametrize("robot", SHIPPED)
def test_both_coordinates_and_both_ways(robot: str) -> None:
    rng = np.random.default_rng(3)
    chain = ClosedChain(with_physics(load(robot).description, rng))
    for size in (0.0, 1e-3, 1.0):
        at, v = chain.home, size * rng.normal(size=chain.n)
        a = rng.normal(size=chain.n)
        effort, terms = chain.inverse_dynamics(at, v, a), chain.terms(at, v)
        scale = np.abs(terms.mass) @ np.abs(a) + np.abs(terms.springs) + np.abs(terms.friction) + np.abs(terms.gravity)
        assert np.abs(terms.mass @ a + terms.bias - effort).max() < 1e-12 * scale.max()
        assert chain.forward_dynamics(at, v, effort) == pytest.approx(a, abs=1e-10 * (1.0 + np.abs(a).max()))
        moving, wanted = chain.full_velocity(at, v), chain.tangent(at) @ a + chain.drift(at, v)
        full = chain.full_forward_dynamics(at, moving, chain.full_effort(effort)).acceleration
        assert np.abs(full - wanted).max() < 1e-8 * (1.0 + np.abs(wanted).max())
        again = chain.full_inverse_dynamics(at, moving, wanted)
        assert again.effort == pytest.approx(effort, abs=1e-9 * scale.max())
        assert chain.dissipation(at, v) == pytest.approx(terms.friction @ v, abs=1e-12)


@pytest.mark.parametrize("robot", SHIPPED)
def test_springs_of_cuts_are_the_gradient_where_loops_are_closed(robot: str) -> None:
    rng, h = np.random.default_rng(4), 1e-3
    chain = ClosedChain(with_physics(load(robot).description, rng))
    springs = chain.terms(chain.home).springs
    for k in range(chain.n):
        step = h * np.eye(chain.n)[k]
        energy = [chain.spring_energy(chain.close(chain.home.q + s * step, limits="ignore")) for s in (-2, -1, 1, 2)]
        slope = (energy[0] - 8.0 * energy[1] + 8.0 * energy[2] - energy[3]) / (12.0 * h)
        assert slope == pytest.approx(springs[k], abs=1e-7 * (np.abs(springs).max() + energy[0]))


@pytest.mark.parametrize("robot", SHIPPED)
def test_an_ideal_robot_is_the_one_without_any_of_it(robot: str) -> None:
    bare = load(robot).description
    real = with_physics(bare, np.random.default_rng(1), bushings=0.5)
    one, other = ClosedChain(real.ideal()), ClosedChain(bare.ideal())
    at, v = one.home, np.linspace(0.3, 0.7, one.n)
    terms = one.terms(at, v)
    for name, wanted in vars(other.terms(other.home, v)).items():
        assert np.array_equal(getattr(terms, name), wanted)
    assert not terms.springs.any()
    assert not terms.friction.any()


@pytest.mark.parametrize("gear", [1.0, -3.0, 50.0])
def test_a_rotor_weighs_gear_squared(gear: float) -> None:
    description = load("fourbar").description
    name = description.actuators[0]
    joints = tuple(
        replace(one, physics=JointPhysics(rotor=0.002, gear=gear)) if one.name == name else one
        for one in description.joints
    )
    light, heavy = ClosedChain(description), ClosedChain(replace(description, joints=joints))
    at = heavy.home
    added = heavy.terms(at).mass - light.terms(light.home).mass
    assert added[0, 0] == pytest.approx(0.002 * gear**2, rel=1e-10)


def test_a_stop_pushes_and_never_pulls() -> None:
    description = load("fourbar").description
    name = description.actuators[0]
    physics = JointPhysics(stop_stiffness=100.0, stop_damping=5.0)

    def chain(lower: float | None, upper: float | None) -> ClosedChain:
        changed = tuple(
            replace(one, limits=Limits(lower, upper), physics=physics, type=type(one.type)("revolute"))
            if one.name == name
            else one
            for one in description.joints
        )
        return ClosedChain(replace(description, joints=changed))

    free = chain(None, None)
    start = float(free.home.q[0])
    inside = chain(start - 1.0, start + 1.0)
    beyond = chain(start - 1.0, start - 0.1)
    still = np.zeros(1)
    assert not inside.terms(inside.home, still).springs.any()
    assert beyond.terms(beyond.home, still).springs[0] == pytest.approx(10.0)
    assert beyond.potential_energy(beyond.home) - free.potential_energy(free.home) == pytest.approx(0.5)
    for v, wanted in ((1.0, 15.0), (-1.0, 5.0), (-2.0, 0.0), (-50.0, 0.0)):
        terms = beyond.terms(beyond.home, [v])
        assert terms.springs[0] + terms.friction[0] == pytest.approx(wanted)
        assert terms.friction[0] * v >= 0.0


def test_a_bushing_closes_no_loop() -> None:
    rng = np.random.default_rng(0)
    description = with_physics(load("fourbar").description, rng, bushings=1.0)
    chain = ClosedChain(description)
    assert not chain.description.closing
    assert chain.mobility().mobility == chain.nv
    assert len(chain.cut_placements(chain.home)) == len(description.cuts)
    with pytest.raises(ActuationError):
        chain.inverse_dynamics(chain.home, [0.0], [0.0])


def test_friction_in_the_balls_drives_idle_rods(tmp_path: Path) -> None:
    """Rods between balls that rub do not keep their momentum: the actuated coordinates alone do not tell the motion."""
    rng = np.random.default_rng(5)
    description = load_description(ankle(rng, even=True).write(tmp_path))
    free = ClosedChain(description)
    rubbed = tuple(replace(cut, physics=physics_of(cut.type, rng, rotor=False)) for cut in description.cuts)
    assert free.idle_is_cyclic
    assert not ClosedChain(replace(description, cuts=rubbed)).idle_is_cyclic
