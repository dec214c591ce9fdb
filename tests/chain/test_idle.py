"""Rods and legs that spin about themselves are carried: no motor holds them, and they move as nothing drives them.

The oracle of maximal coordinates says what is right; potential and kinetic energy by finite differences say it again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from kit import rods
from kit.blueprint import Blueprint
from kit.built import built
from kit.by_joint import placed
from kit.judge import actuated, everything, require
from oracles.maximal import Maximal

from cutjoint.chain import ClosedChain
from cutjoint.control import NoControl
from cutjoint.errors import ActuationError, InputError
from cutjoint.motion import Hold, Reference
from cutjoint.simulation import Adaptive, ConstrainedPlant, ReducedPlant, run

Rng = np.random.Generator
PLANS: dict[str, tuple[Callable[..., Blueprint], int, int]] = {
    "delta, rods on the arms": (lambda rng, out=0.0: rods.delta(rng, "arms", out), 9, 6),
    "delta, rods on the platform": (lambda rng, out=0.0: rods.delta(rng, "platform", out), 9, 6),
    "delta, carried by a rod": (lambda rng, out=0.0: rods.delta(rng, "through", out), 9, 6),
    "ankle": (rods.ankle, 4, 2),
    "ankle without a tool": (lambda rng, out=0.0: rods.ankle(rng, out, tool=False), 4, 2),
    "six SPS legs": (rods.sps_6, 12, 6),
    "six SPS legs without a tool": (lambda rng, out=0.0: rods.sps_6(rng, out, tool=False), 12, 6),
    "three SPS legs, one of them drives": (rods.legs_3, 4, 3),
}


@dataclass(frozen=True, eq=False)
class Robot:
    """A chain, its oracle, and random postures; `idle` is how many of its freedoms are."""

    chain: ClosedChain
    oracle: Maximal
    postures: tuple[Any, ...]
    mobility: int
    idle: int


@cache
def robot(name: str, out_of_round: float = 0.0, seed: int = 0) -> Robot:
    make, mobility, idle = PLANS[name]
    rng = np.random.default_rng(seed)
    with TemporaryDirectory() as folder:
        chain, oracle = built(make(rng, out_of_round), Path(folder))
    units = np.array([chain.length if one.kind == "translation" else 1.0 for one in chain.actuators])
    postures = tuple(chain.close(chain.home.q + 0.1 * units * rng.uniform(-1.0, 1.0, chain.n)) for _ in range(2))
    return Robot(chain, oracle, postures, mobility, idle)


@pytest.mark.parametrize(
    ("out_of_round", "seeds"), [(0.45, [0]), pytest.param(0.0, [0, 1, 2, 3], marks=pytest.mark.slow)]
)
@pytest.mark.parametrize("name", PLANS)
def test_dynamics_is_that_of_the_oracle(name: str, out_of_round: float, seeds: list[int]) -> None:
    """Also for bent rods: at a given state everything is right, whatever comes after."""
    rng = np.random.default_rng(1)
    robots = [robot(name, out_of_round, seed) for seed in seeds]
    for one, at in [(each, at) for each in robots for at in each.postures]:
        report = one.chain.mobility(at)
        assert (report.mobility, report.idle_mobility, report.determined) == (one.mobility, one.idle, True)
        assert not set(report.idle) & set(one.chain.description.actuators)
        v = one.chain.project(at.q_full, rng.normal(size=one.chain.nv))[1]
        require(everything(one.chain, one.oracle, at, v, rng.normal(size=one.chain.nv), rng), 1e-9, name)


def gravity_slope(chain: ClosedChain, at: Any, h: float) -> np.ndarray:
    """Derivative of the potential energy along close(), by central differences, (n,)."""
    sides = [
        [chain.potential_energy(chain.close(at.q + s * step, at)) for s in (1, -1)] for step in h * np.eye(chain.n)
    ]
    return np.array([(ahead - behind) / (2.0 * h) for ahead, behind in sides])


@pytest.mark.parametrize("name", PLANS)
def test_holding_efforts_are_the_slope_of_the_potential_energy(name: str) -> None:
    one, h = robot(name), 1e-4
    chain, still = one.chain, np.zeros(one.chain.n)
    for at in one.postures:
        hold = chain.inverse_dynamics(at, still, still)
        slope = gravity_slope(chain, at, h)
        np.testing.assert_allclose(hold, slope, rtol=0.0, atol=1e-6 * np.abs(slope).max())


def kinetic_energy(chain: ClosedChain, at: Any, v: np.ndarray, h: float = 1e-4) -> float:
    """Of a robot of round rods without spin, from where its links are a moment before and after."""
    before, after = (chain.close(at.q + sign * h * v, at) for sign in (-1.0, 1.0))
    one, two = (chain.link_placements(side) for side in (before, after))
    here, energy = chain.link_placements(at), 0.0
    for link in chain.description.links:
        body = link.inertial
        if body is None or link.name == "base":
            continue
        speed = ((two[link.name] - one[link.name]) / (2.0 * h) @ np.r_[body.com, 1.0])[:3]
        rotation = here[link.name][:3, :3]
        w = (two[link.name][:3, :3] - one[link.name][:3, :3]) / (2.0 * h) @ rotation.T
        spin = 0.5 * np.array([w[2, 1] - w[1, 2], w[0, 2] - w[2, 0], w[1, 0] - w[0, 1]])
        if link.name.startswith(("rod", "left", "right", "leg")):
            axis = rotation @ np.linalg.eigh(body.inertia)[1][:, 0]
            spin = spin - (spin @ axis) * axis
        energy += 0.5 * body.mass * speed @ speed + 0.5 * spin @ rotation @ body.inertia @ rotation.T @ spin
    return float(energy)


@pytest.mark.parametrize("name", ["delta, rods on the arms", "ankle", "six SPS legs"])
def test_release_is_that_of_lagrange(name: str) -> None:
    """Acceleration from rest without efforts: M a = -dV/dq, with M and V by finite differences of the links' places."""
    one, still, h = robot(name), np.zeros(robot(name).chain.n), 1e-4
    chain, units = one.chain, np.eye(one.chain.n)
    at = one.postures[0]
    own = [kinetic_energy(chain, at, u) for u in units]
    mass = np.diag([2.0 * e for e in own])
    for i in range(chain.n):
        for j in range(i):
            mass[i, j] = mass[j, i] = kinetic_energy(chain, at, units[i] + units[j]) - own[i] - own[j]
    slope = gravity_slope(chain, at, h)
    np.testing.assert_allclose(chain.terms(at).mass, mass, rtol=0.0, atol=1e-5 * np.abs(mass).max())
    wanted = -np.linalg.solve(mass, slope)
    found = chain.forward_dynamics(at, still, still)
    np.testing.assert_allclose(found, wanted, rtol=0.0, atol=1e-4 * np.abs(wanted).max())
    fell = chain.full_forward_dynamics(at, np.zeros(chain.nv), np.zeros(chain.nv)).acceleration
    np.testing.assert_allclose(chain.actuated_velocity(fell), found, rtol=0.0, atol=1e-10 * np.abs(found).max())


@pytest.mark.parametrize("out_of_round", [0.0, 0.45])
@pytest.mark.parametrize("name", PLANS)
def test_nothing_drives_the_idle_motions(name: str, out_of_round: float) -> None:
    """They have no momentum, no force acts on them, and forward dynamics is the inverse of inverse dynamics."""
    one, rng = robot(name, out_of_round), np.random.default_rng(2)
    chain = one.chain
    for at in one.postures:
        v, a = rng.normal(size=(2, chain.n))
        locked = chain._actuated.selection.astype(bool)
        matrix = np.vstack([chain._k.at(at.q_full).scaled, np.eye(chain.nv)[locked.any(axis=0)]])
        values, right = np.linalg.svd(matrix)[1:]
        idle = chain._k.column_scale[:, None] * right[int((values > 1e-9).sum()) :].T
        assert idle.shape[1] == one.idle
        v_full = chain.full_velocity(at, v)
        mass = chain._k.tree.mass_matrix(at.q_full)
        assert np.abs(idle.T @ mass @ v_full).max() < 1e-12 * (np.abs(idle.T) @ np.abs(mass) @ np.abs(v_full)).max()
        effort = chain.inverse_dynamics(at, v, a)
        np.testing.assert_allclose(chain.forward_dynamics(at, v, effort), a, rtol=0.0, atol=1e-10 * np.abs(a).max())
        full = chain.tangent(at) @ a + chain.drift(at, v)
        forces = chain._k.tree.forces(at.q_full, v_full, full)
        assert np.abs(idle.T @ forces).max() < 1e-11 * (np.abs(idle.T) @ np.abs(forces)).max()
        # the same motion in full coordinates, where nobody knows of idle motions
        moved = chain.full_forward_dynamics(at, v_full, chain.full_effort(effort)).acceleration
        np.testing.assert_allclose(moved, full, rtol=0.0, atol=1e-9 * np.abs(full).max())


def spin_momenta(one: Robot, observation_q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Angular momentum of every rod about its own axis."""
    from kit.by_joint import by_joint

    state = placed(one.chain, one.oracle, observation_q).moving(by_joint(one.chain, v))
    found = []
    for link, body in one.oracle.robot.bodies.items():
        if link.startswith(("rod", "left", "right")):
            rotation = state.placed.poses[link].rotation
            axis = rotation @ np.linalg.eigh(body.inertia)[1][:, 0]
            found.append(float(axis @ rotation @ body.inertia @ rotation.T @ state.twist(link)[1]))
    return np.array(found)


@pytest.mark.parametrize("name", ["delta, rods on the arms", "ankle"])
def test_a_fall_keeps_the_energy_and_the_spin_of_every_rod(name: str) -> None:
    """In full coordinates, rods spinning at the start."""
    one, rng = robot(name), np.random.default_rng(3)
    chain, plant = one.chain, ConstrainedPlant(one.chain)
    at = one.postures[0]
    free = np.array(chain.project(at.q_full, np.zeros(chain.nv))[1])
    v = chain.full_velocity(at, 0.5 * rng.normal(size=chain.n)) + free
    tangent = chain._mobility.tangent(chain._k.at(at.q_full))
    v = v + tangent.idle @ rng.normal(size=one.idle) * 0.02
    before = spin_momenta(one, np.array(at.q_full), v)
    assert np.abs(before).max() > 0.0
    state = plant.start(at, np.zeros(chain.n))
    state = type(state)(state.q, v)
    energy = plant.observe(state).kinetic + plant.observe(state).potential
    h, none = 5e-4, np.zeros(chain.n)
    for _ in range(200):
        state = step(plant, state, none, h)
    after = plant.observe(state)
    assert after.kinetic + after.potential == pytest.approx(energy, rel=1e-9)
    assert np.abs(chain.actuated(state.q) - at.q).max() > 0.02, "it has moved"
    np.testing.assert_allclose(spin_momenta(one, state.q, state.v), before, rtol=0.0, atol=1e-8 * np.abs(before).max())


def step(plant: ConstrainedPlant, state: Any, effort: np.ndarray, h: float) -> Any:
    """One step of the classical Runge-Kutta method, put back onto the loops."""
    u0 = plant.chart(state)

    def rate(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        there = plant.moved(state, u, v)
        return plant.chart_rate(state, there), plant.acceleration(there, effort)

    k1 = rate(u0, state.v)
    k2 = rate(u0 + 0.5 * h * k1[0], state.v + 0.5 * h * k1[1])
    k3 = rate(u0 + 0.5 * h * k2[0], state.v + 0.5 * h * k2[1])
    k4 = rate(u0 + h * k3[0], state.v + h * k3[1])
    u, v = (
        start + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
        for start, a, b, c, d in zip((u0, state.v), k1, k2, k3, k4, strict=True)
    )
    return plant.settled(plant.moved(state, u, v))[0]


def fall(one: Robot, plant: Any) -> np.ndarray:
    """Actuated coordinates over time without efforts from a moving start."""
    chain, at = one.chain, one.postures[0]
    units = np.array([chain.length if a.kind == "translation" else 1.0 for a in chain.actuators])
    v = units * np.random.default_rng(4).normal(size=chain.n)
    reference = Reference(Hold(chain.tool(at).position), chain, 0.1)
    start: dict[str, Any] = {"start": at, "start_velocity": v, "integrator": Adaptive(1e-10, 1e-12)}
    return np.asarray(run(plant, NoControl(), reference, duration=0.1, every=0.02, **start).q)


WITH_TOOL = [name for name in PLANS if "without" not in name]


@pytest.mark.parametrize("name", ["delta, rods on the arms", "ankle"])
def test_round_rods_move_in_actuated_coordinates_as_in_full_ones(name: str) -> None:
    one = robot(name)
    reduced, full = fall(one, ReducedPlant(one.chain)), fall(one, ConstrainedPlant(one.chain))
    assert np.abs(full - full[0]).max() > 0.02
    np.testing.assert_allclose(reduced, full, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("name", PLANS)
def test_round_rods_are_cyclic_and_bent_ones_are_not(name: str) -> None:
    assert robot(name).chain.idle_is_cyclic
    for out_of_round in (1e-4, 0.45):
        bent = robot(name, out_of_round)
        assert not bent.chain.idle_is_cyclic
        with pytest.raises(ActuationError, match="full coordinates") as caught:
            ReducedPlant(bent.chain)
        assert set(caught.value.free) == set(bent.chain.mobility().idle)


def test_a_bent_rod_would_move_otherwise_in_actuated_coordinates(monkeypatch: pytest.MonkeyPatch) -> None:
    """So the refusal is no mere caution."""
    bent = robot("delta, rods on the arms", 0.45)
    full = fall(bent, ConstrainedPlant(bent.chain))
    monkeypatch.setitem(vars(bent.chain), "idle_is_cyclic", True)
    assert np.abs(fall(bent, ReducedPlant(bent.chain)) - full).max() > 1e-6


@pytest.mark.parametrize("name", WITH_TOOL)
def test_reaching_for_the_tool_comes_back(name: str) -> None:
    """By pose; a point alone leaves the turning free on those that can turn."""
    one, rng = robot(name), np.random.default_rng(5)
    for at in one.postures:
        target = one.chain.tool(at).pose
        found = one.chain.reach(target, one.chain.home)
        np.testing.assert_allclose(one.chain.tool(found).pose.matrix, target.matrix, rtol=0.0, atol=1e-11)
        beside = one.chain.reach(target.position, one.chain.home, free=True)
        np.testing.assert_allclose(one.chain.tool(beside).position, target.position, rtol=0.0, atol=1e-11)
        if not one.chain.task.is_of_point:
            with pytest.raises(InputError, match="a point does not fix"):
                one.chain.reach(target.position, one.chain.home)
        require(actuated(one.chain, one.oracle, found, rng), 1e-9, name)
