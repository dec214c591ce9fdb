"""What closes, drives and leads the tree: cut joints, couplings, actuators, tool and task, homes, variants, gravity."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

import numpy as np

from cutjoint.description.checks.tree import rigid_groups
from cutjoint.description.curves import Curve, Table
from cutjoint.description.model import TASK_AXES, TASK_NAMES, Frame, Home, JointType, Place, RobotDescription
from cutjoint.findings import Findings, clip, listing, nearest

STEEPEST = 1e9
"""Slope of a table beyond which its points lie on each other."""
SINGLE = "a joint with one coordinate: " + listing(kind.value for kind in JointType if kind.single)


def check_loops(robot: RobotDescription, sound: bool, findings: Findings) -> None:
    """Note what is wrong with cuts, couplings and everything that names links and joints.

    `sound` tells whether links and joints are a tree, without which rigidly joined links cannot be found.
    """
    links = [link.name for link in robot.links]
    _cuts(robot, links, sound, findings)
    _couplings(robot, findings)
    _actuators(robot, findings)
    if robot.tool is not None:
        _frame(robot.tool, "tool", links, findings, robot.places.get("tool", Place()))
    _task(robot, findings)
    for home in robot.homes:
        _home(home, robot, findings)
    for variant in robot.variants:
        place = robot.places.get(f"variant.{variant.name}", Place())
        for name in variant.inertials:
            _known(name, links, "link", f"variant '{variant.name}'", findings, place)
    if robot.gravity.shape != (3,) or not np.isfinite(robot.gravity).all():
        place = robot.places.get("gravity", Place())
        findings.error(f"gravity is {robot.gravity.tolist()}", "three finite numbers [m/s2]", "", place)


def _known(name: str, known: Iterable[str], kind: str, what: str, findings: Findings, place: Place) -> bool:
    known = list(known)
    if name in known:
        return True
    remedy = nearest(name, known) or f"known: {listing(known)}"
    findings.error(f"{what} names the unknown {kind} '{name}'", f"a {kind} of the tree", remedy, place)
    return False


def _frame(frame: Frame, what: str, links: list[str], findings: Findings, place: Place) -> bool:
    ok = _known(frame.link, links, "frame", what, findings, place)
    rotation = frame.placement[:3, :3]
    if not np.isfinite(frame.placement).all() or np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-6:
        findings.error(f"the frame of {what} is not a rigid motion", "a rotation and a position", "", place)
        return False
    return ok


def _cuts(robot: RobotDescription, links: list[str], sound: bool, findings: Findings) -> None:
    groups = rigid_groups(robot) if sound else {}
    counts = Counter(cut.name for cut in robot.cuts)
    for cut in robot.cuts:
        what = f"cut '{cut.name}'"
        if counts[cut.name] > 1:
            found = f"{counts[cut.name]} cuts are called '{cut.name}'"
            findings.error(found, "a name of its own for each", "rename one", cut.place)
            counts[cut.name] = 0
        if not (np.isfinite(cut.length) and (cut.length > 0.0 if cut.type.has_length else cut.length == 0.0)):
            expected = "a length > 0 m" if cut.type.has_length else "a length of cuts of type distance only"
            mend = "a spherical cut holds two points together" if cut.type.has_length and cut.length == 0.0 else ""
            findings.error(f"{what} of type {cut.type.value} has the length {cut.length:g}", expected, mend, cut.place)
        ends = [_frame(frame, what, links, findings, cut.place) for frame in (cut.a, cut.b)]
        if not all(ends):
            continue
        if cut.a.link == cut.b.link:
            found = f"both frames of {what} are on link '{cut.a.link}'"
            findings.error(
                found, "frames on two links", "a cut joins two links that move against each other", cut.place
            )
        elif sound and groups[cut.a.link] == groups[cut.b.link]:
            findings.error(
                f"{what} joins '{cut.a.link}' and '{cut.b.link}', which fixed joints hold together already",
                "two links that move against each other",
                "remove the cut, or the fixed joint that it should replace",
                cut.place,
            )


def _couplings(robot: RobotDescription, findings: Findings) -> None:
    joints = {joint.name: joint for joint in robot.joints}
    names = Counter(coupling.name for coupling in robot.couplings)
    driven = Counter(coupling.joint for coupling in robot.couplings)
    for coupling in robot.couplings:
        what = f"coupling '{coupling.name}'"
        place = coupling.place
        if names[coupling.name] > 1:
            found = f"{names[coupling.name]} couplings are called '{coupling.name}'"
            findings.error(found, "a name of its own for each", "rename one", place)
            names[coupling.name] = 0
        if driven[coupling.joint] > 1:
            found = f"joint '{coupling.joint}' is driven by {driven[coupling.joint]} couplings"
            findings.error(found, "at most one driver", "remove one", place)
            driven[coupling.joint] = 0
        for name in (coupling.joint, *coupling.drivers):
            if _known(name, joints, "joint", what, findings, place) and not joints[name].type.single:
                found = f"{what} couples the {joints[name].type.value} joint '{name}'"
                findings.error(found, SINGLE, "", place)
        if coupling.joint in coupling.drivers:
            findings.error(f"{what} couples joint '{coupling.joint}' to itself", "two joints", "", place)
        for name, count in Counter(coupling.drivers).items():
            if count > 1:
                findings.error(
                    f"{what} has the driver '{name}' {count} times", "each driver once", "add them up", place
                )
        if not np.isfinite(coupling.offset):
            findings.error(f"{what} has offset {coupling.offset}", "a number", "", place)
        for drive in coupling.drives:
            wrong = _wrong_curve(drive.curve)
            if wrong:
                findings.error(f"{what} has {wrong[0]} of '{drive.driver}'", wrong[1], "", place)
    _coupling_rings(robot, findings)


def _wrong_curve(curve: Curve) -> tuple[str, str] | None:
    """What is wrong with a curve, and what is expected."""
    if isinstance(curve, Table):
        points = np.array(curve.points, dtype=float)
        if points.ndim != 2 or len(points) < 2 or not np.isfinite(points).all():
            return "a table", "two or more points [x, y], all numbers"
        if not (np.diff(points[:, 0]) > 0.0).all():
            return "a table whose x do not grow", "points in the order of growing x, each x once"
        with np.errstate(all="ignore"):
            steep = np.abs(np.diff(points[:, 1]) / np.diff(points[:, 0])).max()
        if not steep < STEEPEST:
            return f"a table with a slope of {steep:.3g}", f"slopes below {STEEPEST:g}: points whose x lie apart"
        return None
    finite = all(np.isfinite(one).all() for piece in curve.pieces for one in piece.coefficients)
    return None if finite else ("a curve with coefficients that are no numbers", "finite numbers")


def _coupling_rings(robot: RobotDescription, findings: Findings) -> None:
    driven = {coupling.joint: coupling for coupling in robot.couplings if coupling.joint not in coupling.drivers}
    done: set[str] = set()
    for start in driven:
        way: list[tuple[str, int]] = [(start, 0)]
        while way:
            name, at = way.pop()
            drivers = driven[name].drivers if name in driven and name not in done else ()
            if at >= len(drivers):
                done.add(name)
                continue
            way.append((name, at + 1))
            ring = [one for one, _ in way]
            if drivers[at] in ring:
                ring = ring[ring.index(drivers[at]) :]
                found = f"couplings drive each other in a ring: {listing([*ring, ring[0]])}"
                findings.error(found, "a driver that no coupling drives", "remove one", driven[ring[0]].place)
                return
            way.append((drivers[at], 0))


def _actuators(robot: RobotDescription, findings: Findings) -> None:
    joints = {joint.name: joint for joint in robot.joints}
    place = robot.places.get("actuators", Place())
    counts = Counter(robot.actuators)
    for name, count in counts.items():
        if not _known(name, joints, "joint", "actuators", findings, place):
            continue
        if count > 1:
            found = f"actuators name joint '{name}' {count} times"
            findings.error(found, "each joint once", "remove the repetition", place)
        if not joints[name].type.single:
            found = f"actuators name the {joints[name].type.value} joint '{name}'"
            findings.error(found, SINGLE, "", place)


def _task(robot: RobotDescription, findings: Findings) -> None:
    place = robot.places.get("task", Place())
    if robot.task and robot.tool is None:
        findings.error("a task without a tool", "the frame that it leads", "name it under [tool]", place)
    for name, count in Counter(robot.task).items():
        if name not in TASK_NAMES:
            findings.unknown(f"the task has '{clip(name)}'", name, TASK_NAMES, place)
        elif count > 1:
            found = f"the task has '{name}' {count} times"
            findings.error(found, "each coordinate once", "remove the repetition", place)
    if robot.task_axes not in TASK_AXES:
        findings.unknown(f"the task has the axes '{clip(robot.task_axes)}'", robot.task_axes, TASK_AXES, place)


def _home(home: Home, robot: RobotDescription, findings: Findings) -> None:
    joints = {joint.name: joint for joint in robot.joints}
    place = robot.places.get(f"home.{home.name}", Place())
    what = f"home '{home.name}'"
    for name in home.actuated:
        if _known(name, joints, "joint", what, findings, place) and name not in robot.actuators:
            found = f"{what} lists joint '{name}' under actuated, but it is no actuator"
            findings.error(found, f"one of {listing(robot.actuators)}", "move it to passive", place)
    missing = [name for name in robot.actuators if name not in home.actuated]
    if missing:
        findings.error(f"{what} without {listing(missing)}", "all actuators under actuated", "add them", place)
    for name, value in home.passive.items():
        if not _known(name, joints, "joint", what, findings, place):
            continue
        if name in robot.actuators:
            found = f"{what} lists the actuator '{name}' under passive"
            findings.error(found, "passive joints", "move it to actuated", place)
        kind = joints[name].type
        given = len(value) if isinstance(value, tuple) else 1
        if given != kind.dof:
            found = f"{what} gives {given} numbers for the {kind.value} joint '{name}'"
            wanted = ", ".join(one.name for one in kind.coordinates)
            findings.error(found, f"{kind.dof}: {wanted}" if wanted else "none, since it does not move", "", place)
