"""Checking a robot: everything that is wrong at once, and loading one only where nothing is.

What needs the closed chain (do the loops close, how mobile is the robot) is not known here; the chain checks it.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import replace

from cutjoint.description.catalogue import is_example, resolve
from cutjoint.description.checks.inertias import check_inertias, check_moved_mass
from cutjoint.description.checks.loops import check_loops
from cutjoint.description.checks.physics import check_physics
from cutjoint.description.checks.shapes import check_shapes, without_impossible_shapes
from cutjoint.description.checks.tree import check_joints, check_tree
from cutjoint.description.formats import Reading, read
from cutjoint.description.model import RobotDescription
from cutjoint.doors import door
from cutjoint.errors import DescriptionError, DescriptionWarning, Problem, UnknownNameError
from cutjoint.findings import Findings


@door
def check(robot: RobotDescription | str | os.PathLike[str], lenient: bool = False) -> tuple[Problem, ...]:
    """All problems of a description, or of the files that a name or path means; errors first, then warnings.

    Args:
        robot: a description, a path (a file, or a folder with a loops.toml) or the name of a robot in the catalogue.
        lenient: see `load_description`.
    """
    if isinstance(robot, RobotDescription):
        return _sorted(_tolerated(check_description(robot)) if lenient else check_description(robot))
    return read_checked(robot, lenient).problems


def check_description(robot: RobotDescription) -> tuple[Problem, ...]:
    """All problems of the values of a description, wherever they came from; errors first."""
    findings = Findings(str(robot.path or ""))
    with suppress(DescriptionError):  # very many errors, all of them found
        check_tree(robot, findings)
        sound = not findings.failed
        check_joints(robot, findings)
        check_physics(robot, findings)
        check_inertias(robot, findings)
        check_loops(robot, sound, findings)
        check_shapes(robot, findings)
        if sound:
            check_moved_mass(robot, findings)
    return _sorted(findings.problems)


def read_checked(source: str | os.PathLike[str], lenient: bool = False) -> Reading:
    """Read and check a robot.  The description is None where there is an error; problems hold the warnings too."""
    try:
        path = resolve(source)
    except UnknownNameError as error:
        return Reading(None, (Problem(str(error), "the path of a file, or the name of a robot"),))
    reading = read(path)
    problems = list(reading.problems)
    if reading.description is not None:
        problems = list(dict.fromkeys((*problems, *check_description(reading.description))))
    if lenient or is_example(path):
        problems = _tolerated(problems)
    ordered = _sorted(problems)
    failed = reading.description is None or any(one.severity == "error" for one in ordered)
    description = None if failed or reading.description is None else without_impossible_shapes(reading.description)
    return Reading(description, ordered, reading.closing)


@door
def load_description(
    source: str | os.PathLike[str], variant: str | None = None, lenient: bool = False
) -> RobotDescription:
    """The robot that a path or a name means, checked.

    Args:
        source: a folder with a loops.toml, a file of any known format, or the name of a robot in the catalogue.
        variant: name of a variant of its inertias; None for those of the tree's own file.
        lenient: pass flaws that do not change the motion, with a `DescriptionWarning` for each: missing meshes and
            shapes with impossible sizes (they are left out), colours, joints named like links, inertias that no body
            can have (they are taken as they stand).  Robots of example-robot-data are always read leniently, without
            warnings.

    Raises:
        UnknownNameError: no robot or no variant of that name.
        DescriptionError: the files are wrong; its `problems` holds everything that was found, warnings included.
    """
    reading = read_checked(resolve(source), lenient)
    if reading.description is None:
        raise DescriptionError(reading.problems)
    description = reading.description
    for passed in reading.problems if lenient else ():
        if passed.tolerable:
            warnings.warn(str(passed), DescriptionWarning, stacklevel=2)
    return description if variant is None else description.variant(variant)


def _tolerated(problems: Iterable[Problem]) -> list[Problem]:
    return [replace(one, severity="warning") if one.tolerable else one for one in problems]


def _sorted(problems: Iterable[Problem]) -> tuple[Problem, ...]:
    return tuple(sorted(problems, key=lambda problem: problem.severity != "error"))
