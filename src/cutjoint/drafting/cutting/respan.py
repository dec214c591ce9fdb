"""The same robot on another spanning tree: joints of its loops and cuts exchanged.

What a joint leaves free does not depend on which of its links is nearer to the base, and a cut joint is a joint like
any other.  So every joint and every cut that holds rigidly is an edge of one graph, with a frame on either link.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.graph import attach, cut_of, reached, without_loops
from cutjoint.description.model import IDENTITY, CutJoint, CutType, Home, Joint, JointType, RobotDescription
from cutjoint.description.transforms import inverse, rpy_from_rotation
from cutjoint.drafting.cutting.tree import Tree
from cutjoint.errors import InputError, Problem, UnknownNameError
from cutjoint.findings import Findings

_JOINTS = {
    CutType.FIXED: JointType.FIXED,
    CutType.REVOLUTE: JointType.CONTINUOUS,
    CutType.PRISMATIC: JointType.PRISMATIC,
    CutType.UNIVERSAL: JointType.UNIVERSAL,
    CutType.SPHERICAL: JointType.SPHERICAL,
}
"""The joint that leaves free what a cut does; a distance has none."""
X, Y, Z = np.eye(3)


@dataclass(frozen=True, eq=False)
class Connection:
    """A joint between two links; its frame (4, 4) on either.  `cut` is what it was, where it was one."""

    joint: Joint
    at_parent: Array
    at_child: Array
    cut: CutJoint | None = None

    @property
    def name(self) -> str:
        """Name of the joint or cut."""
        return self.joint.name


def edges_of(robot: RobotDescription, originals: Mapping[str, Joint]) -> list[Connection]:
    """All joints, and the cuts that may be joints, with limits and physics of the joints that they were in the file."""
    edges = [Connection(one, one.placement, IDENTITY) for one in robot.joints]
    for cut in robot.closing:
        if cut.type in _JOINTS:
            axis = Z if cut.type.axes == "z" else X
            joint = Joint(cut.name, _JOINTS[cut.type], cut.a.link, cut.b.link, IDENTITY, axis, Y, place=cut.place)
            was = originals.get(cut.name)
            if was is not None and was.type.cut == cut.type:
                joint = replace(joint, type=was.type, limits=was.limits, physics=was.physics)
            else:
                joint = replace(joint, physics=cut.physics)
            edges.append(Connection(joint, cut.a.placement, cut.b.placement, cut))
    return edges


def instead_of(robot: RobotDescription) -> Mapping[str, tuple[str, ...]]:
    """Cut -> joints of its loop that could be cut instead, the best first.

    Left out are those that must stay: actuated and coupled ones, fixed ones, and types that no cut has.  Those without
    limits come first, then those with many freedoms (fewer rows), then those far from the base (shorter branches).
    """
    tree = Tree(robot)
    coupled = {name for one in robot.couplings for name in (one.joint, *one.drivers)}
    stay = {*robot.actuators, *coupled}
    found = {}
    for cut in robot.closing:
        if cut.type in _JOINTS:
            loop = tree.between(cut.a.link, cut.b.link)
            if cut.type is CutType.FIXED and len(loop) == 1:
                continue  # what is cut then would be within one body
            loop = [one for one in loop if one.name not in stay and one.type.cut]
            found[cut.name] = tuple(one.name for one in sorted(loop, key=lambda one: _rank(one, tree)))
    return found


def _rank(joint: Joint, tree: Tree) -> tuple[bool, int, int]:
    return joint.limits.bounded, -len(joint.type.coordinates), -tree.depth(joint.child)


def respan(
    robot: RobotDescription,
    names: Sequence[str],
    at_homes: Mapping[str, Mapping[str, Array]],
    originals: Mapping[str, Joint],
) -> tuple[RobotDescription, tuple[Problem, ...]]:
    """The robot with the named joints as cuts, and other cuts in the tree instead; what is not used then is told.

    Args:
        robot: with the cuts that it has.
        names: joints of its loops (cuts may be named too, and stay).
        at_homes: name of a home -> world placement of every link when it is closed, from which the coordinates of
            joints that are new in the tree are read.
        originals: cut -> the joint that it was in the file, as far as that is known, with its limits.

    Raises:
        UnknownNameError: there is no such joint or cut.
        InputError: it cannot be cut: no loop goes through it, or it is actuated or coupled.
    """
    edges = edges_of(robot, originals)
    known = {one.name: one for one in edges}
    for name in names:
        if name not in known:
            raise UnknownNameError("joint", name, tuple(known))
    coupled = {name for one in robot.couplings for name in (one.joint, *one.drivers)}
    for name in names:
        if name in coupled or name in robot.actuators or known[name].joint.type.cut is None:
            what = "coupled" if name in coupled else "actuated" if name in robot.actuators else "of no type for a cut"
            raise InputError(f"joint '{name}' cannot be cut: it is {what}; {_choices(robot)}")
    used = _hung(edges, set(names), robot.root)
    inside = {edge.name for edge, _ in used}
    for name in names:
        if name in inside:
            raise InputError(f"joint '{name}' cannot be cut (beside the others): no loop goes through it; "
                             f"{_choices(robot)}")  # fmt: skip
    findings, tree = Findings(str(robot.path or "")), OpenTree(robot.name, list(robot.links))
    for edge, backwards in used:
        ends = {edge.joint.parent: inverse(edge.at_parent), edge.joint.child: inverse(edge.at_child)}
        attach(tree, replace(edge.joint, placement=IDENTITY), backwards, ends)
    left = [_cut(edge, findings) for edge in edges if edge.name not in inside]
    kept = [cut for cut in robot.cuts if cut not in robot.closing or cut.type not in _JOINTS]
    changed = replace(robot, links=tuple(tree.links), joints=tuple(tree.joints), cuts=(*left, *kept))
    homes = tuple(_home(one, used, at_homes[one.name]) for one in robot.homes if one.name in at_homes)
    return replace(changed, homes=homes), tuple(findings.problems)


def _choices(robot: RobotDescription) -> str:
    names = list(dict.fromkeys(name for loop in instead_of(robot).values() for name in loop))
    return f"joints that can be: {', '.join(names)}" if names else "none can be"


def _cut(edge: Connection, findings: Findings) -> CutJoint:
    if edge.cut is not None:
        return edge.cut
    cut = cut_of(edge.joint, edge.at_parent, edge.at_child, findings)
    assert cut is not None, "joints that no cut can be were refused, or stay in the tree"
    return cut


def _hung(edges: Sequence[Connection], cut: Collection[str], root: str) -> list[tuple[Connection, bool]]:
    """The edges of the tree as they are reached from the root, and whether backwards: rather those that were joints."""
    of = {edge.name: edge for edge in edges}
    kept = without_loops([edge.joint for edge in edges], lambda one: (one.name in cut, of[one.name].cut is not None))
    return [(of[joint.name], backwards) for joint, backwards in reached(kept, root)]


def _home(home: Home, used: Sequence[tuple[Connection, bool]], at_home: Mapping[str, Array]) -> Home:
    """A home on the new tree: coordinates of single joints as they were, of others as the links lie."""
    passive = {}
    for edge, backwards in used:
        name, kind = edge.name, edge.joint.type
        if not kind.moves or name in home.actuated:
            continue
        if edge.cut is None and (kind.single or not backwards):
            if name in home.passive:
                passive[name] = home.passive[name]
        else:
            ends = at_home[edge.joint.parent] @ edge.at_parent, at_home[edge.joint.child] @ edge.at_child
            value = _coordinates(edge.joint, np.asarray(inverse(ends[0]) @ ends[1]), backwards)
            if value is not None:
                passive[name] = value
    return replace(home, passive=passive)


def _coordinates(joint: Joint, t: Array, backwards: bool) -> float | tuple[float, ...] | None:
    """Coordinates of a joint whose child frame is at `t` (4, 4) in its parent frame; None for types that fly."""
    r = t[:3, :3]
    if joint.type is JointType.PRISMATIC:
        return float(joint.axis @ t[:3, 3])
    if joint.type.single:
        turn = np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
        return float(np.arctan2(0.5 * joint.axis @ turn, 0.5 * (np.trace(r) - 1.0)))
    if joint.type is JointType.SPHERICAL:
        return rpy_from_rotation(r.T if backwards else r)
    if joint.type is JointType.UNIVERSAL:
        axes = np.column_stack([joint.axis, joint.axis2, np.cross(joint.axis, joint.axis2)])
        own = axes.T @ r @ axes
        first, second = float(np.arctan2(own[2, 1], own[1, 1])), float(np.arctan2(own[0, 2], own[0, 0]))
        return (second, first) if backwards else (first, second)
    return None
