"""Stiffness at the tool against robots whose loops are solved anew in equilibrium, and against laws."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from kit import curved, mechanisms
from kit.blueprint import random_mounting, random_rotation
from kit.sized import Size

import cutjoint
from cutjoint import ClosedChain, Load
from cutjoint.description import load_description
from cutjoint.description.model import CutType, Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, DynamicsError, InputError, UnknownNameError
from cutjoint.mechanism import Posture
from cutjoint.mechanism.rotations import vector_of
from cutjoint.stiffness import Beam, ElasticRobot, Springs, stiffness

Array = np.ndarray
SIXTH = ((1.0, 45.0 / 60.0), (2.0, -9.0 / 60.0), (3.0, 1.0 / 60.0))


class Balanced:
    """An elastic robot whose equilibrium is solved for, from the potential energy of its soft chain, by nothing of
    `cutjoint.stiffness` but which joints are soft and how hard.

    At the posture without strain the springs carry what the weights and standing loads ask for with the least energy.
    """

    def __init__(self, elastic: ElasticRobot, at: Posture, loads: list[Load]) -> None:
        self.soft, self.loads = ClosedChain(elastic.description), loads
        self.start = elastic.placed(at).q
        nv = self.soft.nv
        self.matrix = np.zeros((nv, nv))
        for give in elastic.gives:
            where = [int(self.soft.model.idx_vs[self.soft.model.getJointId(name)]) for name in give.joints]
            self.matrix[np.ix_(where, where)] = give.matrix
        driven = [name for name in elastic.chain.description.actuators if name not in elastic.springs.actuators]
        driven = [] if "*" in elastic.springs.actuators else driven
        held = [int(self.soft.model.idx_vs[self.soft.model.getJointId(name)]) for name in driven]
        self.free = np.setdiff1d(np.arange(nv), held)
        rows = self.soft.constraint_jacobian(self.start)[:, self.free]
        system = np.block(
            [[self.matrix[np.ix_(self.free, self.free)], rows.T], [rows, np.zeros((len(rows), len(rows)))]]
        )
        given = np.concatenate([-self.pull(self.start, loads)[self.free], np.zeros(len(rows))])
        solved = np.linalg.lstsq(system, given, rcond=1e-13)[0]
        strain = np.zeros(nv)
        strain[self.free] = solved[: len(self.free)]
        self.first, self.multipliers = self.matrix @ strain, solved[len(self.free) :]

    def pull(self, q: Array, loads: list[Load]) -> Array:
        """Slope of the potential energy, less the loads."""
        slope = np.zeros(self.soft.nv)
        for k, one in enumerate(np.eye(self.soft.nv)):
            for many, weight in SIXTH:
                step = 0.02 * many * one
                sides = [self.soft.potential_energy(self.soft.integrate(q, sign * step)) for sign in (1.0, -1.0)]
                slope[k] += weight / 0.02 * (sides[0] - sides[1])
        return slope - self.soft.full_load_effort(q, loads)

    def strain(self, q: Array) -> Array:
        """Coordinates of what is soft; others are not looked at."""
        found = np.zeros(self.soft.nv)
        for joint in range(1, self.soft.model.njoints):
            if self.soft.model.nvs[joint] == 1:
                index = int(self.soft.model.idx_vs[joint])
                found[index] = q[self.soft.model.idx_qs[joint]] - self.start[self.soft.model.idx_qs[joint]]
        return found

    def tool(self, further: Array) -> tuple[Array, Array]:
        """Place and axes of the tool in equilibrium under a further wrench (6,) at it."""
        q, multipliers = self.start, self.multipliers
        loads = [*self.loads, Load(further[:3], further[3:])]
        free = self.free
        for _ in range(80):
            rows = self.soft.constraint_jacobian(q)[:, free]
            force = self.pull(q, loads) + self.matrix @ self.strain(q) + self.first
            left = np.concatenate([force[free] + rows.T @ multipliers, self.soft.constraint_residual(q)])
            count = len(rows)
            system = np.block([[self.matrix[np.ix_(free, free)], rows.T], [rows, np.zeros((count, count))]])
            step = np.linalg.lstsq(system, -left, rcond=1e-13)[0]
            motion = np.zeros(self.soft.nv)
            motion[free] = step[: len(free)]
            q, multipliers = self.soft.integrate(q, motion), multipliers + step[len(free) :]
            if np.abs(motion).max() < 3e-14:
                break
        else:
            pytest.fail(f"no equilibrium: {np.abs(motion).max()}")
        assert self.soft.description.tool is not None
        link = self.soft.link_placements(q)[self.soft.description.tool.link]
        there = link @ self.soft.description.tool.placement
        return there[:3, 3], there[:3, :3]

    def compliance(self, sizes: tuple[float, float]) -> Array:
        """By differences of equilibria under small forces [N] and moments [N m] of these sizes."""
        columns = []
        for k, one in enumerate(np.eye(6)):
            h = sizes[k // 3]
            ends = [self.tool(many * h * one) for many in (1.0, -1.0, 2.0, -2.0)]
            axes = self.tool(np.zeros(6))[1]
            moves = [np.concatenate([place, vector_of(turn @ axes.T)]) for place, turn in ends]
            columns.append((8.0 * (moves[0] - moves[1]) - (moves[2] - moves[3])) / (12.0 * h))
        return np.array(columns).T


def agree(elastic: ElasticRobot, at: Posture, loads: list[Load], tolerance: float = 1e-6) -> None:
    found = elastic.at(at, loads)
    length = elastic.chain.length
    softness = np.abs(found.compliance[:3, :3]).max(), np.abs(found.compliance[3:, 3:]).max()
    sizes = 3e-4 * length / softness[0], 3e-4 / softness[1]
    wanted = Balanced(elastic, at, loads).compliance(sizes)
    scale = np.array([1.0 / length] * 3 + [1.0] * 3)
    for given, other in ((found.compliance, wanted), (found.parts.sum(axis=0), wanted)):
        even = scale[:, None] * (given - other) / scale
        assert np.abs(even).max() < tolerance * np.abs(scale[:, None] * other / scale).max()


def turned(name: str, seed: int) -> ClosedChain:
    rng = np.random.default_rng(seed)
    size = Size(rotation=random_rotation(rng), offset=rng.normal(size=3), gravity=1.0)
    robot = size.of(load_description(name))
    return ClosedChain(replace(robot, gravity=9.81 * random_rotation(rng)[2]))


def near(chain: ClosedChain, seed: int) -> Posture:
    change = 0.05 * np.random.default_rng(seed).uniform(-1.0, 1.0, chain.n)
    slides = np.array([one.kind == "translation" for one in chain.actuators])
    return chain.close(chain.home.q + change * np.where(slides, chain.length, 1.0))


def some_load(seed: int, size: float) -> list[Load]:
    rng = np.random.default_rng(seed)
    return [Load(size * rng.normal(size=3)), Load(size * rng.normal(size=3), point=0.05 * rng.normal(size=3))]


def test_equilibria_of_a_five_bar_anywhere() -> None:
    chain = turned("fivebar", 1)
    springs = Springs({"*": 60.0}, {"tip.x": 2e4, "tip.rx": 900.0, "left_elbow.z": 3e4}, {})
    agree(ElasticRobot(chain, springs), near(chain, 2), some_load(3, 4.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "springs", "size"),
    [
        ("fivebar", Springs({"*": 200.0}, {"*": 5e4}), 5.0),
        ("fourbar", Springs({"*": 100.0}, {"crank": 3e4, "coupler_to_rocker": 1e5}, {"coupler_link": 4e4}), 5.0),
        ("fourbar", Springs({"*": 100.0}, {}, {"*_link": Beam.tube(2e9, 1e9, 0.014)}), 1.0),
        ("redundant", Springs({"*": 300.0}, {"tip*": 2e5, "*_shoulder": 1e5}), 5.0),
        ("cpm", Springs({"*": 2e4}, {"*_elbow": 1e5, "*_to_platform": 3e5}), 30.0),
        ("cpm_rotary", Springs({}, {"*_shoulder": 1e5, "*_wrist": 3e5}), 30.0),
        ("omega3", Springs({"*": 500.0}, {"ball*": 1e6}, {"rod*_link": 3e5}), 5.0),
        ("stewart", Springs({"*": 4e4}, {"ball*": 1e6}), 50.0),
    ],
)
def test_equilibria_of_shipped_robots(name: str, springs: Springs, size: float) -> None:
    chain = turned(name, 4)
    at = chain.home if name == "redundant" else near(chain, 5)
    agree(ElasticRobot(chain, springs), at, some_load(6, size))


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [mechanisms.ups_6, mechanisms.planar_3rrr, mechanisms.prs_3, curved.rod_delta, curved.rssr]
)
def test_equilibria_of_random_mechanisms(make: object, tmp_path: Path) -> None:
    rng = np.random.default_rng(12)
    plan = make(rng).plan  # type: ignore[operator]
    chain = ClosedChain(load_description(plan.write(tmp_path, random_mounting(rng))))
    weight = 9.81 * sum(one.inertial.mass for one in chain.description.links if one.inertial)
    soft = 30.0 * weight / chain.length
    slides = {one.name for one in chain.actuators if one.kind == "translation"}
    drives = {one.name: soft * (1.0 if one.name in slides else chain.length**2) for one in chain.actuators}
    rods = {cut.name: 5.0 * soft for cut in chain.description.cuts if cut.type is CutType.DISTANCE}
    bearings = {cut.name: 5.0 * soft for cut in chain.description.cuts if cut.type is not CutType.DISTANCE}
    agree(ElasticRobot(chain, Springs(drives, bearings, rods)), chain.home, [])


# ---- laws ----------------------------------------------------------------------------------------------------------


def lying(name: str) -> ClosedChain:
    return ClosedChain(replace(load_description(name), gravity=np.zeros(3)))


@pytest.mark.parametrize("name", ["fivebar", "omega3", "cpm", "stewart"])
def test_actuators_alone_give_by_the_jacobian(name: str) -> None:
    """C = J K^-1 J' where nothing pulls."""
    chain = lying(name)
    at, rng = near(chain, 7), np.random.default_rng(7)
    hard = rng.uniform(1e3, 1e6, chain.n)
    names = [one.name for one in chain.actuators]
    found = stiffness(chain, Springs(dict(zip(names, hard.tolist(), strict=True))), at)
    jacobian = chain.tool(at).frame_jacobian
    wanted = jacobian @ np.diag(1.0 / hard) @ jacobian.T
    assert np.abs(found.compliance - wanted).max() < 1e-11 * np.abs(wanted).max()
    assert found.stable
    load = rng.normal(size=6)
    parts = found.contributions(load)
    assert np.isclose(sum(one.share for one in parts), 1.0)
    assert np.allclose(sum(one.deflection for one in parts), found.deflection(load), rtol=1e-12)
    for one in parts:
        if one.kind == "actuator":
            k = names.index(one.name)
            moved = jacobian[:, k] * (jacobian[:, k] @ load) / hard[k]
            assert np.allclose(one.deflection, moved, atol=1e-12 * np.abs(moved).max())


def test_a_rigid_direction_is_told() -> None:
    found = stiffness(lying("cpm"), Springs({"*": 1e5}))
    assert np.isinf(found.rotation.stiffness).all()
    assert np.allclose(found.translation.stiffness, 1e5)
    assert np.isclose(found.along([0.0, 0.0, 2.0]), 1e5)
    turning = found.contributions([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    assert not found.deflection([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]).any()
    assert all(one.share == 0.0 for one in turning)
    with pytest.raises(InputError, match="rigid in 3 of 6 directions"):
        _ = found.matrix
    whole = stiffness(lying("stewart"), Springs({"*": 1e5}))
    assert np.allclose(whole.matrix @ whole.compliance, np.eye(6), atol=1e-9)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_size_and_mounting_do_not_matter(factor: float) -> None:
    """A robot of another size is as stiff in its own units: [N/m] by weight over length, [N m/rad] by their product."""
    rng = np.random.default_rng(9)
    size = Size(factor, 7.0, 0.3, random_rotation(rng), factor * rng.normal(size=3))
    one = load_description("fivebar")
    chains = ClosedChain(one), ClosedChain(size.of(one))
    force = size.mass * size.gravity
    found = []
    for chain, k in zip(chains, (1.0, force / factor), strict=True):
        turn = k * (1.0 if k == 1.0 else factor**2)
        springs = Springs({"*": 80.0 * turn}, {"tip.y": 5e3 * k, "left_elbow.rx": 300.0 * turn})
        load = Load(3.0 * (1.0 if k == 1.0 else force) * (np.eye(3) if k == 1.0 else size.rotation)[:, 0])
        found.append(stiffness(chain, springs, loads=load).compliance)
    turned_back = np.kron(np.eye(2), size.rotation)
    units = np.array([factor] * 3 + [1.0] * 3)
    wanted = (turned_back @ found[0] @ turned_back.T) * units[:, None] * units / (force * factor)
    assert (
        np.abs((found[1] - wanted) / units[:, None] / units).max()
        < 1e-9 * np.abs(wanted / units[:, None] / units).max()
    )


def arm(parts: int = 1, gravity: float = 0.0) -> RobotDescription:
    """A horizontal rod of 0.4 m on a motor, of one piece or of several that are fixed to each other."""
    links, joints = [Link("base")], []
    for k in range(parts):
        kind = JointType.FIXED if k else JointType.REVOLUTE
        joints.append(Joint(f"j{k}", kind, links[-1].name, f"rod{k}", placement([0.4 / parts if k else 0.0, 0.0, 0.0])))
        links.append(Link(f"rod{k}", Inertial(0.1)))
    end = Joint("end", JointType.SPHERICAL, links[-1].name, "tip", placement([0.4 / parts, 0.0, 0.0]))
    return RobotDescription(
        "arm",
        (*links, Link("tip")),
        (*(replace(one, axis=np.array([0.0, 1.0, 0.0])) for one in joints), end),
        actuators=("j0",),
        tool=Frame(links[-1].name, placement([0.4 / parts, 0.0, 0.0])),
        gravity=np.array([0.0, 0.0, -gravity]),
    )


def test_a_beam_bends_as_in_the_handbook() -> None:
    """F L^3 / 3 E I and F L^2 / 2 E I at the end of a clamped beam, L / E A along it, L / G J about it."""
    young, shear, outer, inner = 7e10, 2.6e10, 0.02, 0.016
    tube = Beam.tube(young, shear, outer, inner)
    second, area = np.pi / 64 * (outer**4 - inner**4), np.pi / 4 * (outer**2 - inner**2)
    found = stiffness(ClosedChain(arm()), Springs(rods={"rod0": tube})).compliance
    wanted = np.zeros((6, 6))
    bend = 0.4 / (young * second)
    wanted[0, 0], wanted[3, 3] = 0.4 / (young * area), 0.4 / (shear * 2.0 * second)
    for across, about, sign in ((1, 5, 1.0), (2, 4, -1.0)):
        wanted[across, across], wanted[about, about] = bend * 0.4**2 / 3.0, bend
        wanted[across, about] = wanted[about, across] = sign * bend * 0.4 / 2.0
    assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()


def test_bearings_at_several_places_add_up() -> None:
    """A tool on a chain of bodies gives by the sum of what each joint gives, at its own arm."""
    whole = ClosedChain(arm(4))
    found = stiffness(whole, Springs(joints={"j1.ry": 50.0, "j2.ry": 80.0, "j3.z": 1e4}))
    arms = np.array([0.3, 0.2])
    assert np.isclose(found.compliance[2, 2], (arms**2 / [50.0, 80.0]).sum() + 1e-4)
    assert np.isclose(found.compliance[4, 4], (1.0 / np.array([50.0, 80.0])).sum())


def test_frames_of_links_do_not_matter_to_what_is_as_hard_all_around() -> None:
    """A driven joint whose axis is none of its child's frame gives across it alone."""
    turn = random_rotation(np.random.default_rng(5))
    plain = replace(
        arm(), joints=(arm().joints[0],), links=arm().links[:2], tool=Frame("rod0", placement([0.4, 0.1, 0.0]))
    )
    hinge = plain.joints[0]
    child = np.eye(4)
    child[:3, :3] = turn
    assert plain.tool is not None
    oblique = replace(
        plain,
        joints=(replace(hinge, placement=hinge.placement @ child, axis=turn.T @ hinge.axis),),
        tool=Frame("rod0", child.T @ plain.tool.placement),
    )
    for springs in (Springs(joints={"j0": 1e4}), Springs({"j0": 700.0}, {"j0": 1e4})):
        wanted, found = (stiffness(ClosedChain(one), springs).compliance for one in (plain, oblique))
        assert np.abs(found - wanted).max() < 1e-12 * np.abs(wanted).max()
    with pytest.raises(InputError, match="all around by one number"):
        stiffness(ClosedChain(oblique), Springs(joints={"j0.rx": 1e4}))


def test_weight_softens_what_stands_on_a_spring() -> None:
    """An arm with its mass above (below) the hinge of a spring: k - m g h, and not stable when that is negative."""
    for sign, hard, stable in ((1.0, 5.0, True), (-1.0, 5.0, True), (1.0, 0.1, False)):
        robot = arm()
        body = Inertial(1.0, np.array([0.0, 0.0, sign * 0.1]))
        robot = replace(
            robot, links=(robot.links[0], Link("rod0", body), robot.links[2]), gravity=np.array([0, 0, -9.81])
        )
        found = stiffness(ClosedChain(robot), Springs({"j0": hard}))
        assert np.isclose(found.compliance[4, 4], 1.0 / (hard - sign * 0.981), rtol=1e-9)
        assert found.stable is stable


def test_a_distance_gives_along_its_rod(tmp_path: Path) -> None:
    """Two springs one after the other: as soft as their sum."""
    rng = np.random.default_rng(3)
    plan = curved.rod_delta(rng).plan
    chain = ClosedChain(replace(load_description(plan.write(tmp_path)), gravity=np.zeros(3)))
    rods = [cut.name for cut in chain.description.cuts if cut.type is CutType.DISTANCE]
    once = stiffness(chain, Springs(rods=dict.fromkeys(rods, 1e5))).compliance
    twice = stiffness(chain, Springs(rods=dict.fromkeys(rods, 5e4))).compliance
    assert np.allclose(twice, 2.0 * once, atol=1e-9 * np.abs(twice).max())


def test_what_is_wrong_is_told() -> None:
    chain = cutjoint.load("fivebar")
    for springs, kind, told in (
        (Springs(), InputError, "nothing of fivebar gives way"),
        (Springs({"left": 1.0}), UnknownNameError, "left_shoulder"),
        (Springs(joints={"tpi.x": 1.0}), UnknownNameError, "did you mean 'tip'"),
        (Springs(joints={"tip.rz": 1.0}), InputError, "moves freely along rz"),
        (Springs(joints={"tip.x": [1.0] * 6}), InputError, "is one number, found six"),
        (Springs(joints={"tip": 1.0, "tip.x": 1.0}), InputError, "given twice"),
        (Springs({"left*": 1.0, "*_shoulder": 1.0}), InputError, "given twice"),
        (Springs(rods={"base": 1.0}), InputError, "is the base"),
        (Springs(rods={"tool": 1.0}), InputError, "no rod"),
    ):
        with pytest.raises(kind, match=told):
            stiffness(chain, springs)
    for wrong in (
        {"actuators": {"*": -1.0}},
        {"rods": {"a": 0.0}},
        {"joints": {"a": [1.0, 2.0]}},
        {"joints": {"a": "x"}},
    ):
        with pytest.raises(InputError):
            Springs(**wrong)  # type: ignore[arg-type]
    with pytest.raises(DynamicsError, match="cannot rest here"):
        stiffness(cutjoint.load("underactuated"), Springs({"*": 1e5}))
    with pytest.raises(InputError, match="they jam"):  # a rod of a pair shifted along the other
        stiffness(cutjoint.load("omega3"), Springs({"*": 1e4}, {"ball1a.y": 1e5}))
    free = replace(load_description("fivebar"), actuators=("left_shoulder",), gravity=np.zeros(3), task=())
    with pytest.raises(ActuationError, match="nothing resists"):
        stiffness(ClosedChain(free), Springs({"*": 1e5}))


def test_exact_names_go_before_patterns_and_infinity_is_rigid() -> None:
    chain = lying("fivebar")
    some = stiffness(chain, Springs({"*": 1e3, "left_shoulder": 5e3}, {"tip": np.inf}))
    same = stiffness(chain, Springs({"right_shoulder": 1e3, "left_shoulder": 5e3}))
    assert np.array_equal(some.compliance, same.compliance)


def test_loads_on_links_deflect_the_tool_too() -> None:
    chain = lying("fivebar")
    elastic = ElasticRobot(chain, Springs({"*": 1e3}, {"tip": 1e6}))
    assert chain.description.tool is not None
    force = np.array([1.0, -2.0, 3.0])
    point = chain.tool(chain.home).position
    link = "left_distal"
    place = chain.link_placements(chain.home)[link]
    at_link = Load(force, link=link, point=place[:3, :3].T @ (point - place[:3, 3]))
    wanted = elastic.at().deflection([*force, 0.0, 0.0, 0.0])
    assert np.allclose(elastic.deflection(at_link), wanted, atol=1e-12 * np.abs(wanted).max())
    pushed = elastic.pushed(at_link)
    parts = {one.name: one for one in elastic.at().contributions([*force, 0.0, 0.0, 0.0])}
    assert {one.name for one in pushed.parts} == parts.keys()
    for one in pushed.parts:
        assert np.isclose(one.share, parts[one.name].share, atol=1e-9)
        assert np.allclose(one.deflection, parts[one.name].deflection, atol=1e-9 * np.abs(wanted).max())
    elsewhere = elastic.pushed([Load([0.0, 0.0, -5.0], link="right_proximal"), Load([1.0, 0.0, 0.0], link=link)])
    assert np.isclose(sum(one.share for one in elsewhere.parts), 1.0)
    assert np.allclose(sum(one.deflection for one in elsewhere.parts), elsewhere.deflection, rtol=1e-9)
