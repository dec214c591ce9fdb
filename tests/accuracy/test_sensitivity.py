"""Sensitivities of the tool against robots built anew, and laws of tolerances, warmth and backlash."""

from __future__ import annotations

import warnings
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np
import pytest
from kit import curved, mechanisms
from kit.blueprint import random_mounting, random_rotation
from kit.sized import Size

import cutjoint
from cutjoint import ClosedChain
from cutjoint.accuracy import Deviation, accuracy, backlash, growth, sensitivity
from cutjoint.accuracy.reading import errors_from_file
from cutjoint.description import load_description, paths, value, with_values
from cutjoint.description.model import Inertial, JointType
from cutjoint.errors import ActuationError, CompileError, CutjointError, InputError, RoundingWarning, UnknownNameError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.rotations import vector_of
from cutjoint.stiffness import ElasticRobot, Springs

Array = np.ndarray
EVERYTHING = ["joints.*.origin.*", "cuts.*.[ab].*", "tool.*", "cuts.*.length", "couplings.*"]
BALLS = "cuts.ball1a.b.z = cuts.ball1b.b.z"


def mounted(name: str, seed: int, length: float = 1.0) -> ClosedChain:
    rng = np.random.default_rng(seed)
    return ClosedChain(
        Size(length, rotation=random_rotation(rng), offset=length * rng.normal(size=3)).of(load_description(name))
    )


def near(chain: ClosedChain, seed: int) -> Posture:
    change = 0.05 * np.random.default_rng(seed).uniform(-1.0, 1.0, chain.n)
    slides = np.array([one.kind == "translation" for one in chain.actuators])
    return chain.close(chain.home.q + change * np.where(slides, chain.length, 1.0))


def by_rebuilding(chain: ClosedChain, at: Posture, name: str, step: float) -> Array | None:
    """Slope (6,) of the tool's pose over a number, of chains built anew, by differences of fourth order; None where
    these do not close, or only by leaving rows out."""
    tools = []
    own = value(chain.description, name.split(" = ")[0])
    for many in (1.0, -1.0, 2.0, -2.0):
        changed = dict.fromkeys(name.split(" = "), own + many * step)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", RoundingWarning)
                other = chain.rebuilt(with_values(chain.description, changed))
                tools.append(other.tool(other.assemble(at.q_full)))
        except (CutjointError, RoundingWarning):
            return None
    axes = chain.tool(at).rotation
    poses = [np.concatenate([one.position, vector_of(one.rotation @ axes.T)]) for one in tools]
    return (8.0 * (poses[0] - poses[1]) - (poses[2] - poses[3])) / (12.0 * step)


def agree(chain: ClosedChain, at: Posture, names: list[str], every: int = 1, first: int = 0) -> int:
    """How many numbers were compared."""
    known = [*paths(chain.description)]
    names = [name for name in names if any(fnmatchcase(one, name) for one in known)]
    found, compared = sensitivity(chain, names, at), 0
    units = np.array([1.0 / chain.length] * 3 + [1.0] * 3)
    for k in range(first, len(found.names), every):
        if found.strained[k]:
            continue
        unit = chain.length if found.sources[k].unit == "m" else 1.0
        wanted = by_rebuilding(chain, at, found.names[k], 2e-4 * unit)
        if wanted is not None:
            error = np.abs(units * unit * (found.matrix[:, k] - wanted)).max()
            assert error < 1e-8 * max(1.0, np.abs(units * unit * wanted).max()), found.names[k]
            compared += 1
    return compared


def test_a_five_bar_anywhere() -> None:
    chain = mounted("fivebar", 1)
    assert agree(chain, near(chain, 2), EVERYTHING, 12) >= 2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "every", "least"),
    [("fivebar", 2, 12), ("fourbar", 2, 10), ("cpm", 6, 10), ("stewart", 12, 12), ("omega3", 5, 10)],
)
@pytest.mark.parametrize("length", [1.0, 1e3, 1e-3])
def test_shipped_robots_of_any_size(name: str, every: int, least: int, length: float) -> None:
    chain = mounted(name, 3, length)
    assert agree(chain, near(chain, 4), EVERYTHING, every, 1) >= least * (1 if length == 1.0 else 0.5)


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [mechanisms.ups_6, mechanisms.prs_3, curved.rod_delta, curved.rssr, mechanisms.geared_fivebar]
)
def test_random_mechanisms(make: object, tmp_path: Path) -> None:
    rng = np.random.default_rng(21)
    plan = make(rng).plan  # type: ignore[operator]
    robot = load_description(plan.write(tmp_path, random_mounting(rng)))
    chain = ClosedChain(robot)
    assert agree(chain, chain.home, EVERYTHING, 4 if len(robot.joints) < 12 else 16) >= 3


def test_rods_of_a_pair_together_are_what_the_joints_follow() -> None:
    """One rod alone needs joints that give; both together do not, and are the sum."""
    chain = cutjoint.load("omega3")
    found = sensitivity(chain, ["cuts.ball1a.b.z", "cuts.ball1b.b.z", BALLS])
    assert np.allclose(found.matrix[:, :2].sum(axis=1), found.matrix[:, 2], atol=1e-12)
    assert found.strained[0]
    assert found.strained[1]
    assert not found.strained[2]
    assert found.play[2] == found.turn[2] == 0.0
    assert (found.play[:2] > 1e-3).all()
    wanted = by_rebuilding(chain, chain.home, BALLS, 2e-5)
    assert wanted is not None
    assert np.abs(found.matrix[:, 2] - wanted).max() < 1e-8


@pytest.mark.slow
def test_one_rod_of_a_pair_tilts_the_platform_of_a_delta_of_balls() -> None:
    """Hinges that turn every way at no cost are balls: the redundant rows become equations, and the platform tilts."""
    robot = load_description("omega3")
    balls = Springs(joints={"rod*.ry": 0.0, "rod*.rz": 0.0})
    found = sensitivity(ClosedChain(robot), ["cuts.ball1a.b.z"], springs=balls)
    assert not found.strained[0]
    joints = (replace(one, type=JointType.SPHERICAL) if one.name.startswith("rod") else one for one in robot.joints)
    homes = (
        replace(one, passive={k: (v, 0.0, 0.0) if k.startswith("rod") else v for k, v in one.passive.items()})
        for one in robot.homes
    )
    heavy = tuple(replace(one, inertial=Inertial(0.1, inertia=1e-4 * np.eye(3))) for one in robot.links)
    other = ClosedChain(replace(robot, links=heavy, joints=tuple(joints), homes=tuple(homes)))
    wanted = by_rebuilding(other, other.home, "cuts.ball1a.b.z", 2e-5)
    assert wanted is not None
    assert np.abs(wanted[3:]).max() > 10.0
    assert np.abs(found.matrix[:, 0] - wanted).max() < 1e-8 * np.abs(wanted).max()


def test_play_is_that_of_the_softest_springs() -> None:
    """Equal springs in all joints and cuts, stated, share the misfit as joints do that give alike."""
    chain = cutjoint.load("fivebar")
    names = ["joints.left_elbow.origin.y", "cuts.tip.b.roll", "joints.right_elbow.origin.z", "cuts.tip.a.x"]
    alike = sensitivity(chain, names)
    springs = {one.name: 1e6 for one in (*chain.description.joints, *chain.description.cuts)}
    stated = sensitivity(chain, names, springs=Springs(joints=springs))
    assert np.allclose(alike.matrix, stated.matrix, atol=1e-9)
    assert (np.array([bool(one) for one in alike.strained]) == np.array([bool(one) for one in stated.strained])).all()


@pytest.mark.slow
def test_a_rod_too_long_pushes_as_a_force_does() -> None:
    """Betti: a spring that is 1 m too long moves the tool by k times what a unit force there strains the spring."""
    chain = ClosedChain(replace(load_description("omega3"), gravity=np.zeros(3)))
    springs = Springs(joints={"ball*": 1e6}, rods={"rod*_link": 4e5})
    elastic = ElasticRobot(chain, springs)
    found = sensitivity(chain, ["cuts.ball2a.b.z"], springs=springs)
    response, k = elastic.response(), elastic.kinematics
    tool = response.placed.tool_jacobian * k.column_scale
    answer = response.basis @ np.linalg.solve(response.stiffness, response.basis.T @ tool.T)
    give = next(one for one in elastic.gives if one.name == "rod2a_link")
    index = int(k.model.idx_vs[k.model.getJointId(give.joints[0])])
    along = elastic.description.joint(give.joints[0])
    assert np.allclose(np.abs(along.placement[:3, 0]), [0.0, 0.0, 1.0])
    strains = answer[index] * k.column_scale[index]
    sign = np.sign(along.placement[2, 0])
    assert np.allclose(found.matrix[:, 0], sign * 4e5 * strains, atol=1e-9 * np.abs(found.matrix).max())


# ---- budgets -------------------------------------------------------------------------------------------------------


def test_a_budget_adds_up() -> None:
    chain = cutjoint.load("fivebar")
    tolerances = {
        "joints.*_elbow.origin.x": Deviation(1e-4),
        "cuts.tip.b.x": Deviation(5e-5, normal=True),
        "actuators.*": 2e-4,
        "tool.z": 0.0,
    }
    found = accuracy(chain, tolerances, samples=40_000, seed=3)
    names = found.sensitivity.names
    assert names == (
        "joints.left_elbow.origin.x",
        "joints.right_elbow.origin.x",
        "cuts.tip.b.x",
        "actuators.left_shoulder",
        "actuators.right_shoulder",
        "tool.z",
    )
    matrix = found.sensitivity.matrix
    assert np.allclose(matrix[:, 3:5], chain.tool(chain.home).frame_jacobian, atol=1e-12)
    assert np.allclose(found.worst, np.abs(matrix) @ [1e-4, 1e-4, 1.5e-4, 2e-4, 2e-4, 0.0])
    assert np.allclose(found.errors.std(axis=0), found.sigma, rtol=0.03, atol=1e-12)
    assert np.allclose(np.cov(found.errors.T)[:3, :3], found.covariance[:3, :3], atol=0.05 * found.covariance.max())
    assert (np.abs(found.errors) <= found.worst * 1.5 + 1e-15).all()
    ranked = found.ranked
    assert np.isclose(sum(one.share for one in ranked), 1.0)
    assert [one.share for one in ranked] == sorted((one.share for one in ranked), reverse=True)
    assert found.within(50.0)[0] < found.within(95.0)[0] < found.within(100.0)[0]
    assert 0.0 < found.nonlinear[0] < 1e-2 * found.sigma[:3].max()
    again = accuracy(chain, tolerances, samples=40_000, seed=3)
    assert np.array_equal(found.errors, again.errors)


@pytest.mark.slow
def test_loops_closed_anew_agree_with_the_law() -> None:
    chain = cutjoint.load("omega3")
    tolerances = {f"cuts.ball{k}a.b.z = cuts.ball{k}b.b.z": 1e-4 for k in (1, 2, 3)}
    tolerances |= {"joints.bar*.origin.x": 1e-4, "tool.*": 1e-4, "actuators.arm2": 1e-4}
    linear, exact = (accuracy(chain, tolerances, samples=2000, exact=one) for one in (False, True))
    assert exact.exact
    off = np.linalg.norm((linear.errors - exact.errors)[:, :3], axis=1).max()
    assert 0.0 < off < 20.0 * linear.nonlinear[0]
    assert off < 1e-3 * np.linalg.norm(exact.errors[:, :3], axis=1).max()
    for k in (0, 7, 1999):  # against chains built anew
        draws = np.linalg.lstsq(linear.sensitivity.matrix, linear.errors[k], rcond=None)[0]
        assert np.allclose(linear.sensitivity.matrix @ draws, linear.errors[k], atol=1e-12)
    with pytest.raises(CompileError, match="ball1a"):
        accuracy(chain, {"cuts.ball1a.b.z": 1e-4}, exact=True)


def test_what_is_wrong_is_told() -> None:
    chain = cutjoint.load("fivebar")
    for names, kind, told in (
        (["cuts.tpi.b.x"], UnknownNameError, "cuts.tip.b.x"),
        (["links.left_distal.mass"], InputError, "does not say where the tool is"),
        (["actuators.left"], UnknownNameError, "left_shoulder"),
        (["tool.x", "tool.x = tool.y", "tool.x"], InputError, "two tolerances"),
        (["tool.x = tool.roll"], InputError, "different kinds"),
        (["tool.x = tool.xyz"], InputError, "not as many"),
        ([""], UnknownNameError, "unknown number"),
        ([3], InputError, "found"),
    ):
        with pytest.raises(kind, match=told):
            sensitivity(chain, names)  # type: ignore[arg-type]
    for tolerances, told in (
        ({}, "no tolerance is given"),
        ({"tool.x": -1.0}, ">= 0"),
        ({"tool.x": "1"}, "a Deviation"),
        ({"tool.x": 1.0, "tool.x = tool.y": 1.0}, "two tolerances"),
        ({"tool.*": 1.0, "*.x": 1.0}, "two tolerances"),
    ):
        with pytest.raises(InputError, match=told):
            accuracy(chain, tolerances)  # type: ignore[arg-type]
    with pytest.raises(ActuationError, match="moves while its actuators hold"):
        sensitivity(cutjoint.load("underactuated"), ["tool.x"])
    with pytest.raises(InputError, match="no samples"):
        accuracy(chain, {"tool.x": 1e-4}, samples=0).within()


# ---- warmth and backlash -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [pytest.param("omega3", marks=pytest.mark.slow), "cpm", "fivebar", "stewart"])
def test_a_robot_that_is_warm_all_over_is_the_same_robot_larger(name: str) -> None:
    chain = mounted(name, 5)
    at = near(chain, 6)
    found = growth(chain, {"*": 10.0}, {"*": "steel"}, at)
    place = chain.link_placements(at)
    assert chain.description.tool is not None
    tool = (place[chain.description.tool.link] @ chain.description.tool.placement)[:3, 3]
    assert np.allclose(found.shift, [*(10.0 * 11.7e-6 * tool), 0.0, 0.0, 0.0], atol=1e-15)


def test_what_grows_warm_is_told_by_part() -> None:
    chain = cutjoint.load("fivebar")
    found = growth(
        chain, {"left*": 5.0, "right_distal": 20.0, "left_distal": 0.0}, {"left*": 1e-5, "right*": "aluminium"}
    )
    assert found.names == ("left_proximal", "left_distal", "right_distal")
    assert found.warmth.tolist() == [5.0, 0.0, 20.0]
    assert np.allclose(found.parts[:, 1], 0.0)
    length = value(chain.description, "joints.left_elbow.origin.x")
    slope = sensitivity(chain, ["joints.left_elbow.origin.x"]).matrix[:, 0]
    assert np.allclose(found.parts[:, 0], slope * 5e-5 * length, atol=1e-15)
    for warm, expansion, kind in (
        ({"none": 1.0}, "steel", UnknownNameError),
        ({"*": 1.0}, "steal", UnknownNameError),
        ({"*": 1.0}, {"left*": 1e-5}, InputError),
        ({}, "steel", InputError),
        ({"base": float("nan")}, "steel", InputError),
    ):
        with pytest.raises(kind):
            growth(chain, warm, expansion)  # type: ignore[arg-type]


@pytest.mark.parametrize("name", [pytest.param("omega3", marks=pytest.mark.slow), "cpm", "fivebar"])
def test_backlash_is_the_image_of_a_box(name: str) -> None:
    chain = mounted(name, 7)
    at, rng = near(chain, 8), np.random.default_rng(8)
    halves = rng.uniform(1e-4, 1e-3, chain.n)
    found = backlash(chain, dict(zip([one.name for one in chain.actuators], halves.tolist(), strict=True)), at)
    jacobian = chain.tool(at).frame_jacobian
    assert np.allclose(found.parts, jacobian * halves, atol=1e-12)
    assert np.allclose(found.box, np.abs(jacobian) @ halves, atol=1e-12)
    inside = (jacobian @ (rng.uniform(-1.0, 1.0, (500, chain.n)) * halves).T)[:3]
    assert (np.linalg.norm(inside, axis=0) <= found.furthest[0] * (1.0 + 1e-9)).all()
    assert np.isclose(np.linalg.norm(found.corners[:, :3], axis=1).max(), found.furthest[0])


def test_more_actuators_than_freedoms_are_at_odds() -> None:
    found = backlash(cutjoint.load("redundant"), {"*": 1e-3})
    assert found.parts.shape == (6, 3)
    assert found.furthest[0] > 0.0


# ---- files ---------------------------------------------------------------------------------------------------------

FILE = """
[tolerances]
"cuts.tip.b.x" = "0.1 mm"
"joints.*.origin.yaw" = { sigma = "0.01 deg" }
"tool.z" = { within = 5e-5 }
[backlash]
"*" = "1 arcmin"
[warm]
left_distal = "15 K"
[expansion]
"*" = "aluminium"
"""


def test_a_file_says_it_all(tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(FILE)
    robot = load_description("fivebar")
    found = errors_from_file(tmp_path / "x.toml", robot)
    assert found.tolerances["cuts.tip.b.x"] == Deviation(0.1 * 1e-3)
    yaw = found.tolerances["joints.*.origin.yaw"]
    assert yaw.normal
    assert np.isclose(yaw.size, np.deg2rad(0.01))
    assert found.backlash["*"] == pytest.approx(np.pi / 10800)
    assert found.warm == {"left_distal": 15.0}
    assert not found.empty
    for text, kind in (
        ("[tolerance]\n'tool.x' = 1", InputError),
        ("[tolerances]\n'tool.x' = '1 deg'", InputError),
        ("[tolerances]\n'tool.*' = '1 mm'", InputError),
        ("[tolerances]\n'tool.x' = { sgma = 1 }", InputError),
        ("[tolerances]\n'tool.x' = { sigma = 1, within = 1 }", InputError),
        ("[backlash]\nleft = 1", InputError),
        ("[warm]\n'*' = '1 deg'", InputError),
        ("[expansion]\n'*' = true", InputError),
    ):
        (tmp_path / "x.toml").write_text(text)
        with pytest.raises(kind):
            errors_from_file(tmp_path / "x.toml", robot)
