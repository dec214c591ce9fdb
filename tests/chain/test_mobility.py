"""Mobility and redundancy, counted at many postures."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from kit.quickly import few

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import kinematic_problems
from cutjoint.chain.rank import dependent_rows, null_space, rank_of
from cutjoint.description import catalogue
from cutjoint.description.model import (
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
from cutjoint.description.transforms import placement
from cutjoint.errors import ActuationError, CutjointError, SingularError

# velocities, rows, rank, mobility, actuators
EXPECTED = {
    "cpm": (12, 12, 9, 3, 3),
    "cpm_rotary": (12, 12, 9, 3, 3),
    "omega3": (18, 18, 15, 3, 3),
    "fourbar": (3, 5, 2, 1, 1),
    "fivebar": (4, 5, 2, 2, 2),
    "stewart": (24, 18, 18, 6, 6),
    "redundant": (6, 10, 4, 2, 3),
    "underactuated": (4, 5, 2, 2, 1),
}


@pytest.mark.parametrize("name", catalogue.names())
def test_counts_are_those_of_the_mechanism(name: str, kit: Any) -> None:
    chain = kit.robot(name)
    for state in [None, *kit.random_states(chain, 6)]:
        report = chain.mobility(None if state is None else state.at)
        found = (report.velocities, report.rows, report.rank, report.mobility, report.actuators)
        if name in EXPECTED:
            assert found == EXPECTED[name]
        assert report.mobility == report.velocities - report.rank
        assert len(report.redundant_rows) == report.rows - report.rank
        names = {cut.name for cut in chain.description.cuts} | {one.name for one in chain.description.couplings}
        assert all(any(row.startswith(cut) for cut in names) for row in report.redundant_rows)
        assert report.determined == (report.mobility == report.actuators and not report.free)
        assert max(report.gap) < 1e-12
        if report.determined:
            assert report.type2 > 1e-3
            assert report.type1 > 1e-3
            assert report.condition >= 1.0 - 1e-12
        else:
            assert np.isnan(report.type1)


def test_redundant_rows_can_go(kit: Any) -> None:
    """The other rows have full rank, and the redundant ones add none."""
    for name in catalogue.names():
        chain = kit.robot(name)
        jacobian = chain.constraint_jacobian(chain.home)
        gone = dependent_rows(chain._k.at(chain.home.q_full).scaled)
        kept = np.setdiff1d(np.arange(len(jacobian)), gone)
        assert np.linalg.matrix_rank(jacobian[kept], tol=1e-7) == len(kept) == chain.mobility().rank


@pytest.mark.parametrize("name", few(["cpm", "omega3"], "cpm"))
def test_three_hundred_reachable_postures_have_three_degrees_of_freedom(name: str, kit: Any) -> None:
    chain, rng = kit.robot(name), np.random.default_rng(0)
    home, done = chain.tool(chain.home).position, 0
    for _ in range(5000):
        if done == 300:
            break
        try:
            near = chain.reach(home + (0.2 if name == "cpm" else 0.035) * rng.uniform(-1, 1, 3), limits="ignore")
        except CutjointError:
            continue
        jacobian = chain.constraint_jacobian(near)
        values = np.linalg.svd(jacobian, compute_uv=False)
        rank = EXPECTED[name][2]
        assert values[rank] < 1e-9 * values[0], "three rows are redundant"
        report = chain.mobility(near)
        if report.type2 < 1e-4:
            continue
        done += 1
        assert (report.mobility, report.rank, report.rows) == (3, rank, EXPECTED[name][1])
        assert len(report.redundant_rows) == 3
    assert done == 300


def test_too_few_motors_leave_named_joints_free(kit: Any) -> None:
    report = kit.robot("underactuated").mobility()
    assert not report.determined
    assert set(report.free) == {"left", "load", "right"}
    limp = replace(kit.robot("cpm").description, actuators=("limb1_slide", "limb2_slide"))
    homes = tuple(
        replace(home, actuated={k: v for k, v in home.actuated.items() if k != "limb3_slide"}) for home in limp.homes
    )
    chain = ClosedChain(replace(limp, homes=homes))
    report = chain.mobility()
    assert (report.mobility, report.actuators, report.determined) == (3, 2, False)
    assert "limb3_slide" in report.free
    with pytest.raises(ActuationError, match="limb3_slide"):
        chain.tangent(chain.home)


def test_motors_that_depend_on_each_other(kit: Any) -> None:
    """As many as the mobility, yet they do not determine the motion: two on one geared pair of joints."""
    description = kit.robot("omega3").description
    wrong = replace(description, actuators=("rod1a", "rod1b", "arm1"), homes=())
    home = description.homes[0]
    both = {**home.actuated, **home.passive}
    homes = (
        replace(
            home,
            actuated={name: both[name] for name in wrong.actuators},
            passive={name: value for name, value in both.items() if name not in wrong.actuators},
        ),
    )
    chain = ClosedChain(replace(wrong, homes=homes))
    report = chain.mobility()
    assert (report.mobility, report.actuators) == (3, 3)
    assert not report.determined
    assert report.free
    with pytest.raises(ActuationError, match="3"):
        chain.terms(chain.home)


def test_idle_joints_do_not_move_the_tool(kit: Any) -> None:
    """A slider-crank whose rod has two ball joints: the rod spins about itself."""
    rod, plate = kit.body(0.2, (0.1, 0.0, 0.0), 3), kit.body(1.0, (0.0, 0.0, 0.0), 4)
    chain = ClosedChain(
        RobotDescription(
            "slider-crank",
            (Link("base"), Link("crank", kit.body(0.3)), Link("rod", rod), Link("slider", plate)),
            (
                Joint("crank", JointType.REVOLUTE, "base", "crank", axis=readonly([0.0, 0.0, 1.0])),
                Joint("ball", JointType.SPHERICAL, "crank", "rod", placement((0.1, 0.0, 0.0))),
                Joint("slide", JointType.PRISMATIC, "base", "slider", axis=readonly([1.0, 0.0, 0.0])),
            ),
            (CutJoint("end", CutType.SPHERICAL, Frame("rod", placement((0.3, 0.0, 0.0))), Frame("slider")),),
            actuators=("crank",),
            tool=Frame("slider"),
            homes=(Home("default", {"crank": 1.0}, {"slide": 0.34, "ball": (0.0, 0.0, -1.28)}),),
        )
    )
    report = chain.mobility()
    assert (report.mobility, report.actuators, report.determined) == (2, 1, True)
    assert report.free == report.idle == ("ball",)
    assert report.idle_mobility == 1
    at = chain.close([1.3])
    assert at.q_full[-1] == pytest.approx(0.1 * np.cos(1.3) + np.sqrt(0.3**2 - (0.1 * np.sin(1.3)) ** 2), abs=1e-12)


def test_motors_that_the_loops_hold_are_not_called_redundant(kit: Any) -> None:
    """A triangle of hinges beside a rod that spins between two balls: nothing but the spin moves."""

    def at(link: str, x: float, y: float) -> Frame:
        return Frame(link, placement((x, y, 0.0)))

    robot = RobotDescription(
        "held",
        (Link("base"), *(Link(name, kit.body(0.3)) for name in ("a", "b", "rod"))),
        (
            Joint("motor", JointType.REVOLUTE, "base", "a", axis=readonly([0.0, 0.0, 1.0])),
            Joint("knee", JointType.REVOLUTE, "a", "b", placement((0.3, 0.0, 0.0)), axis=readonly([0.0, 0.0, 1.0])),
            Joint("ball", JointType.SPHERICAL, "base", "rod", placement((0.0, 1.0, 0.0))),
        ),
        (
            CutJoint(
                "foot",
                CutType.REVOLUTE,
                Frame("b", placement((0.3, 0.0, 0.0))),
                Frame("base", placement((0.4, 0.0, 0.0))),
            ),
            CutJoint(
                "end",
                CutType.SPHERICAL,
                Frame("rod", placement((0.2, 0.0, 0.0))),
                Frame("base", placement((0.2, 1.0, 0.0))),
            ),
        ),
        actuators=("motor",),
        homes=(Home("default", {"motor": float(np.arccos(2 / 3))}, {"knee": -1.68}),),
    )
    problems, chain = kinematic_problems(robot)
    assert chain is not None
    report = chain.mobility()
    assert (report.mobility, report.idle_mobility, report.idle, report.determined) == (1, 1, ("ball",), False)
    assert "they cannot move: the loops hold them" in str(report)
    assert "redundant actuation" not in str(report)
    assert "the tool stays" not in str(report)
    assert [one for one in problems if "the actuators cannot move" in one.found]
    assert not [one for one in problems if "depend on each other" in one.found]


def test_rank_and_null_space() -> None:
    rng = np.random.default_rng(1)
    for rows, columns, rank in ((5, 7, 3), (7, 5, 3), (4, 4, 4), (3, 6, 0), (0, 4, 0)):
        matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
        assert rank_of(matrix) == rank
        basis = null_space(matrix)
        assert basis.shape == (columns, columns - rank)
        np.testing.assert_allclose(basis.T @ basis, np.eye(columns - rank), atol=1e-12)
        assert np.abs(matrix @ basis).max(initial=0.0) < 1e-12
        assert len(dependent_rows(matrix)) == rows - rank


def test_rounding_of_a_cad_program_is_redundancy_and_real_motion_is_not() -> None:
    rng = np.random.default_rng(2)
    matrix = rng.normal(size=(6, 4)) @ rng.normal(size=(4, 8))
    assert rank_of(matrix + 1e-10 * rng.normal(size=(6, 8))) == 4
    assert rank_of(matrix + 1e-3 * rng.normal(size=(6, 8))) == 6
    assert len(dependent_rows(matrix + 1e-10 * rng.normal(size=(6, 8)))) == 2


def test_condition_and_distance_scale_with_nothing(kit: Any) -> None:
    """A robot twice as large is as near to its singularities."""

    def grown(matrix: np.ndarray, factor: float) -> np.ndarray:
        larger = np.array(matrix)
        larger[:3, 3] *= factor
        return larger

    description = kit.robot("fivebar").description
    for factor in (0.01, 2.0, 50.0):
        large = replace(
            description,
            links=tuple(
                replace(one, inertial=Inertial(i.mass, factor * i.com, factor**2 * i.inertia))
                if (i := one.inertial)
                else one
                for one in description.links
            ),
            joints=tuple(replace(one, placement=grown(one.placement, factor)) for one in description.joints),
            cuts=tuple(
                replace(
                    one,
                    a=Frame(one.a.link, grown(one.a.placement, factor)),
                    b=Frame(one.b.link, grown(one.b.placement, factor)),
                )
                for one in description.cuts
            ),
        )
        one, two = kit.robot("fivebar").mobility(), ClosedChain(large).mobility()
        assert (two.type1, two.type2, two.condition) == pytest.approx((one.type1, one.type2, one.condition), rel=1e-9)


def test_singular_postures_have_type1_zero(kit: Any) -> None:
    """A stretched limb of the five-bar: the tool cannot move along it."""
    chain = kit.robot("fivebar")
    q = np.array(chain.home.q_full)
    left = chain.model.idx_qs[chain.model.getJointId("left_elbow")]
    values = []
    for elbow in (-0.3, -0.1, -0.03, -0.01):
        q[left] = elbow
        try:
            at = chain.assemble(q, keep_actuators=False)
        except (CutjointError, SingularError):
            continue
        values.append((abs(np.sin(at.q_full[left])), chain.mobility(at).type1))
    assert len(values) >= 2
    for (bend, type1), (next_bend, next_type1) in pairwise(values):
        assert (next_bend < bend) == (next_type1 < type1)
