"""Links and joints form one tree: unique names, known ends, one root, one parent a link, no cycle, not too deep;
and the joints by themselves: axes, limits, placements."""

from __future__ import annotations

import math
from collections import Counter, defaultdict

import numpy as np

from cutjoint.description.model import Joint, RobotDescription
from cutjoint.findings import Findings, listing, nearest

DEEPEST = 500
"""Joints from the root to a leaf.  Recursive parsers and algorithms crash the process at a few thousand."""
MOST_LINKS = 5000

RESERVED = ("universe",)
"""Names that Pinocchio keeps for the world."""

_MEND_LOOP = "leave one joint of the loop out of the tree and close it with a cut joint"


def check_tree(robot: RobotDescription, findings: Findings) -> None:
    """Note everything that keeps links and joints from being a tree."""
    if not robot.links:
        mend = "does the file define one, or only parts for others?"
        findings.error("a robot without links", "at least one link", mend)
    _names(robot, findings)
    links = {link.name for link in robot.links}
    for joint in robot.joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in links:
                found = f"{end} '{name}' of joint '{joint.name}' is not a link"
                findings.error(found, "the name of a link", nearest(name, links), joint.place)
    if len(robot.links) > MOST_LINKS:
        findings.error(f"{len(robot.links)} links", f"at most {MOST_LINKS}")
    _shape(robot, links, findings)


def _names(robot: RobotDescription, findings: Findings) -> None:
    for kind, items in (("link", robot.links), ("joint", robot.joints)):
        counts = Counter(item.name for item in items)
        seen: set[str] = set()
        for item in items:
            if item.name in seen and counts[item.name] > 1:
                found = f"{counts[item.name]} {kind}s are called '{item.name}'"
                findings.error(found, "a name of its own for each", "rename this one", item.place)
                counts[item.name] = 0
            seen.add(item.name)
            if item.name in RESERVED:
                found = f"a {kind} called '{item.name}'"
                findings.error(found, "another name: Pinocchio keeps this one for the world", "rename it", item.place)


def _shape(robot: RobotDescription, links: set[str], findings: Findings) -> None:
    above: dict[str, list[Joint]] = defaultdict(list)
    for joint in robot.joints:
        if joint.parent in links and joint.child in links:
            above[joint.child].append(joint)
    for child, joints in above.items():
        if len(joints) > 1:
            found = f"link '{child}' has {len(joints)} parents, by joints {listing(one.name for one in joints)}"
            findings.error(found, "one joint above each link (a tree)", _MEND_LOOP, joints[1].place)
    cyclic = _cycles(robot, above, findings)
    carried = {joint.child for joint in robot.joints}
    roots = [link for link in robot.links if link.name not in carried]
    if len(roots) > 1:
        found = f"{len(roots)} root links: {listing(link.name for link in roots)}"
        remedy = f"join '{roots[1].name}' to the rest with a joint (a floating one for a free body), or remove it"
        findings.error(found, "one root", remedy, roots[1].place)
    if not cyclic:
        _depth(robot, above, findings)


def _cycles(robot: RobotDescription, above: dict[str, list[Joint]], findings: Findings) -> bool:
    """Follow first parents upwards; a link met twice on the way is in a cycle."""
    done: set[str] = set()
    found = False
    for link in robot.links:
        way: list[str] = []
        on_way: set[str] = set()
        name = link.name
        while name not in done and name not in on_way:
            way.append(name)
            on_way.add(name)
            if name not in above:
                break
            name = above[name][0].parent
        else:
            if name in on_way:
                cycle = way[way.index(name) :][::-1]
                kind = "a cycle" if len(robot.links) == len(cycle) else "a cycle apart from the tree"
                place = above[name][0].place
                findings.error(f"{kind}: {listing([*cycle, cycle[0]])}", "a tree", _MEND_LOOP, place)
                found = True
        done.update(way)
    return found


def _depth(robot: RobotDescription, above: dict[str, list[Joint]], findings: Findings) -> None:
    depth: dict[str, int] = {}
    for link in robot.links:
        way: list[str] = []
        name = link.name
        while name not in depth and name in above:
            way.append(name)
            name = above[name][0].parent
        level = depth.setdefault(name, 0)
        for one in reversed(way):
            level += 1
            depth[one] = level
    deepest = max(depth, key=lambda name: depth[name], default="")
    if deepest and depth[deepest] > DEEPEST:
        found = f"link '{deepest}' is {depth[deepest]} joints from the root"
        place = next(link.place for link in robot.links if link.name == deepest)
        findings.error(found, f"at most {DEEPEST}", "merge links that do not move against each other", place)


def rigid_groups(robot: RobotDescription) -> dict[str, str]:
    """Link -> the topmost link that it is rigidly joined to by fixed joints.  The tree must be sound."""
    fixed = {joint.child: joint.parent for joint in robot.joints if not joint.type.moves}
    group: dict[str, str] = {}
    for link in robot.links:
        way = [link.name]
        while way[-1] in fixed and way[-1] not in group:
            way.append(fixed[way[-1]])
        top = group.get(way[-1], way[-1])
        for name in way:
            group[name] = top
    return group


_LOOSE = 1e-6


def check_joints(robot: RobotDescription, findings: Findings) -> None:
    """Note wrong placements, axes and limits of every joint."""
    for joint in robot.joints:
        _placement(joint, findings)
        _axes(joint, findings)
        check_limits(joint, findings)


def _placement(joint: Joint, findings: Findings) -> None:
    rotation = joint.placement[:3, :3]
    if not np.isfinite(joint.placement).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > _LOOSE:
        findings.error(f"placement of joint '{joint.name}' is not a rigid motion", "a rotation and a position",
                       "", joint.place)  # fmt: skip


def _axes(joint: Joint, findings: Findings) -> None:
    axes = (("axis", joint.axis), ("second axis", joint.axis2))[: joint.type.axes]
    for what, axis in axes:
        if not abs(float(np.linalg.norm(axis)) - 1.0) < _LOOSE:
            found = f"{what} of joint '{joint.name}' is {axis.tolist()}"
            findings.error(found, "a unit vector", "", joint.place)
    if joint.type.axes == 2 and abs(float(joint.axis @ joint.axis2)) > _LOOSE:
        found = f"the axes of {joint.type.value} joint '{joint.name}' are not perpendicular"
        findings.error(found, "two perpendicular axes", "use two revolute joints", joint.place)


def check_limits(joint: Joint, findings: Findings) -> None:
    """Note limits that are not finite, negative or upside down."""
    limits = joint.limits
    values = (limits.lower, limits.upper, limits.velocity, limits.effort)
    if any(value is not None and not math.isfinite(value) for value in values):
        findings.error(f"limits of joint '{joint.name}' are not finite: {values}", "numbers", "", joint.place)
        return
    if limits.lower is not None and limits.upper is not None:
        shown = f"{limits.lower:g} to {limits.upper:g}"
        if limits.lower > limits.upper:
            found = f"limits of joint '{joint.name}' are upside down: {shown}"
            findings.error(found, "lower <= upper", "swap them", joint.place)
        elif limits.lower == limits.upper:
            found = f"joint '{joint.name}' cannot move: limits {shown}"
            findings.warn(found, "a range, no limits, or a fixed joint", "", joint.place)
    for what, value in (("velocity", limits.velocity), ("effort", limits.effort)):
        if value is not None and value < 0.0:
            findings.error(f"{what} limit of joint '{joint.name}' is {value:g}", "a number >= 0", "", joint.place)
