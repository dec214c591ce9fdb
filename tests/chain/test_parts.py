"""The parts of a chain, each alone, and the tables that tell them what types of joints and cuts are."""

from __future__ import annotations

import re
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cutjoint import tolerances
from cutjoint.arrays import readonly
from cutjoint.chain.bound import BoundCoupling
from cutjoint.chain.build import build_model, rough_home
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.closing import Closing
from cutjoint.chain.closing.equations import SMALL, WELL, System
from cutjoint.chain.closing.ways import Ways
from cutjoint.chain.joints import JOINTS, angles, coordinates_to_q, travelling, type_of, velocity_scale
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.postures import Actuated, Postures
from cutjoint.chain.reduced import ReducedDynamics
from cutjoint.description import load_description
from cutjoint.description.curves import Polynomial
from cutjoint.description.model import CutJoint, CutType, Frame, Joint, JointType, Link, RobotDescription
from cutjoint.errors import InputError
from cutjoint.robots import load

CHAIN = Path(load.__code__.co_filename).parent / "chain"
MOVING = [kind for kind in JointType if kind.moves]


# ---- types of joints ------------------------------------------------------------------------------------------------


def one_joint(kind: JointType, axis: np.ndarray) -> RobotDescription:
    across = np.cross(axis, [0.3, 0.5, 0.1])
    joint = Joint("joint", kind, "base", "link", axis=readonly(axis), axis2=readonly(across / np.linalg.norm(across)))
    return RobotDescription("one", (Link("base"), Link("link")), (joint,))


@pytest.mark.parametrize("axis", [(1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.6, 0.8), (-1.0, 0.0, 0.0)])
@pytest.mark.parametrize("kind", MOVING)
def test_a_row_is_right_about_its_joint(kind: JointType, axis: tuple[float, ...]) -> None:
    """Sizes, lengths, homes and random starts of every type, against Pinocchio's own model of the joint."""
    description = one_joint(kind, np.array(axis))
    model, random = build_model(description), np.random.default_rng(0)
    assert type_of(model, 1).lengths == kind.lengths
    assert model.nv == kind.dof
    assert velocity_scale(model, 7.0).tolist() == [7.0 if one else 1.0 for one in kind.lengths]
    value = tuple(random.uniform(-1.0, 1.0, kind.dof))
    home = coordinates_to_q(description.joints[0], value)
    starts = [home]
    anywhere, middle = JOINTS[kind].anywhere, np.array([3.0, -2.0, 1.0])
    if anywhere is not None:
        starts += [anywhere(random, middle, 0.5) for _ in range(20)]
    placements = Kinematics(description)
    for q in starts:
        assert q.shape == (model.nq,)
        np.testing.assert_allclose(Kinematics(description).tree.normalised(q), q, atol=1e-14)
    count = sum(kind.lengths)
    for q in starts[1:]:  # lengths come first, and the frame of a planar joint is turned to its axis
        assert np.abs(q[:count] - middle[:count]).max(initial=0.0) <= 0.5
    assert travelling(model).tolist() == (list(range(count)) if count > 1 else [])
    for index in angles(model):
        turned = home.copy()
        turned[index] += 2.0 * np.pi
        np.testing.assert_allclose(
            placements.world.links(turned)["link"], placements.world.links(home)["link"], atol=1e-14
        )
    moved = home.copy()
    moved[travelling(model)] += 1.0
    apart = placements.world.links(moved)["link"] - placements.world.links(home)["link"]
    np.testing.assert_allclose(apart[:3, :3], 0.0, atol=1e-14)
    assert np.linalg.norm(apart[:3, 3]) == pytest.approx(np.sqrt(len(travelling(model))))


def test_every_type_that_moves_has_a_row() -> None:
    assert list(JOINTS) == MOVING


# ---- types of cuts --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", CutType)
def test_rows_of_a_cut_are_those_of_its_equations(kind: CutType) -> None:
    axis = readonly([0.0, 0.0, 1.0])
    joint = Joint("arm", JointType.CONTINUOUS, "base", "link", axis=axis)
    cut = CutJoint("cut", kind, Frame("base"), Frame("link"), length=0.5 if kind.has_length else 0.0)
    closure = Kinematics(RobotDescription("one", (Link("base"), Link("link")), (joint,), (cut,))).closure
    assert closure.row_names == tuple(f"cut.{label}" for label in kind.labels)
    lengths = [equation.is_length for equation in kind.equations for _ in equation.labels]
    assert closure.is_length.tolist() == lengths
    assert closure.all_rows == kind.rows == len(lengths)


def test_a_coupling_of_three_coordinates() -> None:
    """A differential: two wheels and the casing between them."""
    one = BoundCoupling(
        "differential", (0, 4, 2), (0, 3, 1), (Polynomial((0.0, -0.5)), Polynomial((0.0, 2.0))), -0.25, False, True
    )
    q = np.array([1.0, 9.0, 3.0, 9.0, -4.0])
    assert one.residual(q) == 1.0 - 2.0 - 6.0 + 0.25
    np.testing.assert_array_equal(one.row(q, 5), [1.0, -2.0, 0.0, 0.5, 0.0])


# ---- parts alone ----------------------------------------------------------------------------------------------------


def test_parts_make_a_chain_without_its_face() -> None:
    """Each is built from those before it alone, and answers as the robot does."""
    description, robot = load_description("fivebar"), load("fivebar")
    k, actuated = Kinematics(description), Actuated(build_model(description), description)
    rough, _ = rough_home(k.model, description, None)
    at_home = assembled(k, rough, actuated.hold(rough))
    postures = Postures(k, actuated, at_home)
    mobility = Mobility(postures)
    closing, reduced = Closing(mobility, Ways(mobility)), ReducedDynamics(mobility)
    np.testing.assert_array_equal(postures.home.q_full, robot.home.q_full)
    target = robot.home.q + 0.1
    at = closing.close(target, None, "respect")
    np.testing.assert_array_equal(at.q_full, robot.close(target).q_full)
    assert mobility.report(postures.placed(at)) == robot.mobility(at)
    np.testing.assert_array_equal(reduced.terms(at, None).mass, robot.terms(at).mass)
    assert actuated.show(target) == ", ".join(
        f"{one.name} {value:.6g} {one.unit}" for one, value in zip(robot.actuators, target, strict=True)
    )
    with pytest.raises(InputError, match="a posture is wanted"):
        postures.placed(at.q_full)  # type: ignore[arg-type]


def test_newton_ends_where_nothing_is_left_to_gain(kit: Any) -> None:
    """A hundredth of the tolerance after a small step, a thousandth after any, or below it where steps do no more."""
    chain = kit.robot("fivebar")
    here = System(chain._k, None).at(chain._k.at(np.array(chain.home.q_full)))
    assert here.openness < 1.0
    for openness, last, motion, wanted in (
        (0.9 * WELL, inf, inf, True),
        (2.0 * WELL, inf, inf, False),
        (2.0 * WELL, inf, 0.9 * SMALL, True),
        (2.0 * WELL, inf, 1.1 * SMALL, False),
        (20.0 * WELL, inf, 0.0, False),
        (0.9, 8.0, inf, True),
        (0.9, 10.0, inf, False),
        (1.1, 1.1, inf, False),
    ):
        assert here._replace(openness=openness).is_closed(last, motion) is wanted
    unit = here.system.scales.closed
    assert unit is not None
    lengths = np.where(chain._k.closure.is_length, chain._k.reach, 1.0)
    np.testing.assert_allclose(1.0 / unit, tolerances.CLOSURE.value * lengths, rtol=1e-15)


# ---- one place for each ---------------------------------------------------------------------------------------------

ONE_PLACE = {
    r"\.shortname\(|JointModel[A-Z]": {"joints.py"},
    r"CutType\.[A-Z]": set(),
    r"JointType\.[A-Z]": {"joints.py"},
    r"pin\.(rnea|aba|crba|compute\w+|forwardKinematics|center\w+|nonLinear\w+|integrate|difference|normalize)\(": {
        "tree.py",
        "rigid.py",
        "collisions.py",
    },
    r"\b(?:k|kinematics|tree)\.data\b": set(),
}
"""What is written in these modules alone."""


@pytest.mark.parametrize("pattern", ONE_PLACE)
def test_pinocchio_and_the_tables_are_asked_in_one_place(pattern: str) -> None:
    files = list(CHAIN.rglob("*.py"))
    assert len(files) > 30
    code = {file: re.sub(r'"""(.|\n)*?"""', "", file.read_text(encoding="utf-8")) for file in files}
    assert {file.name for file, text in code.items() if re.search(pattern, text)} == ONE_PLACE[pattern]
