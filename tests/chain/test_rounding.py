"""Robots as a CAD program exports them, lengths rounded: nearly dependent rows must not lock them."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit.blueprint import Blueprint, random_mounting, random_rotation
from kit.built import built
from kit.judge import everything, require
from kit.loops import loop
from kit.mechanisms import limb, on_circle
from typer.testing import CliRunner

import cutjoint
from cutjoint import tolerances
from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import kinematic_problems
from cutjoint.cli import app
from cutjoint.description import Frame, RobotDescription, load_description
from cutjoint.errors import ClosureError, RoundingWarning

pytestmark = pytest.mark.filterwarnings("ignore::cutjoint.errors.RoundingWarning")


def rounded(name: str, error: float, seed: int = 0) -> RobotDescription:
    """The shipped robot with every cut frame off by up to `error` in metres."""
    robot, random = load_description(name), np.random.default_rng(seed)

    def moved(frame: Frame) -> Frame:
        placement = np.array(frame.placement)
        placement[:3, 3] += random.uniform(-error, error, 3)
        return Frame(frame.link, placement)

    return replace(robot, cuts=tuple(replace(cut, a=moved(cut.a), b=moved(cut.b)) for cut in robot.cuts))


@pytest.mark.parametrize("error", [1e-7, 1e-6, 1e-5])
@pytest.mark.parametrize("name", ["omega3", "fivebar", "fourbar"])
def test_rounding_does_not_take_the_mobility(name: str, error: float) -> None:
    exact, chain = cutjoint.load(name), ClosedChain(rounded(name, error))
    right, found = exact.mobility(), chain.mobility()
    assert (found.mobility, found.rank, found.rows) == (right.mobility, right.rank, right.rows)
    assert len(found.redundant_rows) == len(right.redundant_rows)
    assert found.determined
    # the rows that were left out are open by about the rounding, and the posture says so
    assert 0.0 < max(found.gap) < 200.0 * error / chain.length


@pytest.mark.parametrize("name", ["omega3", "fivebar"])
def test_a_rounded_robot_moves_and_weighs_like_the_exact_one(name: str) -> None:
    exact, chain = cutjoint.load(name), ClosedChain(rounded(name, 1e-6))
    random = np.random.default_rng(1)
    for _ in range(5):
        q = exact.home.q + random.uniform(-0.1, 0.1, exact.n)
        right, at = exact.close(q), chain.close(q)
        np.testing.assert_allclose(chain.tool(at).position, exact.tool(right).position, rtol=0, atol=1e-4)
        v, effort = random.normal(size=chain.n), random.normal(size=chain.n)
        a = chain.forward_dynamics(at, v, effort)
        wanted = exact.forward_dynamics(right, v, effort)
        np.testing.assert_allclose(a, wanted, rtol=0, atol=1e-3 * np.abs(wanted).max())
        np.testing.assert_allclose(chain.inverse_dynamics(at, v, a), effort, rtol=0, atol=1e-10)


def test_exact_robots_keep_all_their_rows() -> None:
    for name in ("omega3", "cpm", "fivebar", "stewart", "redundant"):
        chain = cutjoint.load(name)
        assert chain._k.closure.left_out == ()


def moved_out_of_plane(by: float) -> RobotDescription:
    """The five-bar with one hinge of the cut beside its plane."""
    robot = load_description("fivebar")
    place = np.array(robot.cuts[0].a.placement)
    place[:3, 3] += by * place[:3, 2]
    return replace(robot, cuts=(replace(robot.cuts[0], a=Frame(robot.cuts[0].a.link, place)),))


def test_a_warning_names_the_rows_and_what_stays_open() -> None:
    with pytest.warns(RoundingWarning) as caught:
        chain = ClosedChain(moved_out_of_plane(3e-6))
    text, report = str(caught[0].message), chain.mobility()
    assert report.dropped_rows
    assert set(report.dropped_rows) <= set(report.redundant_rows)
    assert all(row in text for row in report.dropped_rows)
    assert "3e-06 m" in text
    assert report.gap[0] == pytest.approx(3e-6, rel=1e-6)
    assert chain.home.gap == report.gap


@pytest.mark.parametrize(("by", "open_or_not"), [(0.9, False), (1.1, True)])
def test_more_than_rounding_explains_is_an_error(by: float, open_or_not: bool) -> None:
    """It names the rows and the gap; a ten-thousandth of the robot is the limit."""
    limit = tolerances.ROUNDED_GAP.value * cutjoint.load("fivebar")._k.reach
    if not open_or_not:
        assert ClosedChain(moved_out_of_plane(by * limit)).mobility().dropped_rows
        return
    with pytest.raises(ClosureError) as caught:
        ClosedChain(moved_out_of_plane(by * limit))
    assert caught.value.gap[0] == pytest.approx(by * limit, rel=1e-6)
    assert caught.value.cut == "tip"
    assert f"{by * limit:.3g} m" in str(caught.value)
    assert "tip." in str(caught.value)


def plan_of(name: str, rng: np.random.Generator) -> Blueprint:
    plan, _ = loop("planar", "revolute", "none", rng)
    plan.name, plan.actuators = name, ["a1" if any(one.name == "a1" for one in plan.joints) else "b1"]
    return plan


def test_check_shows_it_as_a_warning(tmp_path: Path) -> None:
    plan = plan_of("rounded", np.random.default_rng(0))
    link, rotation, position = plan.cuts[0].a
    plan.cuts[0].a = (link, rotation, position + 1e-6 * rotation[:, 2])
    folder = plan.write(tmp_path)
    done = CliRunner().invoke(app, ["check", str(folder)])
    assert done.exit_code == 0, done.output
    text = " ".join(done.output.split())
    assert "0 errors" in text
    assert "close only up to rounding: cut." in text
    problems, chain = kinematic_problems(load_description(folder))
    assert chain is not None
    found = [problem for problem in problems if "rounding" in problem.found]
    assert len(found) == 1
    assert found[0].severity == "warning"
    assert all(row in found[0].found for row in chain.mobility().dropped_rows)
    assert "1e-06 m" in found[0].found
    assert not any("adds nothing" in problem.found for problem in problems)


def two_scales(small: float, rng: np.random.Generator) -> Blueprint:
    """Parallelograms of 1.5 m and of `small` on one base."""
    plan = Blueprint("two_scales", rng, size=0.3)
    for name, size, place in (("large", 1.5, np.zeros(3)), ("small", small, np.array([0.3, 0.1, 0.2]))):
        plan.size = size
        tilt = random_rotation(rng)
        crank, base = tilt @ (0.6 * size * on_circle(1.0, 1.0)), tilt @ (size * on_circle(1.0, 0.0))
        axis = tilt @ [0.0, 0.0, 1.0]
        points = [("continuous", place, axis), ("continuous", place + crank, axis)]
        limb(plan, f"{name}_a", "base", points)
        limb(plan, f"{name}_b", "base", [("continuous", place + base, axis)])
        plan.cut(name, "revolute", f"{name}_a_link2", f"{name}_b_link1", place + base + crank, axis)
    plan.actuators = ["large_a1", "small_a1"]
    return plan


@pytest.mark.parametrize("small", [3e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5])
def test_a_small_linkage_beside_a_large_one_is_no_rounding(small: float, tmp_path: Path) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            chain, _ = built(two_scales(small, rng), tmp_path / str(seed), random_mounting(rng))
        report = chain.mobility()
        assert (report.rank, report.mobility, report.determined) == (4, 2, True)
        assert report.dropped_rows == ()
        assert len(report.redundant_rows) == report.rows - report.rank
        at = chain.close(chain.home.q + rng.uniform(-0.3, 0.3, 2))
        assert max(at.gap) < 1e-12
        effort = rng.normal(size=2) * [1.0, small]
        back = chain.inverse_dynamics(at, [1.0, 2.0], chain.forward_dynamics(at, [1.0, 2.0], effort))
        np.testing.assert_allclose(back, effort, rtol=1e-9)


def cranks(kind: str, error: float, seed: int) -> Blueprint:
    """A coupler on three equal cranks, on the base or on a free body, which locks as soon as a length is not equal:
    points and axes are off by up to `error`.  It is closed as it stands, and cut with `kind`."""
    rng, off = np.random.default_rng(seed), np.random.default_rng(seed)
    plan = Blueprint("cranks", rng, size=0.3)
    body = "base" if seed % 2 else "body"
    if body == "body":
        plan.joint("flight", "floating", "base", "body", 0.2 * rng.normal(size=3))
    tilt = random_rotation(rng)
    crank = tilt @ on_circle(0.3, rng.uniform(0.5, 1.2))
    feet = [tilt @ [x, y, 0.0] for x, y in ((0.0, 0.0), (0.5, 0.1), (0.9, -0.2))]
    moved = [[point + off.uniform(-error, error, 3) for point in (foot, foot + crank)] for foot in feet]
    axes = [tilt @ [0.0, 0.0, 1.0] + off.uniform(-error, error, 3) for _ in range(6)]
    limb(plan, "a", body, [("continuous", moved[0][0], axes[0]), ("continuous", moved[0][1], axes[1])])
    for index, name in ((1, "b"), (2, "c")):
        foot, tip = moved[index]
        joints = [("continuous", foot, axes[2 * index])]
        if kind == "fixed":
            joints.append(("continuous", tip, axes[2 * index + 1]))
        last = limb(plan, name, body, joints)
        plan.cut(f"cut_{name}", kind, "a_link2", last, tip, axes[2 * index + 1])
    plan.actuators = ["a1"]
    return plan


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 42))])
@pytest.mark.parametrize("kind", ["revolute", "fixed"])
def test_loops_that_close_at_home_alone_move_like_the_exact_ones(kind: str, seed: int, tmp_path: Path) -> None:
    """Digits from 5 to 9, on the ground or flying, wherever the crank goes; whatever is dropped goes along with the
    body."""
    error = 10.0 ** -np.random.default_rng(seed).uniform(5.0, 9.0)
    exact, _ = built(cranks(kind, 0.0, seed), tmp_path / "exact")
    with pytest.warns(RoundingWarning, match=r"cut_[bc]\."):
        chain, _ = built(cranks(kind, error, seed), tmp_path / "rounded")
    right, found = exact.mobility(), chain.mobility()
    assert (found.mobility, found.rank) == (right.mobility, right.rank)
    assert found.dropped_rows
    assert not right.dropped_rows
    assert max(chain.home.gap) < 1e-12
    random, compared = np.random.default_rng(seed), 0
    for turn in (0.0, 0.3, 0.9):
        q = np.array(chain.home.q_full)
        if chain.nq > chain.nv:
            q[3:7] = random.normal(size=4)
            q[3:7] /= np.linalg.norm(q[3:7])
        q[chain.model.idx_qs[chain.model.getJointId("a1")]] += turn
        try:
            at = chain.assemble(q)
        except ClosureError:
            assert turn  # where the rows that are left magnify the rounding
            continue
        nearby = exact.assemble(at.q_full)
        if np.linalg.svd(exact._k.at(nearby.q_full).scaled, compute_uv=False)[right.rank - 1] < 0.1:
            continue  # where two cranks are nearly in line with their feet the rounding is magnified
        assert max(at.gap) < 100.0 * error
        v = chain.project(at.q_full, random.normal(size=chain.nv))[1]
        effort = random.normal(size=chain.nv)
        a = chain.full_forward_dynamics(at, v, effort).acceleration
        wanted = exact.full_forward_dynamics(nearby, exact.project(nearby.q_full, v)[1], effort).acceleration
        size = np.linalg.svd(chain._k.at(at.q_full).scaled, compute_uv=False)[found.rank - 1]
        np.testing.assert_allclose(a, wanted, rtol=0, atol=100.0 * error / size**2 * (1.0 + np.abs(wanted).max()))
        compared += turn > 0.0
    assert compared


@pytest.mark.parametrize("cut", ["fixed", "revolute", "prismatic", "universal", "spherical"])
def test_a_structure_that_cannot_move_is_never_called_movable(cut: str, tmp_path: Path) -> None:
    """Loops with as many hinges as rows, in a random shape: closed as they stand, and nowhere else near by."""
    rows = {"fixed": 6, "revolute": 5, "prismatic": 5, "universal": 4, "spherical": 3}[cut]
    for seed in range(15):
        rng = np.random.default_rng(100 + seed)
        plan, link = Blueprint(f"rigid_{cut}", rng), "base"
        for index in range(rows):
            child = f"link{index}"
            plan.joint(f"hinge{index}", "continuous", link, child, 0.4 * rng.normal(size=3), rng.normal(size=3))
            link = child
        plan.cut("cut", cut, "base", link, 0.4 * rng.normal(size=3), rng.normal(size=3), rng.normal(size=3))
        plan.actuators = []
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            chain, oracle = built(plan, tmp_path / str(seed))
        report = chain.mobility()
        assert (report.mobility, report.rank, report.dropped_rows) == (0, rows, ())
        effort = rng.normal(size=rows)
        found = everything(chain, oracle, chain.home, np.zeros(rows), effort, rng)
        del found["unchecked"]  # measured by accelerations, of which there are none
        require(found, 1e-9, cut)
        push = chain.full_acceleration(chain.home.q_full, np.zeros(rows), effort)
        open_tree = np.linalg.solve(chain._k.tree.mass_matrix(chain.home.q_full), effort)
        assert np.abs(push).max() < 1e-9 * np.abs(open_tree).max()
        problems, _ = kinematic_problems(chain.description)
        assert any("cannot move" in problem.found for problem in problems)


@pytest.mark.parametrize(("small", "error"), [(1e-3, 1e-7), (3e-4, 1e-7), (1e-2, 5e-5), (2e-2, 1e-4)])
def test_rounding_of_one_loop_takes_no_rows_of_another(small: float, error: float, tmp_path: Path) -> None:
    """The large parallelogram is rounded; the small one has singular values far above that, and keeps its rows."""
    for seed in range(3):
        plan = two_scales(small, np.random.default_rng(seed))
        large = plan.cuts[0]
        link, rotation, position = large.a
        large.a = (link, rotation, position + error * rotation[:, 2])
        chain = ClosedChain(load_description(plan.write(tmp_path / str(seed))))
        report = chain.mobility()
        assert (report.rank, report.mobility, report.determined) == (4, 2, True)
        assert report.dropped_rows
        distance = {cut: float(np.linalg.norm((b - a)[:3, 3])) for cut, a, b in chain.cut_placements(chain.home)}
        assert distance["large"] == pytest.approx(error, rel=1e-6)
        assert distance["small"] < 1e-12


def test_loops_that_are_open_by_more_than_rounding_keep_all_their_rows() -> None:
    """By a hundredth of a link they are simply open."""
    with pytest.raises(ClosureError, match="no closed posture"):
        ClosedChain(moved_out_of_plane(0.01 * cutjoint.load("fivebar").length))
