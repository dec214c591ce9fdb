"""Small robots, a kind each: idle spins, cuts that hold nothing, two scales in one robot, one joint, no mass."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from kit import judge
from kit.ball_rods import Delta, ankle
from kit.blueprint import Blueprint, random_mounting, random_rotation, unit
from kit.built import at_home, built
from kit.by_joint import by_joint, full, placed
from kit.postures import moving, random_posture
from oracles.maximal import Maximal

from cutjoint.chain import ClosedChain
from cutjoint.errors import CutjointError

ACCURACY = 1e-10
X, Y, Z = np.eye(3)


def judged(chain: ClosedChain, oracle: Maximal, at: Any, rng: np.random.Generator, limit: float = ACCURACY) -> None:
    """Everything at a posture with a random motion and random efforts."""
    p = placed(chain, oracle, at.q_full)
    v, effort = moving(chain, p, rng.normal(size=p.mobility)), rng.normal(size=chain.nv)
    judge.require(judge.everything(chain, oracle, at, v, effort, rng), limit)


# ---- rods with a ball at either end ---------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(4))
def test_a_delta_on_ball_rods_by_lagrange(seed: int, tmp_path: Path) -> None:
    """Torques at rest are the slope of the potential; let go, it falls as one freedom does, whatever the spins are."""
    rng = np.random.default_rng(seed)
    robot = Delta(rod=rng.uniform(0.35, 0.45), arm=rng.uniform(0.15, 0.2), rod_mass=rng.uniform(0.02, 0.08))
    angle = rng.uniform(0.1, 0.6)
    chain, oracle = built(robot.plan(angle, rng), tmp_path)
    slope = (robot.potential(angle + 1e-5) - robot.potential(angle - 1e-5)) / 2e-5
    assert 3.0 * robot.torque_at_rest(angle) == pytest.approx(slope, rel=1e-8)
    report, rest = chain.mobility(), np.zeros(3)
    assert (report.mobility, report.actuators, len(report.idle)) == (9, 3, 6)
    torque = chain.inverse_dynamics(chain.home, rest, rest)
    np.testing.assert_allclose(torque, np.full(3, robot.torque_at_rest(angle)), rtol=1e-12)
    falling = -3.0 * robot.torque_at_rest(angle) / robot.mass(angle)
    np.testing.assert_allclose(chain.forward_dynamics(chain.home, rest, rest), np.full(3, falling), rtol=1e-11)
    mass = chain.terms(chain.home).mass
    assert np.ones(3) @ mass @ np.ones(3) == pytest.approx(robot.mass(angle), rel=1e-12)
    judged(chain, oracle, chain.home, rng)


def test_an_ankle_holds_its_weight(tmp_path: Path) -> None:
    """Two motors on ball rods: torques at rest are the slopes of the potential along each motor."""
    rng = np.random.default_rng(2)
    chain, oracle = built(ankle(rng, even=True), tmp_path)
    for at in (chain.home, chain.close(chain.home.q + np.array([0.2, -0.1]))):
        slopes = []
        for step in 1e-5 * np.eye(2):
            up, down = (chain.potential_energy(chain.close(at.q + sign * step, at)) for sign in (1, -1))
            slopes.append((up - down) / 2e-5)
        np.testing.assert_allclose(chain.inverse_dynamics(at, [0, 0], [0, 0]), slopes, rtol=1e-7, atol=1e-8)
        point = chain.tool(at).position
        np.testing.assert_allclose(chain.reach(point, chain.home).q, at.q, atol=1e-9)
        judged(chain, oracle, at, rng)


def test_a_rod_without_mass_is_a_distance(tmp_path: Path) -> None:
    """Bodies without mass between two balls: the rest moves as if only lengths were held."""
    rng = np.random.default_rng(3)
    plan = ankle(rng)
    for link in ("rod_left", "rod_right"):
        plan.inertias[link] = None
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    for at in (chain.home, random_posture(chain, oracle, rng, 0.2)):
        p = placed(chain, oracle, at.q_full)
        state = p.moving(by_joint(chain, moving(chain, p, rng.normal(size=p.mobility))))
        assert state.massless.shape[1] == 2
        effort = chain.full_effort(rng.normal(size=2))
        judge.require(judge.forward(chain, state, at, full(chain, state.speeds), effort), ACCURACY)
        found = judge.actuated(chain, oracle, at, rng)
        assert found
        judge.require(found, ACCURACY)


# ---- cuts that hold nothing -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("cut", ["spherical", "revolute", "universal"])
def test_a_cut_that_the_tree_meets_anyway(cut: str, tmp_path: Path) -> None:
    """Limbs of two and three hinges through one point: a ball there holds nothing, other cuts only turns."""
    rng = np.random.default_rng(4)
    plan, centre = Blueprint(f"{cut}_at_centre", rng), np.array([0.3, -0.1, 0.2])
    ends = []
    for name, count in (("a", 2), ("b", 3)):
        link = "base"
        for index in range(count):
            plan.joint(f"{name}{index}", "continuous", link, f"{name}_link{index}", centre, rng.normal(size=3))
            link = f"{name}_link{index}"
        ends.append(link)
    plan.cut("cut", cut, *ends, centre, unit(rng.normal(size=3)), rng.normal(size=3))
    rank = {"spherical": 0, "revolute": 2, "universal": 1}[cut]
    for index in range(3):
        chain, oracle = built(plan, tmp_path / str(index), random_mounting(rng))
        report = chain.mobility()
        assert (report.velocities, report.rank, report.mobility) == (5, rank, 5 - rank)
        assert len(report.redundant_rows) == report.rows - rank
        judged(chain, oracle, chain.home, rng)
        judged(chain, oracle, random_posture(chain, oracle, rng), rng)


# ---- two scales -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("small", [0.03, 0.003, 0.001, 0.0003, 0.0001])
def test_small_links_beside_large_ones(small: float, tmp_path: Path) -> None:
    """Two parallelograms on one base, one of 1.5 m: the small one stays closed and movable however small it is."""
    rng = np.random.default_rng(5)
    plan = Blueprint("two_scales", rng, size=0.3)
    for name, length in (("large", 1.5), ("small", small)):
        crank, base = length * np.array([0.4, 0.8, 0.0]), length * X
        plan.joint(f"{name}_1", "continuous", "base", f"{name}_a", np.zeros(3), Z)
        plan.joint(f"{name}_2", "continuous", f"{name}_a", f"{name}_b", crank, Z)
        plan.joint(f"{name}_3", "continuous", "base", f"{name}_c", base, Z)
        plan.cut(name, "revolute", f"{name}_b", f"{name}_c", base + crank, Z)
    plan.actuators = ["large_1", "small_1"]
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    report = chain.mobility()
    assert (report.mobility, report.rank, report.determined) == (2, 4, True)
    assert max(report.gap) < 1e-12
    at = chain.close(chain.home.q + np.array([0.3, -0.4]))
    p = placed(chain, oracle, at.q_full)
    assert p.mobility == 2
    assert max(map(max, p.gaps.values())) < 1e-12
    # the small one's forces pass through levers that are small part of the robot, and lose as many digits
    judged(chain, oracle, at, rng, ACCURACY / min(1.0, 10.0 * small))


# ---- the smallest sizes ---------------------------------------------------------------------------------------------


def one_joint(kind: str, hinges: int, actuators: list[str]) -> Blueprint:
    rng = np.random.default_rng(6)
    plan = Blueprint(f"{kind}_{hinges}", rng)
    plan.joint("joint", kind, "base", "leaf", np.zeros(3), Z)
    for index in range(hinges):
        cut = "prismatic" if kind == "prismatic" else "revolute"
        plan.cut(f"hinge{index}", cut, "base", "leaf", (index + 1.0) * Z, Z)
    plan.actuators, plan.tool = actuators, ("leaf", np.array([0.4, 0.1, 0.3]))
    return plan


@pytest.mark.parametrize("kind", ["continuous", "revolute", "prismatic"])
@pytest.mark.parametrize("hinges", [0, 1, 2])
def test_one_joint(kind: str, hinges: int, tmp_path: Path) -> None:
    """A pendulum, a slider, a door on further hinges: the smallest robots answer every question."""
    rng = np.random.default_rng(7)
    chain, oracle = built(one_joint(kind, hinges, ["joint"]), tmp_path, random_mounting(rng))
    report = chain.mobility()
    assert (report.velocities, report.rank, report.mobility, report.determined) == (1, 0, 1, True)
    assert len(report.redundant_rows) == 5 * hinges
    judged(chain, oracle, chain.home, rng)
    at = chain.close(chain.home.q + 0.2)
    judged(chain, oracle, at, rng)
    tool, h = chain.tool(at, [1.0]), 1e-6
    ahead, behind = (chain.tool(chain.close(at.q + step, at)).position for step in (h, -h))
    np.testing.assert_allclose((ahead - behind) / (2 * h), tool.jacobian[:, 0], atol=1e-8)
    np.testing.assert_allclose(chain.reach(tool.position).q, at.q, atol=1e-9)
    np.testing.assert_allclose(chain.assemble(at).q, at.q, atol=1e-12)
    q, v = chain.project(at.q_full, np.ones(1))
    np.testing.assert_allclose(q, at.q_full, atol=1e-12)
    np.testing.assert_allclose(v, np.ones(1), atol=1e-12)


@pytest.mark.parametrize("hinges", [0, 1])
def test_one_joint_without_a_motor(hinges: int, tmp_path: Path) -> None:
    rng = np.random.default_rng(8)
    chain, oracle = built(one_joint("continuous", hinges, []), tmp_path, random_mounting(rng))
    assert (chain.n, chain.mobility().mobility, chain.mobility().free) == (0, 1, ("joint",))
    judged(chain, oracle, chain.home, rng)


def test_one_joint_that_a_cut_holds(tmp_path: Path) -> None:
    """A lock on a hinge: a structure of one velocity and no mobility."""
    rng = np.random.default_rng(9)
    plan = one_joint("continuous", 0, [])
    plan.cut("lock", "fixed", "base", "leaf", np.array([0.3, 0.2, 0.1]))
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    report = chain.mobility()
    assert (report.velocities, report.rows, report.rank, report.mobility, report.free) == (1, 6, 1, 0, ())
    judged(chain, oracle, chain.home, rng)


def test_nothing_that_moves(tmp_path: Path) -> None:
    """Two plates bolted together: no velocities, no answer that is not empty, no traceback."""
    plan = Blueprint("still", np.random.default_rng(10))
    plan.joint("bolts", "fixed", "base", "plate", X)
    try:
        chain, oracle = built(plan, tmp_path)
    except CutjointError:
        return
    report = chain.mobility()
    assert (report.velocities, report.rows, report.mobility) == (0, 0, 0)
    empty = np.zeros(0)
    assert chain.full_forward_dynamics(chain.home, empty, empty).acceleration.shape == (0,)
    assert chain.inverse_dynamics(chain.home, empty, empty).shape == (0,)
    assert chain.potential_energy(chain.home) == oracle.at({}).potential_energy == 0.0


def test_a_gear_alone(tmp_path: Path) -> None:
    """No cut, one coupling: two wheels, one freedom, and the force in the teeth."""
    rng = np.random.default_rng(11)
    plan = Blueprint("gear", rng)
    for name in ("left", "right"):
        plan.joint(name, "continuous", "base", f"{name}_wheel", rng.normal(size=3), rng.normal(size=3))
    plan.couple("teeth", "right", "left", -1.5)
    plan.actuators = ["left"]
    chain, oracle = built(plan, tmp_path, random_mounting(rng))
    assert (chain.mobility().mobility, chain.mobility().determined) == (1, True)
    judged(chain, oracle, chain.home, rng)
    p = placed(chain, oracle, chain.home.q_full)
    motion = p.moving({}).driven({"left": 2.0, "right": -0.7})
    found = chain.full_forward_dynamics(chain.home, np.zeros(2), np.array([2.0, -0.7]))
    assert found.couplings["teeth"] == pytest.approx(motion.couplings["teeth"], rel=1e-11)


def test_turned_bases_fall_alike(tmp_path: Path) -> None:
    """A geared four-bar closed by a ball, let go at forty mountings with gravity turned along."""
    rng = np.random.default_rng(12)
    plan, tilt = Blueprint("tilted_gear", rng), random_rotation(rng)
    points = [tilt @ np.array(point) for point in ([0, 0, 0], [0.15, 0.17, 0], [0.56, 0.34, 0], [0.5, 0, 0])]
    plan.joint("j1", "continuous", "base", "crank", points[0], tilt @ Z)
    plan.joint("j2", "continuous", "crank", "coupler", points[1], tilt @ Z)
    plan.joint("j3", "continuous", "base", "rocker", points[3], tilt @ Z)
    plan.joint("j4", "continuous", "base", "wheel", tilt @ np.array([-0.3, 0.0, 0.0]), tilt @ Z)
    plan.cut("pin", "spherical", "coupler", "rocker", points[2])
    plan.couple("gear", "j4", "j1", -2.0)
    plan.actuators = ["j1"]
    still = Maximal(plan.write(tmp_path / "still"), length=0.3)
    wanted = still.at(at_home(plan, still)).moving({}).driven({}).joints["j1"]
    for index in range(40):
        chain, _ = built(plan, tmp_path / str(index), random_mounting(rng, turned=True))
        np.testing.assert_allclose(chain.forward_dynamics(chain.home, [0.0], [0.0]), wanted, rtol=1e-11)
