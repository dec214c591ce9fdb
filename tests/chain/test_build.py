"""The open tree as Pinocchio's own reader and yourdfpy understand it, and joints that no URDF has."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
import yourdfpy
from kit.shipped import SHIPPED

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.build import build_model
from cutjoint.chain.joints import coordinates_to_q
from cutjoint.description import catalogue, load_description
from cutjoint.description.model import Home, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.errors import CutjointError, DynamicsError

EXAMPLES = ("ur5", "panda") if catalogue.example_names() else ()


def urdf_of(name: str) -> Path:
    path = catalogue.resolve(name)
    return path if path.suffix == ".urdf" else path.parent / "robot.urdf"


class Pair:
    """Our model and Pinocchio's of one URDF, with the same coordinates in both."""

    def __init__(self, name: str) -> None:
        self.ours = build_model(load_description(name))
        self.theirs = pin.buildModelFromUrdf(str(urdf_of(name)))
        self.theirs.gravity = self.ours.gravity
        self.data, self.other = self.ours.createData(), self.theirs.createData()
        names = list(self.ours.names)[1:]
        assert sorted(names) == sorted(list(self.theirs.names)[1:])
        ids = [self.theirs.getJointId(joint) for joint in names]
        self.order = np.concatenate([np.arange(self.theirs.nvs[i]) + self.theirs.idx_vs[i] for i in ids])

    def configuration(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """The same random configuration in both layouts: a continuous joint is an angle here, cosine and sine there."""
        q, other = pin.neutral(self.ours), pin.neutral(self.theirs)
        for index in range(1, self.ours.njoints):
            theirs = self.theirs.joints[self.theirs.getJointId(self.ours.names[index])]
            start, count = self.ours.idx_qs[index], self.ours.nqs[index]
            if count == 1:
                q[start] = angle = rng.uniform(-2.5, 2.5)
                other[theirs.idx_q : theirs.idx_q + theirs.nq] = (
                    [angle] if theirs.nq == 1 else np.array([np.cos(angle), np.sin(angle)])
                )
            else:
                assert count == 7
                pose = np.r_[rng.normal(size=3), pin.Quaternion(pin.exp3(rng.normal(size=3))).coeffs()]
                q[start : start + 7] = other[theirs.idx_q : theirs.idx_q + 7] = pose
        return q, other

    def velocity(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        v, other = rng.normal(size=self.ours.nv), np.empty(self.ours.nv)
        other[self.order] = v
        return v, other


@pytest.mark.parametrize("name", [*SHIPPED, *EXAMPLES])
def test_dynamics_are_those_of_pinocchios_reader(name: str) -> None:
    pair, rng = Pair(name), np.random.default_rng(1)
    pick = np.ix_(pair.order, pair.order)
    for _ in range(5):
        q, q_other = pair.configuration(rng)
        v, v_other = pair.velocity(rng)
        a, a_other = pair.velocity(rng)
        upper = np.triu(pin.crba(pair.ours, pair.data, q))
        upper_other = np.triu(pin.crba(pair.theirs, pair.other, q_other))
        mass, mass_other = (m + np.triu(m, 1).T for m in (upper, upper_other))
        size = np.abs(mass).max()
        np.testing.assert_allclose(mass, mass_other[pick], atol=1e-13 * size, rtol=0)
        effort = pin.rnea(pair.ours, pair.data, q, v, a)
        effort_other = pin.rnea(pair.theirs, pair.other, q_other, v_other, a_other)
        np.testing.assert_allclose(effort, effort_other[pair.order], atol=1e-12 * np.abs(effort).max(), rtol=0)
        pin.framesForwardKinematics(pair.ours, pair.data, q)
        pin.framesForwardKinematics(pair.theirs, pair.other, q_other)
        for link in load_description(name).links:
            ours = pair.data.oMf[pair.ours.getFrameId(link.name, pin.FrameType.BODY)]
            theirs = pair.other.oMf[pair.theirs.getFrameId(link.name, pin.FrameType.BODY)]
            np.testing.assert_allclose(ours.homogeneous, theirs.homogeneous, atol=1e-12, err_msg=link.name)


@pytest.mark.parametrize("name", ["omega3", "cpm", *EXAMPLES])
def test_links_are_where_yourdfpy_has_them(name: str) -> None:
    chain = ClosedChain(load_description(name))
    other = yourdfpy.URDF.load(str(urdf_of(name)), load_meshes=False, build_scene_graph=True)
    rng = np.random.default_rng(2)
    for _ in range(5):
        q = np.array(pin.neutral(chain.model))
        values = {name: rng.uniform(-2, 2) for name in chain.model.names if name in other.actuated_joint_names}
        values.pop("platform", None)  # a floating joint, which yourdfpy leaves where it is
        for coupling in chain.description.couplings:
            values[coupling.joint] = coupling.gear[1] * values[coupling.gear[0]] + coupling.offset
        for joint, value in values.items():
            q[chain.model.idx_qs[chain.model.getJointId(joint)]] = value
        other.update_cfg({joint: values[joint] for joint in other.actuated_joint_names if joint in values})
        for link, found in chain.link_placements(q).items():
            wanted = other.get_transform(link, chain.description.root)
            np.testing.assert_allclose(found, wanted, atol=1e-12, err_msg=link)


@pytest.mark.skipif(not EXAMPLES, reason="example-robot-data is not installed")
def test_mimic_fingers_are_coupled() -> None:
    chain = ClosedChain(load_description("panda"))
    report = chain.mobility()
    assert (report.velocities, report.rows, report.rank, report.mobility) == (9, 1, 1, 8)
    q = np.array(chain.home.q_full)
    q[-2:] = 0.03, 0.01
    closed = chain.assemble(q, keep_actuators=False)
    assert closed.q_full[-1] == pytest.approx(closed.q_full[-2], abs=1e-12)
    assert max(closed.gap) < 1e-12


def forest(rng: np.random.Generator, kit: Any, links: int = 14) -> RobotDescription:
    """A branching tree with fixed joints in between, its joints in random order."""
    kinds = [JointType.REVOLUTE, JointType.FIXED, JointType.PRISMATIC, JointType.CONTINUOUS, JointType.FIXED]
    joints = []
    for index in range(1, links):
        axis = rng.normal(size=3)
        joints.append(
            Joint(
                f"j{index}",
                kinds[index % len(kinds)],
                f"l{rng.integers(0, index)}",
                f"l{index}",
                placement(rng.normal(size=3), rng.uniform(-2, 2, 3)),
                axis=readonly(axis / np.linalg.norm(axis)),
            )
        )
    rng.shuffle(joints)
    names = [f"l{index}" for index in range(links)]
    bodies = tuple(Link(name, kit.body(1.0 + 0.1 * k, seed=k)) for k, name in enumerate(names))
    return RobotDescription("forest", bodies, tuple(joints))


@pytest.mark.parametrize("seed", range(5))
def test_any_order_of_joints_gives_the_same_tree(seed: int, kit: Any) -> None:
    """Pinocchio's crba is silently wrong if joints are not added depth first, its rnea never is."""
    rng = np.random.default_rng(seed)
    description = forest(rng, kit)
    model = build_model(description)
    data = model.createData()
    assert model.check(data)
    q = rng.uniform(-2, 2, model.nq)
    zero = np.zeros(model.nv)
    mass = np.triu(pin.crba(model, data, q))
    mass = mass + np.triu(mass, 1).T
    weight = pin.rnea(model, data, q, zero, zero)
    for k, unit in enumerate(np.eye(model.nv)):
        column = pin.rnea(model, data, q, zero, unit) - weight
        np.testing.assert_allclose(mass[:, k], column, atol=1e-11)
    values = dict(zip(list(model.names)[1:], q, strict=True))
    place = {"l0": np.eye(4)}
    left = list(description.joints)
    while left:
        joint = next(one for one in left if one.parent in place)
        left.remove(joint)
        motion = np.eye(4)
        if joint.type is JointType.PRISMATIC:
            motion[:3, 3] = values[joint.name] * joint.axis
        elif joint.type is not JointType.FIXED:
            motion[:3, :3] = pin.exp3(values[joint.name] * joint.axis)
        place[joint.child] = place[joint.parent] @ joint.placement @ motion
    found = ClosedChain(description).link_placements(q)
    assert found.keys() == place.keys()
    for name, wanted in place.items():
        np.testing.assert_allclose(found[name], wanted, atol=1e-12, err_msg=name)


def single(kind: JointType, kit: Any, **extra: Any) -> RobotDescription:
    joint = Joint("j", kind, "base", "b", placement((0.1, 0.2, 0.3), (0.3, -0.4, 0.5)), **extra)
    return RobotDescription("single", (Link("base"), Link("b", kit.body())), (joint,))


def unit(vector: Any) -> np.ndarray:
    return readonly(np.array(vector) / np.linalg.norm(vector))


def test_joints_beyond_urdf_move_as_documented(kit: Any) -> None:
    rng = np.random.default_rng(3)
    axis, axis2 = unit([1.0, 2.0, -0.5]), unit([0.2, -1.0, 0.7])
    normal = unit([0.3, -0.8, 0.5])
    start = placement((0.1, 0.2, 0.3), (0.3, -0.4, 0.5))
    for _ in range(5):
        x, y, z, w = rng.uniform(-1.5, 1.5, 4)
        turn = np.eye(4)

        turn[:3, :3] = pin.exp3(x * axis) @ pin.exp3(y * axis2)
        check(single(JointType.UNIVERSAL, kit, axis=axis, axis2=axis2), (x, y), start @ turn)

        turn[:3, :3] = pin.rpy.rpyToMatrix(x, y, z)
        check(single(JointType.SPHERICAL, kit), (x, y, z), start @ turn)

        turn[:3, 3] = z, w, x
        turn[:3, :3] = pin.rpy.rpyToMatrix(x, y, w)
        check(single(JointType.FLOATING, kit), (z, w, x, x, y, w), start @ turn)

        chain = ClosedChain(single(JointType.PLANAR, kit, axis=normal))
        q = coordinates_to_q(chain.description.joints[0], (x, y, z))
        found = np.linalg.inv(start) @ chain.link_placements(q)["b"]
        assert normal @ found[:3, 3] == pytest.approx(0.0, abs=1e-12), "it stays in its plane"
        assert np.linalg.norm(found[:3, 3]) == pytest.approx(np.hypot(x, y))
        np.testing.assert_allclose(found[:3, :3], pin.exp3(z * normal), atol=1e-12)


def check(description: RobotDescription, values: tuple[float, ...], wanted: np.ndarray) -> None:
    """The body is where it should be, by the home posture too."""
    home = Home("there", {}, {"j": values})
    chain = ClosedChain(replace(description, homes=(home,)))
    np.testing.assert_allclose(chain.link_placements(chain.home)["b"], wanted, atol=1e-12)


def test_planar_zero_is_the_placement_itself(kit: Any) -> None:
    chain = ClosedChain(single(JointType.PLANAR, kit, axis=unit([0.0, 1.0, 1.0])))
    wanted = placement((0.1, 0.2, 0.3), (0.3, -0.4, 0.5))
    np.testing.assert_allclose(chain.link_placements(chain.home)["b"], wanted, atol=1e-15)


def snake(count: int, kit: Any) -> RobotDescription:
    axis = readonly([0.0, 0.0, 1.0])
    links = (Link("l0"), *(Link(f"l{k}", kit.body(0.1)) for k in range(1, count + 1)))
    joints = tuple(
        Joint(f"j{k}", JointType.REVOLUTE, f"l{k}", f"l{k + 1}", placement((0.01, 0, 0)), axis=axis)
        for k in range(count)
    )
    return RobotDescription("snake", links, joints)


def test_a_long_chain_builds(kit: Any) -> None:
    chain = ClosedChain(snake(100, kit))
    assert chain.link_placements(chain.home)["l100"][0, 3] == pytest.approx(0.01 * 100)


def test_a_chain_that_is_too_long_is_refused_in_words(kit: Any) -> None:
    with pytest.raises(CutjointError, match="3000 moving joints"):
        ClosedChain(snake(3000, kit))


def test_unknown_limits_are_not_zero() -> None:
    chain = ClosedChain(load_description("fourbar"))
    description = chain.description
    joints = tuple(replace(joint, limits=type(joint.limits)()) for joint in description.joints)
    free = ClosedChain(replace(description, joints=joints))
    assert not free.limit_violations(free.close(free.home.q + 50.0))


def test_a_massless_end_is_an_error_and_not_a_nan(kit: Any) -> None:
    axis = readonly([0.0, 0.0, 1.0])
    links = (Link("base"), Link("a", kit.body()), Link("b"))
    joints = (
        Joint("j1", JointType.REVOLUTE, "base", "a", axis=axis),
        Joint("j2", JointType.REVOLUTE, "a", "b", placement((0.3, 0, 0)), axis=axis),
    )
    chain = ClosedChain(RobotDescription("massless", links, joints, actuators=("j1", "j2")))
    with pytest.raises(DynamicsError, match="no mass"):
        chain.forward_dynamics(chain.home, [0.0, 0.0], [1.0, 0.0])
