"""Working and assembly modes of the shipped robots and of small ones: what they hold, that they differ, their order,
and the number of them against closed forms."""

from __future__ import annotations

import pickle
from collections.abc import Sequence
from dataclasses import FrozenInstanceError, replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain, Modes
from cutjoint.chain.modes import limits as starts_module
from cutjoint.chain.modes.limits import JointLimits, Starts
from cutjoint.chain.modes.search import TIMES, Tally
from cutjoint.chain.structure import independent_parts
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Limits,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Posture
from cutjoint.papers.cpm import CpmModel
from cutjoint.papers.omega3 import Omega3Model

Z = readonly([0.0, 0.0, 1.0])
# working modes, assembly modes, those with the limbs told apart
COUNTS = {
    "cpm": (8, 1, 8),
    "omega3": (8, 2, 2),
    "fivebar": (4, 2, 2),
    "fourbar": (1, 2, 2),
    "redundant": (8, 1, 1),
}


def links(chain: ClosedChain, at: Posture) -> np.ndarray:
    """Placements of all links with lengths in characteristic ones, shape (links, 4, 4)."""
    placed = np.array(list(chain.link_placements(at).values()))
    placed[:, :3, 3] /= chain.length
    return placed


def tool(chain: ClosedChain, at: Posture) -> np.ndarray:
    """World placement of the tool, shape (4, 4)."""
    frame = chain.description.tool
    return chain.link_placements(at)[frame.link] @ frame.placement


def same_set(chain: ClosedChain, one: Sequence[Posture], two: Sequence[Posture]) -> bool:
    """Whether two lists hold the same postures, in any order."""
    a, b = (np.array([links(chain, at) for at in each]) for each in (one, two))
    apart = np.abs(a[:, None] - b[None]).reshape(len(a), len(b), -1).max(axis=2)
    return len(a) == len(b) and bool((apart.min(axis=0) < 1e-5).all() and (apart.min(axis=1) < 1e-5).all())


LISTS: dict[str, tuple[Modes, Modes, Modes]] = {}


def modes_at_home(name: str, kit: Any) -> tuple[Modes, Modes, Modes]:
    """Working modes, assembly modes and those with the limbs told apart, searched once for all tests."""
    if name not in LISTS:
        chain = kit.robot(name)
        LISTS[name] = chain.working_modes(), chain.assembly_modes(), chain.assembly_modes(limbs=True)
    return LISTS[name]


@pytest.mark.parametrize("name", COUNTS)
def test_counts_of_the_shipped_robots(name: str, kit: Any) -> None:
    lists = modes_at_home(name, kit)
    assert tuple(len(modes) for modes in lists) == COUNTS[name]
    for modes in lists:
        assert modes.settled
        assert modes.unseen == 0.0
        assert min(modes.found) >= TIMES
        assert modes.loose == 0
        assert len(modes.found) == len(modes)


@pytest.mark.parametrize("name", COUNTS)
def test_every_mode_is_closed_and_allowed_holds_what_it_should_and_differs_from_the_others(name: str, kit: Any) -> None:
    chain, lists = kit.robot(name), modes_at_home(name, kit)
    if name == "fivebar":
        away = kit.random_states(chain, 1, seed=5, reach=0.1)[0].at
        lists = (*lists, chain.working_modes(away), chain.assembly_modes(away, limbs=True))
    for modes in lists:
        at = modes[0]
        assert name == "fivebar" or np.array_equal(at.q_full, chain.home.q_full)
        assert np.array_equal(modes[0].q_full, at.q_full)
        for mode in modes:
            assert max(mode.gap) < 1e-12
            assert not chain.limit_violations(mode)
            if modes.held == "actuators":
                np.testing.assert_allclose(mode.q, at.q, atol=1e-11)
            else:
                np.testing.assert_allclose(tool(chain, mode)[:3, 3], tool(chain, at)[:3, 3], atol=1e-11)
        for one, two in combinations(modes, 2):
            assert np.abs(links(chain, one) - links(chain, two)).max() > 1e-3


@pytest.mark.parametrize("name", ["cpm", "fivebar", pytest.param("omega3", marks=pytest.mark.slow)])
def test_from_any_mode_come_the_same_modes(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    working, _, assembly = modes_at_home(name, kit)
    assert same_set(chain, working, chain.working_modes(working[-1]))
    assert same_set(chain, assembly, chain.assembly_modes(assembly[-1], limbs=True))


@pytest.mark.parametrize("name", ["fivebar", pytest.param("omega3", marks=pytest.mark.slow)])
def test_the_list_is_the_same_whatever_the_starts_and_sorted_by_distance(
    name: str, kit: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    chain = kit.robot(name)
    lists = [modes_at_home(name, kit)[0]]
    np.testing.assert_array_equal([at.q_full for at in chain.working_modes()], [at.q_full for at in lists[0]])
    for seed in (1, 2):
        monkeypatch.setattr(starts_module, "SEED", seed)
        lists.append(chain.working_modes())
        np.testing.assert_allclose([at.q_full for at in lists[-1]], [at.q_full for at in lists[0]], atol=1e-8)
    assert len({modes.found for modes in lists}) > 1
    away = [np.linalg.norm(_moving(chain, at) - _moving(chain, chain.home)) for at in lists[0]]
    assert (np.diff(away) > -1e-4).all()


def _moving(chain: ClosedChain, at: Posture) -> np.ndarray:
    """Placements of the moving bodies, which joints carry, (joints, 12)."""
    pinocchio = pytest.importorskip("pinocchio")
    data = chain.model.createData()
    pinocchio.forwardKinematics(chain.model, data, at.q_full)
    return np.array([np.r_[p.translation / chain.length, p.rotation.ravel()] for p in list(data.oMi)[1:]])


def test_the_published_models_have_the_same_modes(kit: Any) -> None:
    """Closed forms of both papers."""
    omega3, delta = kit.robot("omega3"), Omega3Model()
    at = omega3.reach(delta.tool(delta.home).position + np.array([0.01, -0.015, 0.02]))
    wanted = np.array([np.exp(1j * one.q) for one in delta.working_modes(omega3.tool(at).position)])
    found = np.array([np.exp(1j * one.q) for one in omega3.working_modes(at)])
    points = np.array([tool(omega3, one)[:3, 3] for one in omega3.assembly_modes(at)])
    others = np.array([delta.tool(one).position for one in delta.assembly_modes(at.q)])
    for one, two in ((found, wanted), (points, others)):
        apart = np.abs(one[:, None] - two[None]).max(axis=2)
        assert apart.min(axis=0).max() < 1e-9
        assert apart.min(axis=1).max() < 1e-9
    assert len(modes_at_home("cpm", kit)[0]) == len(CpmModel().working_modes(CpmModel().home.q))


def test_a_five_bar_counts_all_limbs_wherever_the_tools_frame_sits(kit: Any) -> None:
    """Both limbs in closed form: an elbow is where two circles meet.  On whichever distal link the tool sits, even
    askew, its point says where the robot is."""
    description = kit.robot("fivebar").description
    tip = placement((0.25, 0.0, 0.0))
    for frame in (Frame("left_distal", tip), Frame("right_distal", placement((0.25, 0.0, 0.0), (0.4, -0.2, 1.0)))):
        chain = ClosedChain(replace(description, tool=frame))
        for state in kit.random_states(chain, 1, seed=3):
            modes = chain.working_modes(state.at)
            assert modes.held == "point"
            assert len(modes) == 4
            places = [chain.link_placements(at) for at in modes]
            for side in ("left", "right"):
                base = places[0][f"{side}_proximal"][:3, 3]
                point = tool(chain, state.at)[:3, 3]
                elbows = np.array([one[f"{side}_distal"][:3, 3] for one in places])
                r, d = np.linalg.norm(elbows[0] - base), np.linalg.norm(elbows[0] - point)
                across = point - base
                along = (across @ across + r**2 - d**2) / (2.0 * (across @ across))
                height = np.sqrt(r**2 - along**2 * (across @ across)) / np.linalg.norm(across)
                aside = height * np.array([across[2], 0.0, -across[0]])
                wanted = np.array([base + along * across + sign * aside for sign in (1.0, -1.0)])
                apart = np.linalg.norm(elbows[:, None] - wanted[None], axis=2)
                assert apart.min(axis=1).max() < 1e-9
                assert [(apart[:, i] < 1e-9).sum() for i in (0, 1)] == [2, 2]


def test_the_pose_is_held_on_demand(kit: Any) -> None:
    chain = kit.robot("fivebar")
    modes = chain.working_modes(hold="pose")
    assert (len(modes), modes.held) == (2, "pose")
    for mode in modes:
        np.testing.assert_allclose(tool(chain, mode), tool(chain, chain.home), atol=1e-11)
    delta = kit.robot("omega3")
    assert same_set(delta, delta.working_modes(hold="pose"), modes_at_home("omega3", kit)[0])
    with pytest.raises(InputError, match="'point' or 'pose'"):
        chain.working_modes(hold="axis")


def test_limits_leave_modes_out_and_bound_turns(kit: Any) -> None:
    description = kit.robot("fivebar").description
    home = kit.robot("fivebar").home
    elbow = home.q_full[kit.robot("fivebar").model.idx_qs[kit.robot("fivebar").model.getJointId("left_elbow")]]

    def limited(lower: float, upper: float) -> ClosedChain:
        joints = tuple(
            replace(one, limits=replace(one.limits, lower=lower, upper=upper)) if one.name == "left_elbow" else one
            for one in description.joints
        )
        return ClosedChain(replace(description, joints=joints))

    assert elbow < 0.0
    assert len(limited(-np.pi, 0.0).working_modes()) == 2
    turned = limited(-np.pi, 2.0 * np.pi).working_modes()
    assert len(turned) == 4, "an angle and the same one a turn on are one mode"
    chain = limited(elbow - 0.1, elbow - 0.1 + 2.0 * np.pi)
    modes = chain.working_modes()
    assert len(modes) == 4
    assert not any(chain.limit_violations(one) for one in modes)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
@pytest.mark.parametrize("name", ["fivebar", pytest.param("omega3", marks=pytest.mark.slow)])
def test_size_and_mounting_change_nothing(name: str, factor: float, kit: Any) -> None:
    chain = ClosedChain(_grown(kit.robot(name).description, factor, placement((0.3, -0.2, 0.1), (0.7, -0.4, 2.0))))
    assert (len(chain.working_modes()), len(chain.assembly_modes())) == COUNTS[name][:2]


def _grown(description: RobotDescription, factor: float, mounting: np.ndarray) -> RobotDescription:
    def scaled(matrix: np.ndarray) -> np.ndarray:
        larger = np.array(matrix)
        larger[:3, 3] *= factor
        return larger

    def joint(one: Joint) -> Joint:
        place = scaled(one.placement)
        return replace(one, placement=scaled(mounting) @ place if one.parent == description.root else place)

    def frame(one: Frame) -> Frame:
        return Frame(one.link, scaled(one.placement))

    def inertial(one: Inertial) -> Inertial:
        return Inertial(one.mass, factor * one.com, factor**2 * one.inertia)

    def home(one: Home) -> Home:
        kinds = {each.name: each.type for each in description.joints}
        mounted = {}
        for name, value in one.passive.items():
            if kinds[name] is JointType.FLOATING:
                # the joint's frame is mounted with its parent, so its coordinates are as before, but longer
                value = (*(factor * np.array(value[:3])).tolist(), *value[3:])
            mounted[name] = value
        return replace(one, passive=mounted)

    return replace(
        description,
        links=tuple(replace(one, inertial=one.inertial and inertial(one.inertial)) for one in description.links),
        joints=tuple(joint(one) for one in description.joints),
        cuts=tuple(replace(one, a=frame(one.a), b=frame(one.b)) for one in description.cuts),
        tool=frame(description.tool),
        homes=tuple(home(one) for one in description.homes),
    )


@pytest.mark.parametrize(("ratio", "count"), [(2.0, 2), (-3.0, 3), (1.0, 1), (0.5, 1), (1.5, 3)])
def test_gears_count_the_turns_that_differ(ratio: float, count: int) -> None:
    """The tool's wheel holds b, so the other, b = ratio a, stands at one of as many angles as its turns allow."""
    chain = ClosedChain(
        RobotDescription(
            "gear",
            (Link("base"), Link("one"), Link("two")),
            (
                Joint("a", JointType.CONTINUOUS, "base", "one", axis=Z),
                Joint("b", JointType.CONTINUOUS, "base", "two", placement((0.3, 0.0, 0.0)), axis=Z),
            ),
            (),
            couplings=(Coupling.geared("mesh", "b", "a", ratio, 0.1),),
            actuators=("a",),
            tool=Frame("two", placement((0.1, 0.0, 0.0))),
            homes=(Home("default", {"a": 0.3}, {"b": 0.1 + 0.3 * ratio}),),
        )
    )
    modes = chain.working_modes()
    assert len(modes) == count
    assert modes.settled
    turns = np.exp(1j * np.array([at.q[0] for at in modes]) * count)
    np.testing.assert_allclose(turns, turns[0], atol=1e-9)


def slider_crank(kit: Any, tool_link: str = "slider") -> RobotDescription:
    """With a rod between two balls, which spins about itself."""
    rod, plate = kit.body(0.2, (0.1, 0.0, 0.0), 3), kit.body(1.0, (0.0, 0.0, 0.0), 4)
    return RobotDescription(
        "slider-crank",
        (Link("base"), Link("crank", kit.body(0.3)), Link("rod", rod), Link("slider", plate)),
        (
            Joint("crank", JointType.REVOLUTE, "base", "crank", axis=Z),
            Joint("ball", JointType.SPHERICAL, "crank", "rod", placement((0.1, 0.0, 0.0))),
            Joint("slide", JointType.PRISMATIC, "base", "slider", axis=readonly([1.0, 0.0, 0.0])),
        ),
        (CutJoint("end", CutType.SPHERICAL, Frame("rod", placement((0.3, 0.0, 0.0))), Frame("slider")),),
        actuators=("crank",),
        tool=Frame(tool_link),
        homes=(Home("default", {"crank": 1.0}, {"slide": 0.34, "ball": (0.0, 0.0, -1.28)}),),
    )


@pytest.mark.parametrize("with_tool", [True, False])
def test_postures_that_differ_by_an_idle_spin_are_one_mode(with_tool: bool, kit: Any) -> None:
    """Of a rod between balls: two cranks reach the slider, and two sliders the crank."""
    description = slider_crank(kit)
    chain = ClosedChain(description if with_tool else replace(description, tool=None))
    modes = chain.assembly_modes()
    assert len(modes) == 2
    assert modes.settled
    slides = sorted(at.q_full[-1] for at in modes)
    half = np.sqrt(0.3**2 - (0.1 * np.sin(1.0)) ** 2)
    np.testing.assert_allclose(slides, 0.1 * np.cos(1.0) + np.array([-half, half]), atol=1e-12)
    if with_tool:
        working = chain.working_modes()
        assert len(working) == 2
        np.testing.assert_allclose(sorted(at.q[0] for at in working), [-1.0, 1.0], atol=1e-9)


def test_robots_without_a_tool_have_assembly_modes_of_all_their_links(kit: Any) -> None:
    """Two five-bars on one base, independent: two modes each, four together."""
    one = replace(kit.robot("fivebar").description, tool=None)
    assert len(ClosedChain(one).assembly_modes()) == 2
    links_, joints, cuts = list(one.links), list(one.joints), list(one.cuts)
    root = one.root

    def other(name: str) -> str:
        return name if name == root else f"other_{name}"

    links_ += [replace(link, name=other(link.name)) for link in one.links if link.name != root]
    joints += [
        replace(each, name=f"other_{each.name}", parent=other(each.parent), child=other(each.child))
        for each in one.joints
    ]
    cuts += [
        replace(
            each,
            name=f"other_{each.name}",
            a=Frame(other(each.a.link), each.a.placement),
            b=Frame(other(each.b.link), each.b.placement),
        )
        for each in one.cuts
    ]
    homes = tuple(
        Home(
            home.name,
            {**home.actuated, **{f"other_{key}": value for key, value in home.actuated.items()}},
            {**home.passive, **{f"other_{key}": value for key, value in home.passive.items()}},
        )
        for home in one.homes
    )
    actuators = (*one.actuators, *(f"other_{name}" for name in one.actuators))
    both = replace(one, links=tuple(links_), joints=tuple(joints), cuts=tuple(cuts), actuators=actuators, homes=homes)
    chain = ClosedChain(both)
    modes = chain.assembly_modes()
    assert len(modes) == 4
    assert modes.settled


def test_parts_are_the_limbs(kit: Any) -> None:
    """With the tool's pose held, the joints of different limbs do not know of each other."""
    from cutjoint.chain.closing.drivers import PoseDriver

    for name, sizes in (("cpm", [4, 4, 4]), ("omega3", [1, 4, 4, 4]), ("stewart", [1, 3, 3, 3, 3, 3, 3])):
        chain = kit.robot(name)
        place = chain._postures.at_home.tool
        parts = independent_parts(chain._k, PoseDriver(place), chain._k.tool_support, [], chain.home.q_full)
        assert sorted(len(part) for part in parts) == sizes
        assert sorted(joint for part in parts for joint in part) == list(range(1, chain.model.njoints))


def test_modes_that_are_not_discrete_are_refused(kit: Any) -> None:
    description = kit.robot("stewart").description
    chain = ClosedChain(replace(description, cuts=description.cuts[:5]))
    with pytest.raises(ActuationError, match="tool's pose held") as caught:
        chain.working_modes()
    assert (caught.value.mobility, caught.value.free) == (1, ("leg6_slide",)), "its hinges swing idly"
    with pytest.raises(ActuationError, match="actuators held") as caught:
        kit.robot("underactuated").assembly_modes()
    assert caught.value.mobility == 1
    assert set(caught.value.free) == {"left", "load", "right"}
    with pytest.raises(InputError, match="no cut joints"):
        ClosedChain(replace(kit.robot("fivebar").description, cuts=())).working_modes()
    with pytest.raises(InputError, match="no tool"):
        ClosedChain(replace(kit.robot("fivebar").description, tool=None)).working_modes()


@pytest.mark.parametrize("starts", [0, -3, 1.5, True, "many", None])
def test_starts_are_a_whole_number(starts: object, kit: Any) -> None:
    for search in (kit.robot("fivebar").working_modes, kit.robot("fivebar").assembly_modes):
        with pytest.raises(InputError, match=r"starts.* must be a whole number"):
            search(starts=starts)


def test_a_search_that_is_cut_short_says_so(kit: Any) -> None:
    chain = kit.robot("omega3")
    modes = chain.assembly_modes(starts=1)
    assert not modes.settled
    assert modes.unseen == 1.0
    assert modes.found[0] <= 1
    assert modes.starts == 1
    assert np.array_equal(modes[0].q_full, chain.home.q_full)


def test_modes_are_a_sequence_that_does_not_change(kit: Any) -> None:
    modes = kit.robot("fivebar").working_modes()
    assert isinstance(modes, Modes)
    assert isinstance(modes, Sequence)
    assert list(modes) == [modes[i] for i in range(len(modes))] == list(modes.postures)
    assert modes[-1] is modes[len(modes) - 1]
    assert modes[1:3] == (modes[1], modes[2])
    assert modes[2] in modes
    assert next(reversed(modes)) is modes[-1]
    with pytest.raises(IndexError):
        modes[len(modes)]
    with pytest.raises(FrozenInstanceError):
        modes.unseen = 0.5
    with pytest.raises(TypeError):
        modes[0] = modes[1]
    copy = pickle.loads(pickle.dumps(modes))
    assert copy.found == modes.found
    np.testing.assert_array_equal([at.q_full for at in copy], [at.q_full for at in modes])


def test_the_estimate_of_what_is_unseen_is_right_on_average() -> None:
    """Species of known frequency: the share of the next finds that are new, against Good's and Turing's estimate."""
    rng = np.random.default_rng(0)
    chances = 1.0 / np.arange(1, 41)
    chances /= chances.sum()
    estimates, truths = [], []
    for _ in range(300):
        tally, seen = Tally(), set()
        for kind in rng.choice(len(chances), size=60, p=chances):
            shape = np.array([float(kind)])
            index = tally.find(shape)
            tally.count(tally.add(shape, shape) if index is None else index)
            seen.add(int(kind))
        estimates.append(tally.unseen)
        truths.append(1.0 - chances[list(seen)].sum())
    assert np.mean(estimates) == pytest.approx(np.mean(truths), rel=0.05)
    assert Tally().unseen == 1.0


def test_a_tally_is_settled_when_all_that_is_allowed_was_found_several_times() -> None:
    tally = Tally()
    good, bad = tally.add(np.zeros(1), np.zeros(1)), tally.add(np.ones(1), np.ones(1), allowed=False)
    tally.count(bad)
    for _ in range(TIMES - 1):
        tally.count(good)
        assert not tally.settled(1)
    tally.count(good)
    assert tally.settled(TIMES + 1)
    assert not tally.settled(TIMES + 2)
    assert tally.unseen == 0.0
    assert tally.find(np.full(1, 1e-9)) == good
    assert tally.find(np.full(1, 1e-3)) is None


def test_starts_are_anywhere_that_the_joints_can_be() -> None:
    """Every joint type: within limits, over a whole turn, uniform on SO(3), around the robot; other joints stay."""
    x = readonly([1.0, 0.0, 0.0])
    at = placement((0.2, 0.0, 0.0))
    kinds = {
        "limited": (JointType.REVOLUTE, Limits(-0.3, 1.2)),
        "wide": (JointType.REVOLUTE, Limits(-9.0, 2.0)),
        "turning": (JointType.CONTINUOUS, Limits()),
        "slide": (JointType.PRISMATIC, Limits(0.1, 0.7)),
        "long": (JointType.PRISMATIC, Limits(0.1, None)),
        "ball": (JointType.SPHERICAL, Limits()),
        "cross": (JointType.UNIVERSAL, Limits()),
        "flat": (JointType.PLANAR, Limits()),
        "free": (JointType.FLOATING, Limits()),
    }
    chain = ClosedChain(
        RobotDescription(
            "all joints",
            (Link("base"), *(Link(f"link {name}") for name in kinds)),
            tuple(
                Joint(
                    name, kind, "base", f"link {name}", at, axis=x if kind is JointType.UNIVERSAL else Z, limits=limits
                )
                for name, (kind, limits) in kinds.items()
            ),
            (),
            homes=(Home("default", {}, {"slide": 0.3, "long": 0.2, "limited": 0.1}),),
        )
    )
    model, q = chain.model, chain.home.q_full
    starts = Starts(chain._k, JointLimits(chain._k, q), q)
    drawn = np.array([starts.draw(range(1, model.njoints), q) for _ in range(4000)])
    where = {name: slice(model.idx_qs[j], model.idx_qs[j] + model.nqs[j]) for j, name in enumerate(model.names)}

    def spread(name: str, index: int = 0) -> tuple[float, float]:
        values = drawn[:, where[name]][:, index]
        assert np.histogram(values, 8)[0].min() > 350, "uniform"
        return float(values.min()), float(values.max())

    assert spread("limited") == pytest.approx((-0.3, 1.2), abs=0.01)
    low, high = spread("wide")
    assert (high - low, high <= 2.0) == (pytest.approx(2.0 * np.pi, abs=0.02), True)
    assert spread("turning") == pytest.approx((-np.pi, np.pi), abs=0.02)
    assert spread("slide") == pytest.approx((0.1, 0.7), abs=0.01)
    assert spread("long")[0] == pytest.approx(0.1, abs=0.01)
    for index in (0, 1):
        assert spread("cross", index) == pytest.approx((-np.pi, np.pi), abs=0.02)
    for name, start in (("ball", 0), ("free", 3)):
        quaternions = drawn[:, where[name]][:, start:]
        np.testing.assert_allclose(np.linalg.norm(quaternions, axis=1), 1.0, atol=1e-12)
        np.testing.assert_allclose(quaternions.T @ quaternions / len(drawn), np.eye(4) / 4.0, atol=0.02)
    flat = drawn[:, where["flat"]]
    np.testing.assert_allclose(np.hypot(flat[:, 2], flat[:, 3]), 1.0, atol=1e-12)
    np.testing.assert_allclose(flat[:, 2:].T @ flat[:, 2:] / len(drawn), np.eye(2) / 2.0, atol=0.03)
    for name, count in (("flat", 2), ("free", 3)):
        assert all(high - low > 2.0 * chain.length for low, high in (spread(name, index) for index in range(count)))
    one = starts.draw([model.getJointId("ball")], q)
    changed = np.flatnonzero(one != q)
    assert where["ball"].start <= changed.min()
    assert changed.max() < where["ball"].stop


def test_whole_turns_are_turned_back(kit: Any) -> None:
    """Each angle comes as near to the one asked about as its limits allow."""
    chain = kit.robot("fivebar")
    q = chain.home.q_full
    turns = 2.0 * np.pi * np.array([1.0, -1.0, 2.0, 0.0])
    np.testing.assert_allclose(JointLimits(chain._k, q).turned_back(q + turns), q, atol=1e-12)


@pytest.mark.slow
def test_places_that_the_limbs_cannot_reach_within_their_limits_are_no_modes(kit: Any) -> None:
    """The Stewart platform upside down under its base solves the equations, with its legs turned over."""
    chain = kit.robot("stewart")
    modes = chain.assembly_modes()
    assert not any(chain.limit_violations(at) for at in modes)
    assert all(tool(chain, at)[2, 3] > 0.0 for at in modes)
    assert len(modes) == 4
