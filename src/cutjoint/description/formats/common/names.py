"""Names that no file can hold so that they come back."""

from __future__ import annotations

import re
from collections.abc import Iterator

from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError

_NO_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")
"""What XML has no way to write."""
_XACRO = re.compile(r"\$[({]")


def check_names(robot: RobotDescription, form: str, *, xacro: bool = False, taken: str = "") -> None:
    """See that all names of a robot can be written.

    Args:
        robot: the robot.
        form: the format, for the message.
        xacro: whether readers of the format take ${...} and $(...) for something to expand.
        taken: how names begin that the format needs for other things.

    Raises:
        InputError: one cannot.
    """
    for kind, name in _named(robot):
        shown = kind in ("shape", "mesh")
        part = kind in ("link", "joint", "cut", "coupling")
        wrong = ""
        if _NO_TEXT.search(name):
            wrong = "it has characters that are no text"
        elif not shown and name != name.strip():
            wrong = "blanks around a name are lost"
        elif xacro and _XACRO.search(name):
            wrong = "${...} and $(...) are taken for xacro"
        elif taken and part and name.startswith(taken):
            wrong = f"names that begin with '{taken}' are of what stands for parts of the robot"
        elif not name and not shown:
            wrong = "it is empty"
        if wrong:
            raise InputError(f"{form} cannot say the name {name!a} of a {kind}: {wrong}; rename it")


def _named(robot: RobotDescription) -> Iterator[tuple[str, str]]:
    """Kind and name of all that has one."""
    yield "robot", robot.name
    for link in robot.links:
        yield "link", link.name
        for shape in (*link.visuals, *link.collisions):
            yield "shape", shape.name
            yield "mesh", "" if shape.mesh is None else str(shape.mesh)
    for joint in robot.joints:
        yield "joint", joint.name
    for cut in robot.cuts:
        yield "cut", cut.name
    for coupling in robot.couplings:
        yield "coupling", coupling.name
    for home in robot.homes:
        yield "home", home.name
    for variant in robot.variants:
        yield "variant", variant.name
