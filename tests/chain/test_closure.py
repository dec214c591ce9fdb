"""Every cut type as equations: derivatives, what each leaves free, and that a cut joint moves like the joint itself."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.shipped import SHIPPED
from kit.two_bodies import LENGTH

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import frame_along, placement

KINDS = [kind.value for kind in CutType]
H = 1e-5


def case(name: str, kit: Any) -> ClosedChain:
    """A robot under urdf/, or two free bodies with one cut."""
    return ClosedChain(kit.two_bodies(name)) if name in KINDS else kit.robot(name)


def closed_states(chain: ClosedChain, kit: Any, count: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Closed configurations and velocities that keep them closed."""
    if chain.description.name.startswith("two bodies"):
        rng = np.random.default_rng(1)
        found = []
        for _ in range(count):
            q = pin.integrate(chain.model, np.array(chain.home.q_full), rng.normal(size=chain.nv))
            q = np.array(chain.assemble(q, keep_actuators=False).q_full)
            free = kit.motions(chain, q)
            found.append((q, free @ rng.normal(size=free.shape[1])))
        return found
    return [(np.array(state.at.q_full), state.v_full) for state in kit.random_states(chain, count)]


def residual(chain: ClosedChain, q: np.ndarray) -> np.ndarray:
    return chain._k.at(q).residual


@pytest.mark.parametrize("name", [*KINDS, *SHIPPED])
def test_jacobian_is_the_derivative_of_the_residual(name: str, kit: Any) -> None:
    chain = case(name, kit)
    for q, _ in closed_states(chain, kit, 3):
        assert np.abs(residual(chain, q)).max() < 1e-12
        jacobian = chain.constraint_jacobian(q)
        for k, unit in enumerate(np.eye(chain.nv)):
            ahead, behind = (residual(chain, pin.integrate(chain.model, q, s * H * unit)) for s in (1, -1))
            np.testing.assert_allclose(jacobian[:, k], (ahead - behind) / (2 * H), atol=1e-9)


@pytest.mark.parametrize("name", ["prismatic", "universal", "spherical", "distance"])
def test_jacobian_is_exact_while_the_loop_is_open(name: str, kit: Any) -> None:
    """Rows without a rotation vector or a stretched angle."""
    chain = case(name, kit)
    rows = slice(0, 2) if name == "prismatic" else slice(None)
    rng = np.random.default_rng(2)
    q = pin.integrate(chain.model, np.array(chain.home.q_full), 0.5 * rng.normal(size=chain.nv))
    jacobian = chain.constraint_jacobian(q)
    for k, unit in enumerate(np.eye(chain.nv)):
        ahead, behind = (residual(chain, pin.integrate(chain.model, q, s * H * unit)) for s in (1, -1))
        np.testing.assert_allclose(jacobian[rows, k], ((ahead - behind) / (2 * H))[rows], atol=1e-9)


@pytest.mark.parametrize("name", ["fixed", "revolute", "prismatic"])
def test_gradient_of_the_angles_is_exact_while_the_loop_is_open(name: str, kit: Any) -> None:
    """So that descending from any start leads to a closed posture."""
    chain = case(name, kit)
    rows = slice(2, None) if name == "prismatic" else slice(3, None)
    rng = np.random.default_rng(3)
    for _ in range(5):
        q = pin.integrate(chain.model, np.array(chain.home.q_full), rng.normal(size=chain.nv))
        gradient = chain.constraint_jacobian(q)[rows].T @ residual(chain, q)[rows]
        for k, unit in enumerate(np.eye(chain.nv)):
            ahead, behind = (residual(chain, pin.integrate(chain.model, q, s * H * unit))[rows] for s in (1, -1))
            assert gradient[k] == pytest.approx((ahead @ ahead - behind @ behind) / (4 * H), abs=1e-8)


@pytest.mark.parametrize("name", [*KINDS, *SHIPPED])
def test_drift_is_the_rate_of_the_jacobian_times_v(name: str, kit: Any) -> None:
    chain, largest = case(name, kit), 0.0
    for q, v in closed_states(chain, kit, 4):
        assert np.abs(chain.constraint_jacobian(q) @ v).max() < 1e-9
        ahead, behind = (chain.constraint_jacobian(pin.integrate(chain.model, q, s * H * v)) @ v for s in (1, -1))
        drift = chain._k.moving(q, v).drift
        largest = max(largest, float(np.abs(drift).max()))
        size = max(1.0, float(np.abs(drift).max()))
        np.testing.assert_allclose(drift, (ahead - behind) / (2 * H), atol=1e-8 * size)
    assert largest > 1e-3 or name == "fixed", "a drift that is missing would be seen; two bodies that are one have none"


FREE = {
    "fixed": np.zeros((0, 6)),
    "revolute": np.eye(6)[[5]],
    "prismatic": np.eye(6)[[2]],
    "spherical": np.eye(6)[3:],
}


def on_the_world(kind: str, kit: Any) -> RobotDescription:
    """A free body cut to the world."""
    two = kit.two_bodies(kind)
    links = (Link("base"), two.link("two"))
    return replace(
        two,
        links=links,
        joints=two.joints[1:],
        cuts=(replace(two.cuts[0], a=Frame("base", two.cuts[0].a.placement)),),
        homes=(Home("default", {}, {"f2": two.homes[0].passive["f2"]}),),
    )


@pytest.mark.parametrize("kind", KINDS)
def test_mobility_is_six_less_the_rows_and_the_motion_is_the_joints(kind: str, kit: Any) -> None:
    chain = ClosedChain(on_the_world(kind, kit))
    rows = CutType(kind).rows
    report = chain.mobility()
    assert (report.velocities, report.rows, report.rank, report.mobility) == (6, rows, rows, 6 - rows)
    assert report.redundant_rows == ()
    assert report.free == (("f2",) if rows < 6 else ())
    body = pin.SE3(chain.link_placements(chain.home)["two"])
    _, a, b = chain.cut_placements(chain.home)[0]
    in_b = (body.inverse() * pin.SE3(b)).toActionMatrixInverse()
    twists = (in_b @ kit.motions(chain, chain.home.q_full)).T  # of the body, seen from frame b
    if kind == "universal":
        x = b[:3, :3].T @ a[:3, 0]
        wanted = np.array([[0.0, 0.0, 0.0, *x], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]])
        assert x @ [0.0, 1.0, 0.0] == pytest.approx(0.0, abs=1e-12)
    elif kind == "distance":
        along = b[:3, :3].T @ (b[:3, 3] - a[:3, 3])
        across = np.linalg.svd(along[None, :])[2][1:]
        wanted = np.block([[across, np.zeros((2, 3))], [np.zeros((3, 3)), np.eye(3)]])
        assert np.linalg.norm(along) == pytest.approx(LENGTH, rel=1e-12)
    else:
        wanted = FREE[kind]
    assert np.linalg.matrix_rank(np.vstack([twists, wanted]), tol=1e-9) == len(wanted) == len(twists)


@pytest.mark.parametrize("kind", KINDS)
def test_any_start_closes_the_right_way_round(kind: str, kit: Any) -> None:
    """A hinge whose axes point against each other satisfies x'z = y'z = 0 too, and is not closed."""
    chain = ClosedChain(on_the_world(kind, kit))
    rng = np.random.default_rng(4)
    for _ in range(40):
        start = np.r_[rng.normal(size=3), pin.Quaternion(pin.exp3(2.0 * rng.normal(size=3))).coeffs()]
        found = chain.assemble(start)
        _, a, b = chain.cut_placements(found)[0]
        between = np.linalg.inv(a) @ b
        if kind == "revolute":
            assert between[2, 2] == pytest.approx(1.0, abs=1e-12)
        if kind in ("fixed", "prismatic"):
            np.testing.assert_allclose(between[:3, :3], np.eye(3), atol=1e-12)
        assert max(found.gap) < 1e-12


def test_a_hinge_started_exactly_upside_down_still_closes(kit: Any) -> None:
    chain = ClosedChain(on_the_world("revolute", kit))
    half_turn = np.diag([1.0, -1.0, -1.0])
    upside_down = pin.SE3(np.array(chain.description.cuts[0].a.placement)) * pin.SE3(half_turn, np.zeros(3))
    start = upside_down * pin.SE3(np.array(chain.description.cuts[0].b.placement)).inverse()
    q = pin.SE3ToXYZQUAT(start)
    assert chain.gap(q)[1] == pytest.approx(np.pi)
    assert chain.assemble(q).gap[1] < 1e-12


# ---- a cut joint moves like the joint --------------------------------------------------------------------------------

AXIS = readonly(np.array([0.6, -0.3, 0.5]) / np.linalg.norm([0.6, -0.3, 0.5]))
ACROSS = readonly(np.cross(AXIS, [0.0, 0.0, 1.0]) / np.linalg.norm(np.cross(AXIS, [0.0, 0.0, 1.0])))
JOINTS = {
    "fixed": JointType.FIXED,
    "revolute": JointType.REVOLUTE,
    "prismatic": JointType.PRISMATIC,
    "universal": JointType.UNIVERSAL,
    "spherical": JointType.SPHERICAL,
}


def frames(kind: str) -> tuple[np.ndarray, np.ndarray]:
    """Frames of the cut on either body, given that the joint's frame is one and the same at zero."""
    if kind in ("revolute", "prismatic"):
        turn = np.eye(4)
        turn[:3, :3] = frame_along(AXIS)
        return turn, turn
    if kind == "universal":
        turn = np.eye(4)
        turn[:3, :3] = np.column_stack([AXIS, ACROSS, np.cross(AXIS, ACROSS)])
        return turn, turn
    return np.eye(4), np.eye(4)


def tree_and_cut(kind: str, kit: Any) -> tuple[ClosedChain, ClosedChain]:
    """A driven arm with a body at its end on a joint; and the same with that joint cut."""
    place = placement((0.3, 0.1, -0.05), (0.2, 0.5, -0.3))
    arm = Joint(
        "arm", JointType.REVOLUTE, "base", "one", placement((0, 0, 1), (0.3, 0.2, 0)), axis=readonly([0.0, 1.0, 0.0])
    )
    links = (Link("base"), Link("one", kit.body(1.5)), Link("two", kit.body(0.8, (0.05, 0.06, -0.03), 2)))
    joint = Joint("joint", JOINTS[kind], "one", "two", place, axis=AXIS, axis2=ACROSS)
    tree = RobotDescription("tree", links, (arm, joint), actuators=("arm",))
    a, b = frames(kind)
    cut = replace(
        tree,
        name="cut",
        joints=(arm, Joint("free", JointType.FLOATING, "base", "two")),
        cuts=(CutJoint("joint", CutType(kind), Frame("one", place @ a), Frame("two", b)),),
        homes=(Home("default", {"arm": 0.0}, {"free": (0.3, 0.1, 0.95, 0.0, 0.0, 0.0)}),),
    )
    return ClosedChain(tree), ClosedChain(cut)


@pytest.mark.parametrize("kind", JOINTS)
def test_a_cut_joint_has_the_dynamics_of_the_joint(kind: str, kit: Any) -> None:
    tree, cut = tree_and_cut(kind, kit)
    assert cut.mobility().mobility == tree.nv
    rng = np.random.default_rng(5)
    for _ in range(5):
        q = pin.integrate(tree.model, pin.neutral(tree.model), rng.uniform(-0.7, 0.7, tree.nv))
        v, torque = rng.normal(size=tree.nv), rng.normal()
        data = tree.model.createData()
        pin.forwardKinematics(tree.model, data, q, v, np.zeros(tree.nv))
        pose = pin.SE3(tree.link_placements(q)["two"])
        frame = tree.model.getFrameId("two", pin.FrameType.BODY)
        twist = pin.getFrameVelocity(tree.model, data, frame, pin.ReferenceFrame.LOCAL)

        q_cut, v_cut = np.r_[q[0], pin.SE3ToXYZQUAT(pose)], np.r_[v[0], twist.vector]
        assert max(cut.gap(q_cut)) < 1e-12
        assert np.abs(cut.constraint_jacobian(q_cut) @ v_cut).max() < 1e-12
        a = tree.full_forward_dynamics(tree.posture(q), v, tree.full_effort([torque])).acceleration
        motion = cut.full_forward_dynamics(cut.posture(q_cut), v_cut, cut.full_effort([torque]))
        pin.forwardKinematics(tree.model, data, q, v, np.array(a))
        wanted = pin.getFrameAcceleration(tree.model, data, frame, pin.ReferenceFrame.LOCAL).vector
        np.testing.assert_allclose(motion.acceleration, np.r_[a[0], wanted], atol=1e-10)

        energy = pin.computeKineticEnergy(tree.model, data, q, v)
        assert pin.computeKineticEnergy(cut.model, cut.model.createData(), q_cut, v_cut) == pytest.approx(energy)
        height = pin.computePotentialEnergy(tree.model, data, q)
        assert pin.computePotentialEnergy(cut.model, cut.model.createData(), q_cut) == pytest.approx(height)

        # the wrench in the cut is what Newton and Euler ask of the body that hangs on it
        _, _, b = cut.cut_placements(q_cut)[0]
        inertial = tree.description.link("two").inertial
        rotation, com = pose.rotation, pose.act(np.array(inertial.com))
        acceleration = pin.Motion(motion.acceleration[1:]) + pin.Motion.Zero()
        spin = rotation @ twist.angular
        alpha = rotation @ acceleration.angular
        origin = rotation @ (acceleration.linear + np.cross(twist.angular, twist.linear))
        arm = com - pose.translation
        force = inertial.mass * (origin + np.cross(alpha, arm) + np.cross(spin, np.cross(spin, arm)) - [0, 0, -9.81])
        inertia = rotation @ inertial.inertia @ rotation.T
        moment = inertia @ alpha + np.cross(spin, inertia @ spin) + np.cross(com - b[:3, 3], force)
        wrench = motion.loop_forces["joint"]
        np.testing.assert_allclose(wrench.force, force, atol=1e-10)
        np.testing.assert_allclose(wrench.moment, moment, atol=1e-10)


def gears(ratio: float, offset: float, kinds: tuple[JointType, JointType] = (JointType.REVOLUTE,) * 2) -> ClosedChain:
    """Two wheels (or a wheel and a rack) on the ground, coupled."""
    axis = readonly([0.0, 0.0, 1.0])
    bodies = [Inertial(m, np.zeros(3), i * np.eye(3)) for m, i in ((2.0, 0.03), (0.7, 0.002))]
    return ClosedChain(
        RobotDescription(
            "gears",
            (Link("base"), Link("one", bodies[0]), Link("two", bodies[1])),
            (
                Joint("one", kinds[0], "base", "one", axis=axis),
                Joint("two", kinds[1], "base", "two", placement((0.5, 0, 0)), axis=axis),
            ),
            couplings=(Coupling.geared("mesh", "two", "one", ratio, offset),),
            actuators=("one",),
            gravity=readonly([0.0, 0.0, 0.0]),
        )
    )


@pytest.mark.parametrize("ratio", [-2.5, 0.4, 30.0])
def test_a_gear_reflects_its_inertia_by_the_square_of_the_ratio(ratio: float) -> None:
    chain = gears(ratio, 0.3)
    at = chain.close([0.7])
    assert at.q_full == pytest.approx([0.7, 0.7 * ratio + 0.3], abs=1e-12)
    inertia = 0.03 + ratio**2 * 0.002
    assert chain.terms(at).mass[0, 0] == pytest.approx(inertia, rel=1e-13)
    motion = chain.full_forward_dynamics(at, chain.full_velocity(at, [1.0]), chain.full_effort([5.0]))
    assert motion.acceleration == pytest.approx(np.array([1.0, ratio]) * 5.0 / inertia, rel=1e-12)
    assert motion.couplings["mesh"] == pytest.approx(0.002 * ratio * 5.0 / inertia, rel=1e-12)
    assert motion.loop_forces == {}


def test_a_rack_and_pinion() -> None:
    chain = gears(0.05, 0.0, (JointType.REVOLUTE, JointType.PRISMATIC))
    assert chain.mobility().mobility == 1
    at = chain.close([2.0])
    assert at.q_full[1] == pytest.approx(0.1, abs=1e-13)
    assert chain.terms(at).mass[0, 0] == pytest.approx(0.03 + 0.05**2 * 0.7, rel=1e-13)
    open_by = chain.gap(np.array([2.0, 0.35]))
    assert open_by == (pytest.approx(0.25), 0.0), "a gap of a rack is a length"


def test_a_coupling_and_a_cut_in_one_robot(kit: Any) -> None:
    """A parallelogram whose second crank is geared to the first one: one row more, the same motion."""
    description = kit.planar_fourbar((0.3, 0.5, 0.3), 0.5, (1.0, -1.0, 1.0))
    plain = ClosedChain(description)
    geared = ClosedChain(replace(description, couplings=(Coupling.geared("belt", "c", "a", 1.0, 0.0),)))
    report = geared.mobility()
    assert (report.rows, report.rank, report.mobility) == (6, 2, 1)
    assert len(report.redundant_rows) == 4
    for angle in (0.4, 1.3, 2.5):
        one, two = plain.close([angle]), geared.close([angle])
        np.testing.assert_allclose(one.q_full, two.q_full, atol=1e-12)
        a = plain.forward_dynamics(one, [2.0], [1.5])
        assert geared.forward_dynamics(two, [2.0], [1.5]) == pytest.approx(a, rel=1e-11)
