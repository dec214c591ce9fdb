"""What is judged by a threshold is judged right on both sides of it, and what is checked is checked."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit.mechanisms import MECHANISMS
from kit.rods import ankle

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain, dynamics
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription, load_description
from cutjoint.description.model import CutJoint, CutType
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, DynamicsError, InputError
from cutjoint.robots import load

Z = readonly([0.0, 0.0, 1.0])


# ---- gaps -----------------------------------------------------------------------------------------------------------

OPENED = {
    "fixed": [(a, s) for a in range(3) for s in ("turn", "shift")],
    "revolute": [(0, "turn"), (1, "turn"), (0, "shift"), (1, "shift"), (2, "shift")],
    "prismatic": [(0, "turn"), (1, "turn"), (2, "turn"), (0, "shift"), (1, "shift")],
    "universal": [(2, "turn"), (0, "shift"), (1, "shift"), (2, "shift")],
    "spherical": [(0, "shift"), (1, "shift"), (2, "shift")],
}
"""Axes of frame a along which a cut can be opened, and how."""


@pytest.mark.parametrize("kind", OPENED)
def test_a_gap_is_by_how_much_a_cut_was_opened(kind: str, kit: Any) -> None:
    """Frame b is moved away from where the cut is closed by a known angle or distance; along what is free, no gap."""
    axes = placement((0.2, -0.1, 0.15), (0.4, -0.7, 1.1))
    links = (Link("base"), Link("one", kit.body()))
    arm = Joint("arm", JointType.CONTINUOUS, "base", "one", axis=Z)
    cut = CutJoint("cut", CutType(kind), Frame("base", axes), Frame("one", axes))
    chain = ClosedChain(RobotDescription("one", links, (arm,), (cut,)))
    frames, closure = chain._k.at(np.zeros(1)).frames, chain._k.closure
    free = {(axis, how) for axis in range(3) for how in ("turn", "shift")} - set(OPENED[kind])
    for axis, how in [*OPENED[kind], *free]:
        for size in (1e-3, 0.1, -0.4):
            moved = np.eye(4)
            if how == "shift":
                moved[axis, 3] = size
            else:
                i, j = (axis + 1) % 3, (axis + 2) % 3
                moved[i, i] = moved[j, j] = np.cos(size)
                moved[j, i], moved[i, j] = np.sin(size), -np.sin(size)
            b = axes @ moved
            there = replace(frames, axes_b=b[None, :3, :3], at_b=b[None, :3, 3])
            (distance,), (angle,) = closure.gaps(closure.residual(there, np.zeros(1)))
            wanted = (0.0, 0.0) if (axis, how) in free else (abs(size), 0.0) if how == "shift" else (0.0, abs(size))
            assert (distance, angle) == (pytest.approx(wanted[0], abs=1e-12), pytest.approx(wanted[1], abs=1e-12))


def test_idle_is_not_free(tmp_path: Path) -> None:
    """With one motor of two the foot still tilts; only the rods' spins leave the tool where it is."""
    plan = ankle(np.random.default_rng(0))
    plan.actuators = ["motor1"]
    report = ClosedChain(load_description(plan.write(tmp_path))).mobility()
    assert (report.mobility, report.idle_mobility, report.determined) == (4, 2, False)
    assert set(report.idle) == {"rod1_top", "rod2_top"}
    assert {"motor2", "ankle"} <= set(report.free)


# ---- what is out of reach -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("part", [1e-2, 1e-4, 2e-6])
def test_a_little_out_of_reach_is_out_of_reach(part: float, kit: Any) -> None:
    """By a part in a million too: neither tool nor actuators do nearly what was asked."""
    chain = load("fivebar")
    chain.full_motion(chain.home, [1.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="velocity"):
        chain.full_motion(chain.home, [1.0, part, 0.0], [0.0, 0.0, 0.0])
    with pytest.raises(InputError, match="acceleration"):
        chain.full_motion(chain.home, [0.0, 0.0, 0.0], [1.0, part, 0.0])
    chain, rng = load("underactuated"), np.random.default_rng(0)
    state = kit.random_states(chain, 1)[0]
    own = chain.full_forward_dynamics(state.at, state.v_full, chain.full_effort([3.0])).acceleration
    aside = kit.motions(chain, state.at.q_full) @ rng.normal(size=2)
    chain.full_inverse_dynamics(state.at, state.v_full, own)
    with pytest.raises(ActuationError):
        chain.full_inverse_dynamics(state.at, state.v_full, own + 10.0 * part * np.abs(own).max() * aside)


# ---- masses ---------------------------------------------------------------------------------------------------------


def wheels(*inertias: float, serial: bool = False, com: float = 0.0, mass: float = 0.0) -> ClosedChain:
    """Wheels about one axis, each on the base or each on the one before."""
    links, joints = [Link("base")], []
    for index, inertia in enumerate(inertias):
        body = Inertial(mass or max(inertia, 1e-30), np.array([com, 0.0, 0.0]), inertia * np.eye(3))
        links.append(Link(f"wheel{index}", body if inertia or mass else None))
        mother = links[-2].name if serial else "base"
        joints.append(Joint(f"turn{index}", JointType.CONTINUOUS, mother, f"wheel{index}", axis=Z))
    return ClosedChain(RobotDescription("wheels", tuple(links), tuple(joints)))


@pytest.mark.parametrize("small", [1e-3, 1e-9, 1e-15, 1e-20])
def test_a_light_wheel_beside_a_heavy_one_turns(small: float) -> None:
    chain = wheels(1.0, small)
    a = chain.full_forward_dynamics(chain.posture(np.zeros(2)), np.zeros(2), np.array([2.0, 3.0 * small])).acceleration
    np.testing.assert_allclose(a, [2.0, 3.0], rtol=1e-9)


@pytest.mark.parametrize("small", [1e-3, 1e-6, 1e-9, 1e-11])
def test_a_light_wheel_that_carries_a_heavy_one_turns(small: float) -> None:
    """M = [[1 + s, 1], [1, 1]]: the relative motion moves the light one alone."""
    chain, effort = wheels(small, 1.0, serial=True), np.array([2.0, 2.0 + 5.0 * small])
    a = chain.full_forward_dynamics(chain.posture(np.zeros(2)), np.zeros(2), effort).acceleration
    # the light wheel feels the first effort less the second, the heavy one the second
    assert a[0] == pytest.approx((effort[0] - effort[1]) / small, rel=1e-3)
    assert a.sum() == pytest.approx(effort[1], rel=1e-3 + 1e-15 / small)


def test_no_wheel_between_a_motor_and_a_heavy_one() -> None:
    """Of two joints on one axis with nothing between them only the sum moves; what pushes the rest is refused."""
    rng = np.random.default_rng(0)
    for count in (2, 3, 4):
        for _ in range(10):  # the zeros of the mass matrix are rounding, above or below
            inertia = 10.0 ** rng.uniform(-6, 6)
            effort = 2.0 * inertia * np.ones(count)
            chain = wheels(*([0.0] * (count - 1)), inertia, serial=True)
            q, v = rng.uniform(-3.0, 3.0, count), np.zeros(count)
            assert chain.full_forward_dynamics(chain.posture(q), v, effort).acceleration.sum() == pytest.approx(2.0)
            with pytest.raises(DynamicsError, match="no mass"):
                chain.full_forward_dynamics(chain.posture(q), v, effort * np.r_[np.ones(count - 1), 1.1])


def test_a_mass_on_the_axis_but_for_rounding_is_none() -> None:
    """0.1 + 0.2 - 0.3 is 6e-17, and the inertia of a kilogram there is nobody's."""
    heavy = wheels(1.0).description
    point = Inertial(1.0, np.array([0.1 + 0.2 - 0.3, 0.0, 0.0]), np.zeros((3, 3)))
    robot = replace(
        heavy,
        links=(*heavy.links, Link("point", point)),
        joints=(*heavy.joints, Joint("about", JointType.CONTINUOUS, "base", "point", axis=Z)),
    )
    chain = ClosedChain(robot)
    a = chain.full_forward_dynamics(chain.posture(np.zeros(2)), np.zeros(2), np.array([2.0, 0.0])).acceleration
    np.testing.assert_allclose(a, [2.0, 0.0], atol=1e-12)
    with pytest.raises(DynamicsError, match="no mass"):
        chain.full_forward_dynamics(chain.posture(np.zeros(2)), np.zeros(2), np.array([2.0, 1.0]))


# ---- what is checked ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("wrong", ["momentum", "loops"])
def test_forward_dynamics_checks_both_equations(wrong: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An answer that breaks either of them by a millionth is thrown away, whatever made it."""
    chain = load("cpm")
    v, effort = np.zeros(chain.nv), np.ones(chain.nv)
    chain.full_forward_dynamics(chain.home, v, effort)
    right = dynamics.Motions.of

    def spoiled(allowed: np.ndarray, mass: np.ndarray) -> dynamics.Motions:
        found = right(allowed, mass)
        if wrong == "momentum":
            return replace(found, factor=found.factor * (1.0 + 1e-6))
        return replace(found, basis=found.basis + 1e-6 * np.eye(*found.basis.shape))

    monkeypatch.setattr(dynamics.Motions, "of", spoiled)
    what = {"momentum": r"\|M a", "loops": r"\|K a"}[wrong]
    with pytest.raises(DynamicsError, match=what):
        chain.full_forward_dynamics(chain.home, v, effort)


@pytest.mark.parametrize("name", ["bricard", "parallelogram_flat"])
def test_an_iteration_that_has_not_converged_is_not_believed(name: str, tmp_path: Path) -> None:
    """Near singular postures Pinocchio's iteration stops far from the answer, and the equations are solved directly."""
    rng, missed = np.random.default_rng(1), 0
    chain = ClosedChain(load_description(MECHANISMS[name](rng).plan.write(tmp_path)))
    rigid = chain._dynamics.rigid
    assert rigid is not None
    for _ in range(30):
        step = chain._k.column_scale * rng.uniform(-1.0, 1.0, chain.nv) * rng.uniform(0.0, 1.5)
        at = chain.assemble(chain.integrate(chain.home.q_full, step), keep_actuators=False)
        q = at.q_full
        v, effort = np.zeros(chain.nv), rng.normal(size=chain.nv)
        missed += rigid.acceleration(q, v, effort) is None
        wanted = chain.full_forward_dynamics(at, v, effort).acceleration
        found = chain.full_acceleration(q, v, effort)
        # some of the closed postures stand apart and cannot move: then nothing of what the open tree would do is left
        size = max(np.abs(wanted).max(), 1e-3 * np.abs(np.linalg.solve(chain._k.tree.mass_matrix(q), effort)).max())
        assert np.abs(found - wanted).max() < 3e-8 * size
    assert missed > 0, "none of these postures would notice"
