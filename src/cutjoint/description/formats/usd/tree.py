"""A spanning tree of bodies and joints whose two frames need not meet in the pose of the file, and cuts of the rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.graph import PlacedLink, cut_of, span
from cutjoint.description.formats.usd.bodies import WORLD, BodyTable
from cutjoint.description.formats.usd.joints import Edge
from cutjoint.description.model import CutJoint, CutType, Frame, Home, Joint, JointType
from cutjoint.description.transforms import inverse, rpy_from_rotation
from cutjoint.findings import Findings

ROOT_API = "PhysicsArticulationRootAPI"
APART = 1e-4
"""m and rad.  What bodies may stand apart in a file that was written in single precision."""


def spanned(
    name: str, bodies: BodyTable, edges: Sequence[Edge], findings: Findings
) -> tuple[OpenTree, list[CutJoint], dict[str, float | tuple[float, ...]]]:
    """The tree from the world, the joints left over as cuts, and the coordinates of its joints in the file's pose.

    Joints of the articulation come first, those that are driven or coupled before the others; what stays out of it
    (`physics:excludeFromArticulation`) carries only bodies that nothing else does.  A part that no joint ties to the
    world floats.
    """
    inside = _chosen(edges)
    floating = _floating(bodies, inside)
    world, backwards = _at_zero(bodies, inside, floating)
    joints = [replace(edge.joint, placement=_joint_frame(edge, world)) for edge in inside]
    joints += [replace(joint, placement=world[joint.child]) for joint in floating]
    placed = [PlacedLink(body.link, world[body.link.name]) for body in bodies.by_path.values()]
    tree, _ = span(name, placed, joints, WORLD, findings)
    cuts = [_cut(edge, findings) for edge in edges if edge not in inside]
    pose = _pose(inside, backwards, bodies, findings) | {joint.name: (0.0,) * 6 for joint in floating}
    return tree, [cut for cut in cuts if cut is not None], pose


def _chosen(edges: Sequence[Edge]) -> list[Edge]:
    """The joints of a spanning forest, in the order of the file."""
    group: dict[str, str] = {}

    def top(link: str) -> str:
        while group.get(link, link) != link:
            link = group[link]
        return link

    chosen: list[Edge] = []
    for edge in sorted(edges, key=lambda one: (one.apart, not one.wanted)):
        ends = top(edge.joint.parent), top(edge.joint.child)
        if edge.length is None and ends[0] != ends[1]:
            group[ends[1]] = ends[0]
            chosen.append(edge)
    return [edge for edge in edges if edge in chosen]


def _floating(bodies: BodyTable, inside: Sequence[Edge]) -> list[Joint]:
    """A floating joint from the world for each part of the forest that is not tied to it.

    It carries the root of the part's articulation, or else the first body that is no joint's second.
    """
    near: dict[str, set[str]] = {}
    for edge in inside:
        near.setdefault(edge.joint.parent, set()).add(edge.joint.child)
        near.setdefault(edge.joint.child, set()).add(edge.joint.parent)
    seconds = {edge.joint.child for edge in inside}
    reached = _reach(WORLD, near, set())
    order = sorted(
        (body for body in bodies.by_path.values() if body.prim is not None),
        key=lambda body: (not (body.prim and body.prim.has(ROOT_API)), body.link.name in seconds),
    )
    joints = []
    for body in order:
        name = body.link.name
        if name not in reached:
            joints.append(Joint(f"{name}_free", JointType.FLOATING, WORLD, name, place=body.link.place))
            reached = _reach(name, near, reached)
    return joints


def _reach(start: str, near: dict[str, set[str]], reached: set[str]) -> set[str]:
    reached, stack = set(reached), [start]
    while stack:
        name = stack.pop()
        if name not in reached:
            reached.add(name)
            stack += near.get(name, set())
    return reached


def _at_zero(bodies: BodyTable, inside: Sequence[Edge], floating: Sequence[Joint]) -> tuple[dict[str, Array], set[str]]:
    """Where every link is in the world when all joints of the tree are at zero, and the joints that it takes backwards.

    What floats stays where the file has it.
    """
    given = {body.link.name: body.world for body in bodies.by_path.values()}
    world = {name: given[name] for name in (WORLD, *(joint.child for joint in floating))}
    around: dict[str, list[Edge]] = {}
    for edge in inside:
        for end in (edge.joint.parent, edge.joint.child):
            around.setdefault(end, []).append(edge)
    stack, backwards = list(world), set()
    while stack:
        name = stack.pop()
        for edge in around.get(name, ()):
            one, other = (edge.a, edge.b) if edge.joint.parent == name else (edge.b, edge.a)
            far = edge.joint.child if edge.joint.parent == name else edge.joint.parent
            if far not in world:
                if far == edge.joint.parent:
                    backwards.add(edge.joint.name)
                world[far] = readonly(world[name] @ one @ inverse(other))
                stack.append(far)
    return world, backwards


def _joint_frame(edge: Edge, world: dict[str, Array]) -> Array:
    """Where a joint of the tree is at zero: exactly the child's frame where it is given there."""
    if np.array_equal(edge.b, np.eye(4)):
        return world[edge.joint.child]
    return readonly(world[edge.joint.parent] @ edge.a)


def _cut(edge: Edge, findings: Findings) -> CutJoint | None:
    joint = edge.joint
    if edge.driven:
        found = f"the drive of joint <{edge.prim.path}>, which closes a loop, acts on nothing"
        findings.error(found, "drives in the tree", "exclude another joint of the loop from the articulation")
    if edge.length is not None:
        return CutJoint(joint.name, CutType.DISTANCE, Frame(joint.parent, edge.a), Frame(joint.child, edge.b),
                        joint.place, length=edge.length)  # fmt: skip
    return cut_of(joint, edge.a, edge.b, findings)


def _pose(
    inside: Sequence[Edge], backwards: set[str], bodies: BodyTable, findings: Findings
) -> dict[str, float | tuple[float, ...]]:
    """The coordinates of the tree's joints where the bodies stand in the file."""
    given = {body.link.name: body.world for body in bodies.by_path.values()}
    found: dict[str, float | tuple[float, ...]] = {}
    for edge in inside:
        joint = edge.joint
        between = inverse(given[joint.parent] @ edge.a) @ given[joint.child] @ edge.b
        if joint.name in backwards and not joint.type.single:  # a ball's coordinates are those of the link it carries
            between = inverse(between)
        moved, left = _coordinates(joint, between)
        if left > APART:
            found_text = f"the bodies of joint <{edge.prim.path}> stand {left:.3g} m or rad apart in the file"
            findings.warn(found_text, "a pose in which its frames meet", "closing the loops begins near that pose")
        if joint.type.moves:
            found[joint.name] = _within(moved[0], joint) if joint.type.single else tuple(moved)
    return found


def _coordinates(joint: Joint, between: Array) -> tuple[list[float], float]:
    """Coordinates of a joint between its frames (4, 4), and how far they are from what it lets move [m or rad]."""
    turn, shift = between[:3, :3], between[:3, 3]
    kind, axis = joint.type, joint.axis
    if kind is JointType.SPHERICAL:
        return list(rpy_from_rotation(turn)), float(np.abs(shift).max())
    skew = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = float(np.arctan2(skew @ axis, 0.5 * (np.trace(turn) - axis @ turn @ axis)))
    tilt = float(np.linalg.norm(turn @ axis - axis))
    along = float(axis @ shift)
    if kind.turns:
        return [angle], max(tilt, float(np.linalg.norm(shift)))
    rest = max(tilt, abs(angle), float(np.linalg.norm(shift - (along * axis if kind.slides else 0.0))))
    return ([along] if kind.slides else []), rest


def _within(value: float, joint: Joint) -> float:
    """An angle with whole turns added so that it is within the limits, where that can be."""
    lower, upper = joint.limits.ends
    if not joint.type.turns:
        return value
    for turns in (0, 1, -1):
        moved = value + 2.0 * np.pi * turns
        if lower <= moved <= upper:
            return float(moved)
    return value


def home_of(pose: dict[str, float | tuple[float, ...]], actuators: Sequence[str]) -> tuple[Home, ...]:
    """The pose of the file as a home posture; none where it is the zero of all joints."""
    if all(not np.any(value) for value in pose.values()):
        return ()
    actuated = {name: float(pose[name]) for name in actuators}  # type: ignore[arg-type]
    passive = {name: value for name, value in pose.items() if name not in actuators}
    return (Home("file", actuated, passive, "as the bodies stand in the file"),)
