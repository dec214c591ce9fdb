"""A rod without mass between two balls is a distance: every motion and effort is the same, its spin is nobody's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit import judge
from kit.blueprint import random_mounting
from kit.built import built
from kit.by_joint import by_joint, full, placed
from kit.curved import RODS
from kit.postures import moving, random_posture, scale_of
from kit.quickly import few
from kit.rods import delta

from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.compile.equations.elimination import STRAIN_LIMIT
from cutjoint.description.model import JointPhysics
from cutjoint.errors import CompileError, DynamicsError
from cutjoint.mechanism import Load
from cutjoint.simulation import Adaptive, ConstrainedPlant, run

Array = np.ndarray
Rng = np.random.Generator

ACCURACY = 1e-9
ENDS = ("spherical", "universal", "spherical and heavy", "universal and heavy")
PAIRS = [(name, ends, seed) for name in RODS for ends in ENDS for seed in range(4)]
QUICK = [("rssr", "spherical", 0), ("hanging_plate", "spherical and heavy", 1)]
"""The cases of the quick suite; all take a moment."""


def pair(name: str, ends: str, seed: int, folder: Path) -> tuple[ClosedChain, ClosedChain, Any, Rng]:
    """The robot with rods, the same with distances, the oracle of the first one."""
    kind, _, others = ends.partition(" and ")
    chains = []
    for made in (ends, f"distance{' and heavy' if others else ''}"):
        rng = np.random.default_rng([seed, *name.encode()])
        plan, mounting = RODS[name](rng, made).plan, random_mounting(rng)
        scale = float(rng.choice([1e-3, 1.0, 1e3]))
        chains.append(built(plan, folder / made.replace(" ", "_"), mounting, scale, scale))
    (rods, oracle), (distances, _) = chains
    assert kind not in [cut.type for cut in rods.description.cuts if cut.type == "distance"]
    assert {cut.type.value for cut in rods.description.cuts if cut.name != "plate"} == {"spherical"}
    return rods, distances, oracle, rng


def common(rods: ClosedChain, distances: ClosedChain, vector: Array) -> Array:
    """A vector over the velocities of the one as that of the other, rods left out."""
    return full(distances, by_joint(rods, vector))


def configuration(rods: ClosedChain, distances: ClosedChain, q: Array) -> Array:
    """The same of configurations."""
    found = np.zeros(distances.nq)
    for index in range(1, distances.model.njoints):
        one, there = distances.model, rods.model.getJointId(distances.model.names[index])
        found[one.idx_qs[index] :][: one.nqs[index]] = q[rods.model.idx_qs[there] :][: one.nqs[index]]
    return found


@pytest.mark.parametrize("which", few(PAIRS, *QUICK))
def test_a_rod_without_mass_is_a_distance(which: tuple[str, str, int], tmp_path: Path) -> None:
    rods, distances, oracle, rng = pair(*which, tmp_path)
    unit = scale_of(rods, oracle)
    for at in (rods.home, random_posture(rods, oracle, rng)):
        same = distances.posture(configuration(rods, distances, np.array(at.q_full)))
        v, effort, weight, falling = drawn(rods, distances, oracle, at, rng)
        found = rods.full_forward_dynamics(at, v, effort)
        u, push = common(rods, distances, v), common(rods, distances, effort)
        wanted = distances.full_forward_dynamics(same, u, push)
        scale = common(rods, distances, unit)
        size = float(np.abs(wanted.acceleration / scale).max())
        apart = common(rods, distances, found.acceleration) - wanted.acceleration
        assert np.abs(apart / scale).max() < ACCURACY * size
        light = [cut.name for cut in distances.description.cuts if cut.type == "distance"]
        for name in light:  # it pulls along itself, as hard
            off = np.linalg.norm(np.array(found.loop_forces[name].force) - wanted.loop_forces[name].force)
            assert off < 1e-8 * weight / oracle.length
        # of all accelerations that do it, the least one
        spins = null_motions(rods, at)
        assert spins.shape[1] == len(light) * which[1].startswith("spherical")
        assert np.abs(spins.T @ (found.acceleration / unit)).max(initial=0.0) < 1e-9 * (size + falling)
        if distances.n:
            same_in_actuators(rods, rods, distances, at, same, falling, rng)


@pytest.mark.slow
@pytest.mark.parametrize("which", PAIRS)
def test_compiled_too(which: tuple[str, str, int], tmp_path: Path) -> None:
    rods, distances, oracle, rng = pair(*which, tmp_path)
    unit, machine = scale_of(rods, oracle), compiled(rods, cached=False)
    for at in (rods.home, random_posture(rods, oracle, rng, 0.2)):
        v, effort, _, falling = drawn(rods, distances, oracle, at, rng)
        found = rods.full_forward_dynamics(at, v, effort).acceleration / unit
        y = machine.kernel("full_forward")(at.q_full, v, effort, np.zeros(0))
        assert y[-1] <= STRAIN_LIMIT
        assert np.abs(y[:-1] / unit - found).max() < ACCURACY * np.abs(found).max()
        if distances.n:
            same = distances.posture(configuration(rods, distances, np.array(at.q_full)))
            same_in_actuators(machine, rods, distances, at, same, falling, rng)


def drawn(
    rods: ClosedChain, distances: ClosedChain, oracle: Any, at: Any, rng: Rng
) -> tuple[Array, Array, float, float]:
    """A velocity that the loops allow, efforts on all joints but those of rods, the weight times a length [J], and the
    square of the rate at which things fall."""
    unit, p = scale_of(rods, oracle), placed(rods, oracle, at.q_full)
    falling = float(np.linalg.norm(oracle.robot.gravity)) / oracle.length
    motions = moving(rods, p, rng.normal(size=p.mobility)) / unit
    weight = falling * p.heaviest
    effort = 0.3 * weight * rng.normal(size=rods.nv) / unit
    ends = {name: 0.0 * own if name.endswith("_end") else own for name, own in by_joint(rods, effort).items()}
    return unit * motions * np.sqrt(falling) / np.abs(motions).max(), full(rods, ends), weight, falling


def same_in_actuators(
    robot: Any, rods: ClosedChain, distances: ClosedChain, at: Any, same: Any, falling: float, rng: Rng
) -> None:
    """The same efforts and accelerations in actuated coordinates."""
    unit = np.array([rods.length if one.kind == "translation" else 1.0 for one in rods.actuators])
    v, a = np.sqrt(falling) * unit * rng.normal(size=rods.n), falling * unit * rng.normal(size=rods.n)
    wanted = distances.inverse_dynamics(same, v, a)
    np.testing.assert_allclose(robot.inverse_dynamics(at, v, a), wanted, rtol=0, atol=ACCURACY * np.abs(wanted).max())
    np.testing.assert_allclose(robot.forward_dynamics(at, v, wanted), a, rtol=0, atol=ACCURACY * np.abs(a).max())
    report, other = rods.mobility(at), distances.mobility(same)
    assert report.mobility - report.idle_mobility == other.mobility - other.idle_mobility
    assert report.determined


def null_motions(chain: ClosedChain, at: Any) -> Array:
    """Orthonormal motions that move no mass, from the singular values of loops and mass together, dimensionless."""
    k = chain._k
    mass = k.tree.mass_matrix(at.q_full) * k.column_scale[:, None] * k.column_scale
    both = np.vstack([k.at(at.q_full).scaled, mass / np.abs(mass).max()])
    values, right = np.linalg.svd(both)[1:]
    return np.asarray(right[int(np.sum(values > 1e-9)) :].T)


@pytest.mark.slow
@pytest.mark.parametrize("side", ["arms", "platform", "through"])
def test_deltas_whose_rods_weigh_nothing(side: str, tmp_path: Path) -> None:
    """Wherever the rods hang in the tree, also where one of them carries the platform."""
    rng = np.random.default_rng(5)
    plan = delta(rng, side)
    for link in plan.inertias:
        if link.startswith(("left", "right")):
            plan.inertias[link] = None
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    machine = compiled(chain, cached=False)
    for at in (chain.home, random_posture(chain, oracle, rng, 0.2)):
        p = placed(chain, oracle, at.q_full)
        state = p.moving(by_joint(chain, moving(chain, p, rng.normal(size=p.mobility))))
        assert state.massless.shape[1] == 6
        effort = chain.full_effort(rng.normal(size=3))
        v = full(chain, state.speeds)
        judge.require(judge.forward(chain, state, at, v, effort), ACCURACY)
        judge.require(judge.actuated(chain, oracle, at, rng, machine), ACCURACY)
        wanted = chain.full_acceleration(at.q_full, v, effort)
        y = machine.kernel("full_forward")(at.q_full, v, effort, np.zeros(0))
        assert y[-1] <= STRAIN_LIMIT
        np.testing.assert_allclose(y[:-1], wanted, rtol=0, atol=ACCURACY * np.abs(wanted).max())


def acting(rods: ClosedChain, what: str) -> tuple[ClosedChain, Array, tuple[Load, ...]]:
    """A robot with something that acts on the spin of a rod: an effort (nv,), a load, or physics of its ball."""
    effort = np.zeros(rods.nv)
    if what == "effort":
        index = rods.model.getJointId("coupler_end")
        effort[rods.model.idx_vs[index] :][:3] = [0.1, 0.2, 0.3]
        return rods, effort, ()
    if what == "load":
        return rods, effort, (Load([0.0, 0.0, 0.0], [0.1, 0.2, 0.3], link="coupler_rod"),)
    physics = {"spring": JointPhysics(stiffness=0.5), "damping": JointPhysics(damping=0.1)}[what]
    joints = [replace(j, physics=physics) if j.name == "coupler_end" else j for j in rods.description.joints]
    return ClosedChain(replace(rods.description, joints=tuple(joints))), effort, ()


WHAT = ("effort", "load", "spring", "damping")


def pushed(what: str, folder: Path) -> tuple[ClosedChain, Any, Array, Array]:
    """A robot, a posture, a velocity at which a rod spins and an effort, with something that acts on the spin."""
    rods, _, _, rng = pair("rssr", "spherical", 0, folder)
    robot, effort, loads = acting(rods, what)
    at, spin = robot.home, null_motions(robot, robot.home)
    v = robot.project(at.q_full, rng.normal(size=robot.nv) / robot.length)[1]
    v = v + 3.0 * robot._k.column_scale * (spin @ np.ones(spin.shape[1]))
    return robot, at, v, effort + robot.full_load_effort(at, loads)


@pytest.mark.parametrize("what", WHAT)
def test_what_acts_on_the_spin_has_no_answer(what: str, tmp_path: Path) -> None:
    robot, at, v, effort = pushed(what, tmp_path)
    with pytest.raises(DynamicsError, match=r"moves no mass, of coupler_end: .* give it an inertia, or take away"):
        robot.full_forward_dynamics(at, v, effort)


@pytest.mark.slow
@pytest.mark.parametrize("what", WHAT)
def test_compiled_it_has_none_either(what: str, tmp_path: Path) -> None:
    robot, at, v, effort = pushed(what, tmp_path)
    machine = compiled(robot, cached=False)
    if what in ("effort", "load"):
        assert not machine.kernel("full_forward")(at.q_full, v, effort, np.zeros(0))[-1] <= STRAIN_LIMIT
        with pytest.raises(DynamicsError, match="moves no mass"):
            machine.full_acceleration(at.q_full, v, effort)
    else:
        with pytest.raises(CompileError, match=r"'full_forward' of rssr cannot be compiled: .* moves no mass"):
            machine.kernel("full_forward")


@pytest.mark.slow
@pytest.mark.parametrize("name", ["rod_delta", "hanging_plate", "rssr"])
def test_they_fall_alike(name: str, tmp_path: Path) -> None:
    """Simulated: compiled, and in full coordinates without it, and with distances."""
    rods, distances, _, _ = pair(name, "spherical", 2, tmp_path)
    duration = 0.5 * float(np.sqrt(rods.length / 9.81))
    found = []
    for chain, plain in ((distances, False), (rods, False), (rods, True)):
        tool = chain.description.tool
        if tool is None:
            chain = chain.rebuilt(replace(chain.description, tool=type(chain.description.cuts[0].a)("plate")))
        settings: dict[str, Any] = {"integrator": Adaptive(1e-10, 1e-12)} if plain else {}
        robot = ConstrainedPlant(chain) if plain else chain
        result = run(robot, duration=duration, every=duration / 5, **settings)
        found.append(np.array([*result.tool.T, *result.potential[None], *result.kinetic[None]]))
    lengths = np.abs(found[0][:3, -1] - found[0][:3, 0]).max()
    assert lengths > 1e-3 * rods.length
    for other in found[1:]:
        assert np.abs(other[:3] - found[0][:3]).max() < 1e-7 * rods.length
        assert np.abs(other[3:] - found[0][3:]).max() < 1e-7 * np.abs(found[0][3:]).max()
