"""The file that is to be cut: its robot, and what a reader of it leaves out where it makes cuts."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, replace

from cutjoint.description import catalogue, read_checked
from cutjoint.description.formats import format_of
from cutjoint.description.formats.urdf.plain import read_robot
from cutjoint.description.formats.urdf.transmission import driven
from cutjoint.description.model import CutJoint, CutType, Joint, RobotDescription
from cutjoint.errors import DescriptionError, Problem
from cutjoint.findings import Findings


@dataclass(frozen=True, eq=False)
class SourceFile:
    """A robot as its file has it.

    Attributes:
        robot: with the cuts whose type the file says; without actuators and tool where it does not say them.
        preferred: joints that the file drives.
        originals: joints that became cuts as the file was read, by name, with limits that a cut has not.
        told: what is odd about the file, a sentence each.
    """

    robot: RobotDescription
    preferred: tuple[str, ...]
    originals: Mapping[str, Joint]
    told: tuple[str, ...]


def read_source(source: str | os.PathLike[str], lenient: bool) -> SourceFile:
    """Read the robot that a path or a name means.

    Raises:
        UnknownNameError: no such robot.
        DescriptionError: the file is wrong.
    """
    path = catalogue.resolve(source)
    reading = read_checked(source, lenient)
    if reading.description is None:
        raise DescriptionError(reading.problems)
    robot = _untyped(reading.description)
    told = tuple(sentence(one) for one in reading.problems if "are held together at a point" not in one.found)
    if path.is_dir() or format_of(path).name != "URDF":
        return SourceFile(robot, robot.actuators, reading.closing, told)
    root = read_robot(path, Findings(str(path)))
    if root is None:
        return SourceFile(robot, robot.actuators, reading.closing, told)
    if not robot.cuts:
        robot = replace(robot, actuators=(), tool=None)  # those of a chain without loops, taken unsaid
    return SourceFile(robot, driven(root), reading.closing, told)


def sentence(problem: Problem) -> str:
    """A problem in one sentence, with how to mend it."""
    return f"{problem.found} ({problem.mend})" if problem.mend else problem.found


def _untyped(robot: RobotDescription) -> RobotDescription:
    """Without the cuts between closing frames of onshape-to-robot, which are held at a point where the URDF does not
    say the type: they are pairs of frames like others."""

    def unsaid(cut: CutJoint) -> bool:
        ends = (f"{cut.name}_1", f"{cut.name}_2")
        own = cut.place.file.endswith(".toml")
        return cut.type is CutType.SPHERICAL and (cut.a.link, cut.b.link) == ends and not own

    return replace(robot, cuts=tuple(one for one in robot.cuts if not unsaid(one)))
