"""Which type a cut at a pair of frames is: told from the axes of the joints of its loop, judged by the mobility.

- Where all joints of the loop turn about parallel axes or slide across them, the loop is planar: a hinge about the
  normal (`revolute`) takes nothing away that a ball would leave.
- Otherwise the frames are held at a point (`spherical`), unless their z axes lie along each other and a hinge there
  leaves the same mobility, or leaves some and the frames are turned about that axis against each other: nobody puts
  them so but for a hinge.
- Frames that cannot be brought together may slide along each other (`prismatic`).
- What else is possible is shown with the mobility that would come out, and is for the user to choose.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.findings import usual_mobility
from cutjoint.description.model import CutJoint, CutType, Frame, RobotDescription
from cutjoint.description.transforms import frame_along, from_rotation
from cutjoint.drafting.cutting.closing import closed, with_cuts
from cutjoint.drafting.cutting.pairs import SAME_DIRECTION, Pair, between
from cutjoint.drafting.cutting.tree import Tree

TURNED = 1e-3
"""Angle [rad] beyond which frames with one z axis are turned against each other."""


@dataclass(frozen=True)
class TypeChoice:
    """A type that a cut may have, and what the robot would come to.

    Attributes:
        type: of the cut.
        closes: whether the loops close with it.
        mobility, redundant: of the whole robot then, at nearly every posture around home; -1 where it does not close.
    """

    type: str
    closes: bool
    mobility: int
    redundant: int


def loose_cut(pair: Pair) -> CutJoint:
    """The pair held together at a point, which all types but a distance hold too."""
    return CutJoint(pair.name, CutType.SPHERICAL, Frame(pair.a), Frame(pair.b))


def sliding_cut(pair: Pair) -> CutJoint:
    """The pair as a slide along the z axes of its frames."""
    return CutJoint(pair.name, CutType.PRISMATIC, Frame(pair.a), Frame(pair.b))


def choices_of(chain: ClosedChain, pair: Pair) -> tuple[list[CutJoint], list[TypeChoice]]:
    """The cuts that a pair may be, the proposed one first, and what each comes to.

    Args:
        chain: closed, with the pair held at a point, or as a slide.
        pair: of its frames.
    """
    held = next(one for one in chain.description.cuts if one.name == pair.name)
    if held.type is CutType.PRISMATIC:
        return [held], [_choice(chain.description, held, chain)]
    robot, placed = chain.description, chain.link_placements(chain.home)
    normal = planar_normal(Tree(robot), pair, placed)
    axis = normal if normal is not None else _shared_axis(pair, placed)
    cuts = [loose_cut(pair)]
    if axis is not None:
        a, b = (_along(link, placed[link], axis) for link in (pair.a, pair.b))
        cuts.append(CutJoint(pair.name, CutType.REVOLUTE, a, b))
    cuts.append(CutJoint(pair.name, CutType.UNIVERSAL, Frame(pair.a), Frame(pair.b)))
    cuts.append(CutJoint(pair.name, CutType.FIXED, Frame(pair.a), Frame(pair.b)))
    tried = [(cut, _choice(robot, cut, chain)) for cut in cuts]
    loose = tried[0][1]
    hinge = next((i for i, (cut, _) in enumerate(tried) if cut.type is CutType.REVOLUTE), None)
    if hinge is not None and tried[hinge][1].closes:
        meant = between(placed[pair.a], placed[pair.b])[1] > TURNED and tried[hinge][1].mobility > 0
        if meant or tried[hinge][1].mobility == loose.mobility:
            tried.insert(0, tried.pop(hinge))
    return [cut for cut, _ in tried], [choice for _, choice in tried]


def planar_normal(tree: Tree, pair: Pair, placed: Mapping[str, Array]) -> Array | None:
    """The normal (3,) in the world of the plane in which all joints of a loop move; None where there is none."""
    joints = tree.between(pair.a, pair.b)
    if not joints or not all(one.type.single for one in joints):
        return None
    axes = [(one.type.slides, placed[one.child][:3, :3] @ one.axis) for one in joints]
    turning = [axis for slides, axis in axes if not slides]
    if not turning:
        return None
    normal = turning[0]
    flat = all(
        abs(axis @ normal) <= SAME_DIRECTION if slides else np.linalg.norm(np.cross(axis, normal)) <= SAME_DIRECTION
        for slides, axis in axes
    )
    return np.asarray(normal) if flat else None


def with_cut(robot: RobotDescription, cut: CutJoint) -> RobotDescription:
    """A copy in which the cut of that name is this one."""
    return with_cuts(robot, [cut if one.name == cut.name else one for one in robot.cuts])


def _choice(robot: RobotDescription, cut: CutJoint, near: ClosedChain) -> TypeChoice:
    chain = closed(with_cut(robot, cut), near)
    if chain is None:
        return TypeChoice(cut.type.value, False, -1, -1)
    usual, report = usual_mobility(chain), chain.mobility()
    return TypeChoice(cut.type.value, True, usual, report.rows - report.velocities + usual)


def _shared_axis(pair: Pair, placed: Mapping[str, Array]) -> Array | None:
    """The z axis (3,) of both frames in the world, where it is one."""
    a, b = placed[pair.a][:3, 2], placed[pair.b][:3, 2]
    return np.asarray(a) if np.linalg.norm(np.cross(a, b)) <= SAME_DIRECTION and a @ b > 0.0 else None


def _along(link: str, place: Array, axis: Array) -> Frame:
    """The frame of a link, turned so that its z axis is along an axis of the world where it is not yet."""
    own = place[:3, :3].T @ axis
    if np.linalg.norm(np.cross(own, [0.0, 0.0, 1.0])) <= SAME_DIRECTION and own[2] > 0.0:
        return Frame(link)
    return Frame(link, from_rotation(frame_along(_tidy(own)), np.zeros(3)))


def _tidy(axis: Array) -> Sequence[float]:
    """An axis without the noise of a computation, exactly along x, y or z where it is nearly."""
    for one in (*np.eye(3), *-np.eye(3)):
        if np.linalg.norm(axis - one) <= SAME_DIRECTION:
            return [float(x) + 0.0 for x in one]
    return [float(x) for x in axis]
