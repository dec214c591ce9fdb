"""Bodies and joints of any topology, turned into a spanning tree and cut joints.

Formats that allow loops (SDF) give bodies and joints with world placements at the zero configuration.  The first joint
of the file that has a link as its child carries it; where that gives no tree, joints are taken greedily, backwards if
need be.  Every other joint becomes a cut joint between the two links.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.extras import OpenTree, RobotFindings
from cutjoint.description.formats.common.physics import CUT_KEYS, leftover
from cutjoint.description.model import CutJoint, CutType, Frame, Joint, JointPhysics, JointType, Link
from cutjoint.description.transforms import frame_along, inverse, turned
from cutjoint.findings import Findings


@dataclass(frozen=True, eq=False)
class PlacedLink:
    """A link and its placement (4, 4) in the world at zero."""

    link: Link
    world: Array


def span(
    name: str,
    bodies: Sequence[PlacedLink],
    edges: Sequence[Joint],
    root: str,
    findings: Findings,
    keep: Collection[str] = (),
    close: Collection[str] = (),
) -> tuple[OpenTree, list[CutJoint]]:
    """A tree from `root` over all bodies that joints connect to it, and the joints left over as cuts.

    The placements of the joints that are given (`edges`) are those of their frames in the world at zero.  Where there
    is a choice, the joints named in `keep` stay in the tree and the others of `close` become cuts.  Bodies that
    nothing connects to the root stay in the list of links without a joint.
    """
    tree = OpenTree(name, [body.link for body in bodies])
    world = {body.link.name: body.world for body in bodies}
    close = set(close).difference(keep)
    used = _spanning(bodies, edges, root)
    inside = {edge.name for edge, _ in used}
    if not inside >= {edge.name for edge in edges if edge.name in keep} or inside & close:
        used = _spanning(bodies, _forest(edges, inside, keep, close), root)
    for edge, backwards in used:
        attach(tree, edge, backwards, world)
    taken = {id(edge) for edge, _ in used}
    cuts = [cut_at(edge, world, findings) for edge in edges if id(edge) not in taken]
    return tree, [cut for cut in cuts if cut is not None]


def _spanning(bodies: Sequence[PlacedLink], edges: Sequence[Joint], root: str) -> list[tuple[Joint, bool]]:
    used = _first_parents(bodies, edges, root)
    return reached(edges, root) if used is None else used


def _forest(
    edges: Sequence[Joint], inside: Collection[str], keep: Collection[str], close: Collection[str]
) -> list[Joint]:
    """The joints without those that close loops: rather those of `close`, and none of `keep` if there is a choice.

    Otherwise those named in `inside` stay.
    """

    def rank(edge: Joint) -> tuple[bool, bool, bool]:
        return edge.name in close, edge.name not in keep, edge.name not in inside

    kept = {edge.name for edge in without_loops(edges, rank)}
    return [edge for edge in edges if edge.name in kept]


def without_loops(edges: Sequence[Joint], rank: Callable[[Joint], tuple[bool, ...]]) -> list[Joint]:
    """As many of the joints as close no loop, taken and listed by their `rank`, the lowest first."""
    part: dict[str, str] = {}

    def top(name: str) -> str:
        while name in part:
            name = part[name]
        return name

    kept = []
    for edge in sorted(edges, key=rank):
        ends = top(edge.parent), top(edge.child)
        if ends[0] != ends[1]:
            part[ends[0]] = ends[1]
            kept.append(edge)
    return kept


def _first_parents(bodies: Sequence[PlacedLink], edges: Sequence[Joint], root: str) -> list[tuple[Joint, bool]] | None:
    """Each link on the first joint that names it as child, or None where that leaves one unreached."""
    above: dict[str, Joint] = {}
    for edge in edges:
        if edge.child != root:
            above.setdefault(edge.child, edge)
    reached = {root}
    for body in bodies:
        way = []
        name = body.link.name
        while name not in reached:
            if name not in above or name in way:
                return None
            way.append(name)
            name = above[name].parent
        reached.update(way)
    return [(edge, False) for edge in edges if above.get(edge.child) is edge]


def reached(edges: Sequence[Joint], root: str) -> list[tuple[Joint, bool]]:
    """Joints in the order in which they reach a new link from the root, and whether backwards: forwards where that is
    possible."""
    there, pending = {root}, list(edges)
    used: list[tuple[Joint, bool]] = []
    while True:
        forward = next((one for one in pending if one.parent in there and one.child not in there), None)
        edge = forward or next((one for one in pending if one.child in there and one.parent not in there), None)
        if edge is None:
            return used
        used.append((edge, forward is None))
        there |= {edge.parent, edge.child}
        pending.remove(edge)


def attach(tree: OpenTree, edge: Joint, backwards: bool, world: dict[str, Array]) -> None:
    """Add the joint; where its frame is not the child's, a massless link at the joint and a fixed joint as well."""
    parent, child = (edge.child, edge.parent) if backwards else (edge.parent, edge.child)
    sign = -1.0 if backwards else 1.0
    swap = backwards and edge.type.axes == 2
    axis, axis2 = (-edge.axis2, -edge.axis) if swap else (sign * edge.axis, edge.axis2)
    here = np.array_equal(edge.placement, world[child])
    moved = child if here else f"{child}_at_{edge.name}"
    placed = inverse(world[parent]) @ edge.placement
    joint = replace(edge, parent=parent, child=moved, placement=placed, axis=axis, axis2=axis2)
    tree.joints.append(joint)
    if not here:
        offset = readonly(inverse(edge.placement) @ world[child])
        tree.links.append(Link(moved, place=edge.place))
        tree.joints.append(Joint(f"{moved}_fixed", JointType.FIXED, moved, child, offset, place=edge.place))


def cut_at(edge: Joint, world: dict[str, Array], findings: Findings) -> CutJoint | None:
    """The joint as a cut, with its frames on both links where they meet at zero."""
    at_parent, at_child = (readonly(inverse(world[link]) @ edge.placement) for link in (edge.parent, edge.child))
    return cut_of(edge, at_parent, at_child, findings)


def cut_of(edge: Joint, at_parent: Array, at_child: Array, findings: Findings) -> CutJoint | None:
    """A joint that closes a loop, as a cut between its frames (4, 4) in both links; None after noting why not.

    Its placement does not count.  What a cut cannot have is noted: limits, stops, rotors; the joint is kept in
    `RobotFindings.closing`, for those who close the loop elsewhere.
    """
    if edge.type.cut is None:
        found = f"joint '{edge.name}' of type {edge.type.value} closes a loop"
        known = ", ".join(kind.value for kind in JointType if kind.cut)
        findings.error(found, f"one of {known}", "remove it: it constrains too little", edge.place)
        return None
    kind = CutType(edge.type.cut)
    align = np.eye(3)
    if kind.axes == "z":
        align = np.array(frame_along(edge.axis))
    elif kind.axes == "xy":
        align = np.column_stack([edge.axis, edge.axis2, np.cross(edge.axis, edge.axis2)])
    if edge.limits.bounded:
        found = f"limits of joint '{edge.name}', which closes a loop, are not used"
        findings.warn(found, "limits in the tree", "let another joint of the loop close it", edge.place)
    if isinstance(findings, RobotFindings):
        findings.closing[edge.name] = edge
    a, b = Frame(edge.parent, turned(at_parent, align)), Frame(edge.child, turned(at_child, align))
    return CutJoint(edge.name, kind, a, b, edge.place, _free_motion(edge, findings))


def _free_motion(edge: Joint, findings: Findings) -> JointPhysics:
    """What of a joint's physics its cut has: all but stops and rotors, which are noted."""
    kept = {key: getattr(edge.physics, key) for key in CUT_KEYS}
    if leftover(edge.physics, JointPhysics(**kept)):
        found = f"stops or rotor of joint '{edge.name}', which closes a loop, are not used"
        findings.warn(found, "stops and rotors in the tree", "let another joint of the loop close it", edge.place)
    return JointPhysics(**kept)
