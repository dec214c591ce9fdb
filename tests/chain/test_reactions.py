"""Reactions by laws that need no other model: every link in balance, power in every joint, where a loop is cut, what is
unique in planar robots, and how joints that give share a load."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.blueprint import Blueprint, random_mounting, random_rotation
from kit.built import built, built_with_physics
from kit.by_joint import by_joint
from kit.mechanisms import MECHANISMS, on_circle
from kit.quickly import few
from kit.shipped import DETERMINED
from kit.writing import rpy_of
from oracles.physics import Bush, smooth_sign
from oracles.placed import Placed

import cutjoint
from cutjoint.chain import ClosedChain, Reaction, Reactions
from cutjoint.description import load_description
from cutjoint.description.model import Bushing
from cutjoint.errors import DynamicsError, InputError, RoundingWarning, UnknownNameError
from cutjoint.mechanism import Load

Array = np.ndarray


def on_links(chain: ClosedChain, at: Any, found: Reactions) -> dict[str, Array]:
    """Force and moment about the world's origin that joints and cuts together do to every link, shape (6,)."""
    description = chain.description
    sums = {link.name: np.zeros(6) for link in description.links}
    joints = [(found.joints[one.name], one.parent, one.child) for one in description.joints]
    cuts = [(found.cuts[one.name], one.a.link, one.b.link) for one in description.cuts]
    for one, parent, child in (*joints, *cuts):
        moved = one.at(np.zeros(3))
        sums[child] += moved.wrench
        sums[parent] -= moved.wrench
    return sums


def closed_near(chain: ClosedChain, rng: np.random.Generator) -> Any:
    return chain.close(chain.home.q + 0.05 * chain.length * rng.uniform(-1.0, 1.0, chain.n), limits="ignore")


@pytest.mark.parametrize("name", few((*DETERMINED, "redundant"), "fourbar", "cpm", "stewart", "redundant"))
def test_every_link_rests_in_balance(name: str) -> None:
    """Its weight, and nothing else, is what joints and cuts carry; the loads where there are some."""
    chain, rng = cutjoint.load(name), np.random.default_rng(1)
    tool = chain.description.tool
    load = Load(force=rng.normal(size=3), moment=rng.normal(size=3), link=tool.link, point=rng.normal(size=3))
    for loads in ((), (load,)):
        at = chain.home if name == "redundant" else closed_near(chain, rng)
        found = chain.full_reactions(at, loads=loads)
        placements, sums = chain.link_placements(at), on_links(chain, at, found)
        largest = max(float(np.abs(one.force).max()) for one in found) * max(chain.length, 1.0)
        for link in chain.description.links:
            if link.name == chain.description.root:
                continue
            wanted = np.zeros(6)
            if link.inertial is not None:
                force = -link.inertial.mass * chain.description.gravity
                centre = placements[link.name] @ np.append(link.inertial.com, 1.0)
                wanted += np.r_[force, np.cross(centre[:3], force)]
            if loads and link.name == load.link:
                point = (placements[link.name] @ np.append(load.point, 1.0))[:3]
                wanted -= np.r_[load.force, load.moment + np.cross(point, load.force)]
            np.testing.assert_allclose(sums[link.name], wanted, rtol=0, atol=1e-11 * largest)


REGULAR = [name for name in MECHANISMS if name not in ("upu_3_equal", "parallelogram_flat")]
"""Those at whose home every velocity that the loops allow goes on."""


@pytest.mark.parametrize("name", few(REGULAR, "geared_fivebar", "ups_6", "prs_3"))
def test_power_in_every_joint(name: str, tmp_path: Path) -> None:
    """Along what a joint leaves free acts what is known: effort, gears, springs, damping, friction, and the rotor."""
    rng = np.random.default_rng(4)
    chain, _ = built_with_physics(MECHANISMS[name](rng).plan, tmp_path, rng, random_mounting(rng))
    k, at = chain._k, chain.home
    basis = np.linalg.svd(k.at(at.q_full).scaled)[2]
    effort = 10.0 * rng.normal(size=chain.nv)
    allowed = basis[chain.nv - chain.mobility().mobility :].T
    v = 3.0 * k.column_scale * (allowed @ rng.normal(size=allowed.shape[1]))
    motion = chain.full_forward_dynamics(at, v, effort)
    found = chain.full_reactions(at, v, motion.acceleration, effort)
    placed = k.moving(at.q_full, v)
    drawn = by_joint(chain, v), by_joint(chain, motion.acceleration), by_joint(chain, effort)
    for joint in chain.description.joints:
        if not joint.type.moves:
            continue
        one, index = found[joint.name].at(chain.origin), chain.model.getJointId(joint.name)
        rates = slice(chain.model.idx_vs[index], chain.model.idx_vs[index] + chain.model.nvs[index])
        along = placed.twists[:, rates].T @ one.wrench
        speed, change, given = (of[joint.name] for of in drawn)
        wanted = given - joint.physics.armature * change
        for gear in chain.description.couplings:
            share = {gear.joint: 1.0, gear.gear[0]: -gear.gear[1]}.get(joint.name, 0.0)
            wanted = wanted + share * found.couplings[gear.name].force
        if joint.type.single:
            physics, q = joint.physics, at.q_full[chain.model.idx_qs[index]]
            wanted = wanted - physics.damping * speed - physics.stiffness * (q - physics.rest)
            wanted = wanted - physics.friction * smooth_sign(float(speed[0]), physics.speed)
            np.testing.assert_allclose(along, wanted, rtol=0, atol=1e-9 * (1.0 + np.abs(one.wrench).max()))


RING = {"a": ("base", "crank"), "b": ("crank", "coupler"), "c": ("rocker", "coupler"), "d": ("base", "rocker")}


def ring(seed: int, cut: str, folder: Path) -> ClosedChain:
    """A four-bar in space, its plane anywhere, cut at any of its four hinges; its bodies are the same ones."""
    rng = np.random.default_rng(seed)
    tilt, bodies = random_rotation(rng), {}
    points = dict(zip("abcd", ([0.0, 0, 0], [0.1, 0.2, 0], [0.45, 0.3, 0], [0.5, 0, 0]), strict=True))
    for link in ("crank", "coupler", "rocker"):
        bodies[link] = Blueprint("", rng).random_inertia(), random_rotation(rng), rng.normal(size=3) * 0.2
    plan = Blueprint(f"ring_{cut}", np.random.default_rng(seed))
    reached, left = {"base"}, [name for name in RING if name != cut]
    while left:
        name = next(one for one in left if reached & set(RING[one]))
        parent, child = sorted(RING[name], key=lambda link: link not in reached)
        plan.joint(name, "continuous", parent, child, tilt @ points[name], tilt[:, 2])
        reached.add(child)
        left.remove(name)
    for link, (inertia, axes, centre) in bodies.items():
        pose = plan.poses[link]
        plan.inertias[link] = replace(
            inertia, position=pose.rotation.T @ (centre - pose.position), rpy=rpy_of(pose.rotation.T @ axes)
        )
    plan.cut(cut, "revolute", *RING[cut], tilt @ points[cut], tilt[:, 2])
    plan.actuators = [next(joint.name for joint in plan.joints)]
    return ClosedChain(load_description(plan.write(folder)))


@pytest.mark.parametrize("seed", range(3))
def test_it_does_not_matter_where_the_loop_is_cut(seed: int, tmp_path: Path) -> None:
    """At rest, held by one motor at hinge a or d; the least reactions and those by stiffnesses too."""
    rng, known = np.random.default_rng(seed), {}
    stiffness = {name: rng.uniform(1e5, 1e6) for name in RING}
    for cut in RING:
        chain = ring(seed, cut, tmp_path / cut)
        for given in (None, stiffness):
            effort = np.zeros(chain.nv)
            motor = chain.description.actuators[0]
            found = chain.full_reactions(chain.home, effort_full=None, stiffness=given)
            assert found.redundancy == 3, effort
            key = motor, given is None
            for name, (parent, _) in RING.items():
                one = found[name]
                joints = {joint.name: joint.parent for joint in chain.description.joints}
                forwards = joints.get(name, parent) == parent
                wrench = one.wrench if forwards else -one.wrench
                np.testing.assert_allclose(wrench, known.setdefault((*key, name), wrench), rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", ["planar_3rrr", "geared_fivebar", "parallelogram", "scotch_yoke"])
def test_in_plane_reactions_of_planar_robots_are_unique(name: str, tmp_path: Path) -> None:
    """Forces in the plane and moments across it; the others are shared by redundant loops."""
    rng = np.random.default_rng(2)
    plan = MECHANISMS[name](rng).plan
    chain, _ = built(plan, tmp_path, random_mounting(rng))
    first = next(joint for joint in chain.description.joints if joint.type.turns)
    normal = chain.link_placements(chain.home)[first.child][:3, :3] @ first.axis
    axes = np.column_stack([*np.linalg.svd(normal[None, :])[2][1:], normal])
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    found = chain.reactions(chain.home, np.ones(chain.n))
    names = [joint.name for joint in chain.description.joints if joint.type.moves]
    marked = np.array([found.joints[name].in_axes(axes).unique for name in names])
    assert marked[:, [0, 1, 5]].all()
    assert not marked[:, [2, 3, 4]].any()
    assert found.redundancy == found.undecided > 0
    # along axes that are not those of the plane everything is mixed
    assert not np.array([found.joints[name].in_axes(axes @ random_rotation(rng)).unique for name in names]).any()


def test_a_point_and_axes_of_anyones_choice() -> None:
    """Power along any twist is the same wherever a reaction is told; there and back is where it was."""
    rng = np.random.default_rng(7)
    chain = cutjoint.load("cpm")
    for one in chain.reactions(chain.home, np.ones(3), np.ones(3)):
        point, turned = rng.normal(size=3), random_rotation(rng)
        moved = one.at(point).in_axes(turned)
        w, u = rng.normal(size=(2, 3))
        wanted = one.force @ (u + np.cross(w, one.point)) + one.moment @ w
        given = (turned @ moved.force) @ (u + np.cross(w, point)) + (turned @ moved.moment) @ w
        assert given == pytest.approx(wanted, abs=1e-12 * (1.0 + np.abs(one.wrench).max()))
        back = moved.in_axes(np.eye(3)).at(one.point)
        np.testing.assert_allclose(back.wrench, one.wrench, rtol=0, atol=1e-12 * (1.0 + np.abs(one.wrench).max()))
        assert back.unique == one.unique
        swapped = one.in_axes(np.eye(3)[:, [1, 2, 0]])
        assert swapped.unique == tuple(one.unique[i] for i in (1, 2, 0, 4, 5, 3))


def stool(rng: np.random.Generator, legs: int, kinds: list[str]) -> Blueprint:
    """A plate that lies on so many supports, told as a body that could fly but for its cuts."""
    plan = Blueprint("stool", rng)
    plan.joint("flight", "floating", "base", "plate", 0.2 * rng.normal(size=3))
    for index, kind in enumerate(kinds[:legs]):
        at, axis = (
            on_circle(0.4, 2.0 * np.pi * index / legs + 0.1 * rng.normal(), 0.1 * rng.normal()),
            rng.normal(size=3),
        )
        plan.cut(f"leg{index}", kind, "base", "plate", at, axis, rng.normal(size=3))
    plan.actuators = []
    return plan


def rubber_forces(oracle: Any, at: dict[str, Any], legs: dict[str, Array], hardness: float) -> dict[str, Array]:
    """What supports of finite stiffness carry where the plate comes to rest on them, by Newton's method."""
    from oracles.maximal import Maximal

    bushes = {name: Bush(hardness * k[0], 0.0, hardness * k[1], 0.0) for name, k in legs.items()}
    soft = Maximal(oracle.path, length=oracle.length, bushings=bushes)
    moved = at["flight"].copy()

    def pull(step: Array) -> Array:
        placed = Placed(soft, {"flight": _stepped(moved, step)})
        return placed.tree.T @ placed.moving({}).load

    for _ in range(8):
        h, size = 1e-7, pull(np.zeros(6))
        slope = np.column_stack([(pull(h * e) - pull(-h * e)) / (2 * h) for e in np.eye(6)])
        moved = _stepped(moved, -np.linalg.solve(slope, size))
    placed = Placed(soft, {"flight": moved})
    assert np.abs(pull(np.zeros(6))).max() < 1e-6
    return {name: placed.cushions[name].own.T @ placed.cushions[name].forces(np.zeros(soft.size)) for name in legs}


def _stepped(pose: Array, step: Array) -> Array:
    from oracles.connections import turn

    moved, angle = pose.copy(), float(np.linalg.norm(step[3:]))
    moved[:3, 3] += pose[:3, :3] @ step[:3]
    if angle:
        moved[:3, :3] = pose[:3, :3] @ turn(step[3:] / angle, angle)
    return moved


@pytest.mark.parametrize("seed", few(range(12), 0, 1, 2))
def test_stated_stiffnesses_are_the_limit_of_rubber(seed: int, tmp_path: Path) -> None:
    """A plate on supports of every kind, each with its own stiffness: against supports that do give, ever harder."""
    from kit.built import at_home

    rng = np.random.default_rng(seed)
    kinds = [str(kind) for kind in rng.choice(["fixed", "revolute", "spherical", "universal", "prismatic"], 4)]
    plan = stool(rng, int(rng.integers(3, 5)), kinds)
    chain, oracle = built(plan, tmp_path)
    oracle.path = tmp_path
    legs = {cut.name: rng.uniform(0.3, 1.0, 2) * (1.0, 0.05) for cut in plan.cuts}
    if chain.mobility().mobility:
        pytest.skip("it is no structure")
    stiffness = {name: np.repeat(k, 3) for name, k in legs.items()}
    found = chain.full_reactions(chain.home, effort_full=np.zeros(6), stiffness=stiffness)
    assert found.redundancy > 0
    assert found.undecided == 0
    at, apart = at_home(plan, oracle), []
    for hardness in (1e5, 1e6):
        soft = rubber_forces(oracle, at, legs, hardness)
        apart.append(max(float(np.abs(found.cuts[name].wrench - soft[name]).max()) for name in legs))
    largest = max(float(np.abs(one.wrench).max()) for one in found.cuts.values())
    assert apart[1] < 1e-3 * largest
    assert apart[1] < 0.15 * apart[0] or apart[1] < 1e-7 * largest, "the error falls as the compliance does"


def test_four_legs_alike_carry_alike(tmp_path: Path) -> None:
    """The textbook's table: least, and with equal legs, a quarter each; soft legs carry less, by the lever."""
    plan = Blueprint("table", np.random.default_rng(0))
    plan.joint("flight", "floating", "base", "plate", np.zeros(3), start=[0.0] * 6)
    for index in range(4):
        plan.cut(f"leg{index}", "spherical", "base", "plate", on_circle(0.5, 0.25 * np.pi + 0.5 * np.pi * index))
    chain, _ = built(plan, tmp_path)
    inertial = replace(chain.description.link("plate").inertial, mass=4.0, com=np.zeros(3))
    centre = np.linalg.inv(chain.link_placements(chain.home)["plate"])[:3, 3]
    chain = ClosedChain(chain.description.with_inertial("plate", replace(inertial, com=centre)))
    names = [f"leg{index}" for index in range(4)]
    found = chain.full_reactions(chain.home, effort_full=np.zeros(6))
    np.testing.assert_allclose([found[name].force[2] for name in names], 9.81, rtol=1e-12)
    # the sum and both tilts hold: what one diagonal carries more, each of its legs does
    stiff = {name: 1e6 if index % 2 else 1e5 for index, name in enumerate(names)}
    shared = chain.full_reactions(chain.home, effort_full=np.zeros(6), stiffness=stiff)
    forces = [shared[name].force[2] for name in names]
    np.testing.assert_allclose(forces, [2 * 9.81 / 11, 20 * 9.81 / 11] * 2, rtol=1e-9)
    assert (found.redundancy, found.undecided, shared.undecided) == (6, 6, 0)


def test_marks_follow_the_point(tmp_path: Path) -> None:
    """A ball holds no moment at its centre, which is unique; about another point its forces have one, which is not."""
    plan = stool(np.random.default_rng(1), 4, ["spherical"] * 4)
    chain, _ = built(plan, tmp_path)
    found = chain.full_reactions(chain.home, effort_full=np.zeros(6))
    for one in found.cuts.values():
        assert one.unique[3:] == (True, True, True)
        assert not any(one.unique[:3])
        for axis in np.eye(3):
            across = one.at(one.point + 0.1 * axis)
            assert across.unique[3:] == tuple(axis == 1.0), "nothing turns about the arm"
            assert across.at(one.point).unique == one.unique


def test_rounded_lengths_keep_their_marks() -> None:
    """Rows that are left out for their rounding hold what nobody knows: across the plane nothing is unique."""
    exact = cutjoint.load("fourbar")
    place = np.array(exact.description.cuts[0].a.placement)
    place[:3, 3] += [1e-6, 2e-6, 3e-6]
    cut = replace(exact.description.cuts[0], a=replace(exact.description.cuts[0].a, placement=place))
    with pytest.warns(RoundingWarning):
        chain = ClosedChain(replace(exact.description, cuts=(cut,)))
    assert chain._k.closure.left_out
    right, found = exact.reactions(exact.home, [1.0], [2.0]), chain.reactions(chain.home, [1.0], [2.0])
    for name in ("crank", "coupler", "rocker", "coupler_to_rocker"):
        assert found[name].unique == right[name].unique
        own = np.array(right[name].unique)
        np.testing.assert_allclose(found[name].wrench[own], right[name].wrench[own], rtol=0, atol=1e-3)


def test_motion_and_effort_in_any_order() -> None:
    """Acceleration, effort or both; actuated or full coordinates: the same reactions."""
    chain = cutjoint.load("fivebar")
    v, a = [1.0, -2.0], [3.0, 4.0]
    effort = chain.inverse_dynamics(chain.home, v, a)
    full = chain.full_velocity(chain.home, v), chain.tangent(chain.home) @ a + chain.drift(chain.home, v)
    ways = [
        chain.reactions(chain.home, v, a),
        chain.reactions(chain.home, v, effort=effort),
        chain.reactions(chain.home, v, a, effort),
        chain.full_reactions(chain.home, *full),
        chain.full_reactions(chain.home, full[0], effort_full=chain.full_effort(effort)),
    ]
    for found in ways[1:]:
        for one, wanted in zip(found, ways[0], strict=True):
            np.testing.assert_allclose(one.wrench, wanted.wrench, rtol=0, atol=1e-9)
    rest = chain.reactions(chain.home)
    np.testing.assert_allclose(rest.effort, chain.full_effort(chain.terms(chain.home).gravity), atol=1e-12)


def test_more_actuators_than_freedoms() -> None:
    """Preload is told by the effort that is given; the least one without."""
    chain = cutjoint.load("redundant")
    least = chain.full_inverse_dynamics(chain.home, np.zeros(chain.nv), np.zeros(chain.nv))
    pressed = chain.full_effort(least.effort + 3.0 * least.preload[:, 0])
    found = chain.full_reactions(chain.home, a_full=np.zeros(chain.nv), effort_full=pressed)
    moments = [found[name].in_axes(found[name].own_axes).moment[2] for name in chain.description.actuators]
    np.testing.assert_allclose(moments, pressed[pressed != 0.0], rtol=1e-10)
    np.testing.assert_allclose(chain.led_velocity(chain.home, np.zeros(3)), 0.0, atol=1e-15)
    with pytest.raises(InputError, match="do not let its actuators move so"):
        chain.led_velocity(chain.home, least.preload[:, 0])


def test_what_is_wrong_is_said() -> None:
    chain = cutjoint.load("fourbar")
    with pytest.raises(DynamicsError, match="stays unbalanced"):
        chain.reactions(chain.home, [1.0], [2.0], [300.0])
    v = chain.full_velocity(chain.home, [2.0])
    for motion, told in (((v * [1.0, 1.1, 1.0],), "velocity"), ((v, np.zeros(3)), "acceleration")):
        with pytest.raises(InputError, match=f"this {told} of all joints opens the loops"):
            chain.full_reactions(chain.home, *motion, effort_full=np.zeros(3) if told == "velocity" else None)
    for stiffness, told in (
        ({"crank": -1.0}, "'crank' must be one number or six > 0"),
        ({"crank": [1.0, 2.0]}, "must be one number or six"),
        ({"crank": [1.0] * 5 + [np.nan]}, "must be one number or six"),
        ({"crank": "stiff"}, "must be a dict of numbers"),
    ):
        with pytest.raises(InputError, match=told):
            chain.reactions(chain.home, stiffness=stiffness)
    with pytest.raises(UnknownNameError, match="did you mean 'crank'"):
        chain.reactions(chain.home, stiffness={"cranck": 1.0})
    found = chain.reactions(chain.home)
    with pytest.raises(UnknownNameError, match="did you mean 'rocker'"):
        found["roker"]
    with pytest.raises(UnknownNameError, match="unknown link"):
        chain.reactions(chain.home, loads=Load(link="nowhere"))
    with pytest.raises(InputError, match="columns of a rotation"):
        found["crank"].in_axes(2.0 * np.eye(3))
    with pytest.raises(InputError, match="point"):
        found["crank"].at([1.0, 2.0])
    with pytest.raises(InputError, match="shape"):
        chain.reactions(chain.home, [1.0, 2.0])
    soft = replace(chain.description.cuts[0], bushing=Bushing(1e6))
    rubber = ClosedChain(replace(chain.description, cuts=(soft,)))
    with pytest.raises(InputError, match="is a bushing"):
        rubber.full_reactions(rubber.home, effort_full=np.zeros(3), stiffness={"coupler_to_rocker": 1e6})
    infinite = chain.reactions(chain.home, stiffness={"crank": np.inf})
    assert infinite.undecided == found.undecided == 3
    assert isinstance(found["crank"], Reaction)
    assert "3 times redundant" in repr(found)
