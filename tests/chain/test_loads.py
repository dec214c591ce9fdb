"""Loads from outside: their work is that of the points they act on, weights are loads, and all models agree."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.blueprint import random_mounting
from kit.built import built
from kit.loaded import minimal_of, random_loads
from kit.mechanisms import MECHANISMS
from kit.quickly import few

import cutjoint
from cutjoint import Load
from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import velocity_scale
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.robots import PUBLISHED

QUICK = ("floating_fourbar", "prs_3", "geared_fivebar", "ball_rod_delta")


@pytest.mark.parametrize("name", few(MECHANISMS, *QUICK))
@pytest.mark.parametrize("scale", few([1e-3, 1.0, 1e3], 1.0))
def test_the_power_of_loads_is_that_of_their_points(name: str, scale: float, tmp_path: Path) -> None:
    """Virtual work, by differences of where the links are."""
    rng = np.random.default_rng([31, *name.encode()])
    chain, _ = built(MECHANISMS[name](rng).plan, tmp_path, random_mounting(rng), scale)
    unit = velocity_scale(chain.model, chain.length)
    jacobian = chain.constraint_jacobian(chain.home) * unit
    motions = (
        np.linalg.svd(jacobian)[2][np.linalg.matrix_rank(jacobian, tol=1e-8) :].T if len(jacobian) else np.eye(chain.nv)
    )
    v = unit * (motions @ rng.normal(size=motions.shape[1]))
    loads = [load for load in random_loads(chain, rng, 5.0) if load.link is not None]
    here, step = chain.link_placements(chain.home), 1e-3  # large, for a small robot may be mounted far away
    near = {k: chain.link_placements(chain.integrate(chain.home.q_full, k * step * v)) for k in (-2, -1, 1, 2)}
    power, size = 0.0, 0.0
    for load in loads:
        link = str(load.link)
        one = {k: there[link] for k, there in near.items()}
        axes = np.eye(3) if load.axes == "world" else here[link][:3, :3]
        rate = (8.0 * (one[1] - one[-1]) - (one[2] - one[-2])) / (12.0 * step)
        moved, spin = rate @ np.append(load.point, 1.0), rate[:3, :3] @ here[link][:3, :3].T
        turned = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        parts = (axes @ load.force @ moved[:3], axes @ load.moment @ turned)
        power, size = power + sum(parts), size + sum(map(abs, parts))
    assert chain.full_load_effort(chain.home, loads) @ v == pytest.approx(power, abs=1e-8 * size)


@pytest.mark.parametrize("name", few(MECHANISMS, *QUICK))
def test_weights_are_loads(name: str, tmp_path: Path) -> None:
    """A robot without gravity under the weights of its links is the robot with gravity."""
    rng = np.random.default_rng([32, *name.encode()])
    chain, _ = built(MECHANISMS[name](rng).plan, tmp_path, random_mounting(rng))
    floating = ClosedChain(replace(chain.description, gravity=np.zeros(3)))
    weights = [
        Load(link.inertial.mass * np.array(chain.description.gravity), link=link.name, point=link.inertial.com)
        for link in chain.description.links
        if link.inertial is not None
    ]
    at = floating.posture(chain.home)
    still, effort = np.zeros(chain.nv), rng.normal(size=chain.nv)
    wanted = chain.full_forward_dynamics(chain.home, still, effort).acceleration
    found = floating.full_forward_dynamics(at, still, effort, weights).acceleration
    size = np.abs(wanted).max()
    assert np.abs(found - wanted).max() < 1e-10 * size
    if chain.mobility().determined:
        holding = chain.terms(chain.home).gravity
        assert np.abs(-floating.load_effort(at, weights) - holding).max() < 1e-11 * (1.0 + np.abs(holding).max())


@pytest.mark.parametrize("name", ["cpm", "omega3"])
def test_papers_and_compiled_robots_know_the_tool(name: str) -> None:
    """The published model, the chain and its compiled form give the same under a load at the tool."""
    paper = cutjoint.published(name)
    chain = cutjoint.load(name, PUBLISHED[name].variant)
    rng, at = np.random.default_rng(4), paper.home
    there = chain.reach(paper.tool(at).position)
    assert np.allclose(there.q, at.q, atol=1e-9)
    loads = [Load([1.0, -2.0, 3.0]), Load([0.5, 0.0, 1.0], axes="link")]
    effort, v = rng.normal(size=3), 0.1 * rng.normal(size=3)
    wanted = paper.forward_dynamics(at, v, effort, loads) - paper.forward_dynamics(at, v, effort)
    found = chain.forward_dynamics(there, v, effort, loads) - chain.forward_dynamics(there, v, effort)
    assert np.abs(found - wanted).max() < 1e-8 * np.abs(wanted).max()
    a = paper.forward_dynamics(at, v, effort, loads)
    assert np.abs(paper.inverse_dynamics(at, v, a, loads) - effort).max() < 1e-11 * np.abs(a).max()
    with pytest.raises(InputError, match="acts on link 'platform'"):
        paper.forward_dynamics(at, v, effort, Load(link="platform"))
    pytest.importorskip("llvmlite")
    compiled = cutjoint.compiled(chain)
    link = chain.description.links[-1].name
    for given in (loads, loads[0], [*loads, Load([1.0, 2.0, 3.0], link=link)]):
        for one in ("forward_dynamics", "inverse_dynamics"):
            first, second = (getattr(robot, one)(there, v, effort, given) for robot in (chain, compiled))
            assert np.abs(first - second).max() < 1e-9 * np.abs(first).max()


def test_moving_a_force_along_its_line_changes_nothing_and_aside_adds_a_moment() -> None:
    chain = cutjoint.load("stewart")
    rng = np.random.default_rng(6)
    force, arm = rng.normal(size=3), rng.normal(size=3)
    place = chain.tool(chain.home).rotation
    at_point = chain.load_effort(chain.home, Load(force, point=arm))
    assert np.allclose(at_point, chain.load_effort(chain.home, Load(force, np.cross(place @ arm, force))), atol=1e-12)
    along = chain.load_effort(chain.home, Load(force, point=arm + 0.7 * place.T @ force))
    assert np.allclose(at_point, along, atol=1e-11)
    turned = chain.load_effort(chain.home, Load(place.T @ force, point=arm, axes="link"))
    assert np.allclose(at_point, turned, atol=1e-12)


def test_the_base_takes_what_acts_on_it_and_no_load_is_no_load() -> None:
    chain = cutjoint.load("fivebar")
    assert not chain.load_effort(chain.home, Load([1.0, 2.0, 3.0], link=chain.description.root)).any()
    assert not chain.load_effort(chain.home, []).any()
    v, effort = np.ones(2), np.ones(2)
    none = chain.forward_dynamics(chain.home, v, effort, [])
    assert np.array_equal(none, chain.forward_dynamics(chain.home, v, effort))


def test_efforts_of_redundant_and_underactuated_robots_bear_loads() -> None:
    """What the least efforts are for under a load, forward dynamics gives back."""
    rng = np.random.default_rng(8)
    chain = cutjoint.load("redundant")
    v, a = chain.full_motion(chain.home, [0.1, 0.2, 0.0], [1.0, -1.0, 0.0])
    load = Load([3.0, 1.0, 0.0])
    found = chain.full_inverse_dynamics(chain.home, v, a, load).effort
    given = chain.full_forward_dynamics(chain.home, v, chain.full_effort(found), load).acceleration
    assert np.abs(given - a).max() < 1e-9 * np.abs(a).max()
    minimal = minimal_of(cutjoint.load("underactuated"))
    at, speed = minimal.chain.home, 0.3 * rng.normal(size=2)
    a = minimal.forward_dynamics(at, speed, [2.0], load)
    assert minimal.efforts(at, speed, a, load).effort == pytest.approx([2.0], rel=1e-9)


def test_bad_loads_are_told() -> None:
    chain = cutjoint.load("fivebar")
    with pytest.raises(UnknownNameError, match="did you mean 'left_distal'"):
        chain.load_effort(chain.home, Load([1.0, 0.0, 0.0], link="left_distall"))
    for wrong in (3.0, [1.0, 2.0, 3.0], "tool", None):
        with pytest.raises(InputError, match="loads must be a Load or several"):
            chain.load_effort(chain.home, wrong)
    with pytest.raises(InputError, match=r"force must have shape \(3,\)"):
        Load([1.0, 2.0])
    with pytest.raises(InputError, match="must be finite"):
        Load([1.0, np.nan, 0.0])
    with pytest.raises(InputError, match='"world" or "link"'):
        Load([1.0, 0.0, 0.0], axes="tool")  # type: ignore[arg-type]
    bare = ClosedChain(replace(chain.description, tool=None, task=()))
    with pytest.raises(InputError, match="has no tool frame"):
        bare.load_effort(bare.home, Load([1.0, 0.0, 0.0]))
