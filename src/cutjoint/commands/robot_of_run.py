"""The robot that a saved run was made with, for the commands that take a result file."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.simulation import Result


def robot_of_run(result: Result, robot: str | None, variant: str | None, lenient: bool) -> ClosedChain:
    """The robot as asked for, else as the result names it.

    Raises:
        InputError: the result names no robot that is here.
        CutjointError: as of loading it.
    """
    from cutjoint.errors import InputError, UnknownNameError
    from cutjoint.robots import load

    if robot is not None:
        return load(robot, variant, lenient=lenient)
    named = str(result.about.get("robot", ""))
    name, _, rest = named.partition(" ")
    try:
        chain = load(name, variant, lenient=lenient)
    except UnknownNameError as error:
        raise InputError(f"the result was made with '{named}', which is no robot here; name it with --robot") from error
    made_with = rest.strip("()")
    if variant is None and made_with in {one.name for one in chain.description.variants}:
        return load(name, made_with, lenient=lenient)
    return chain
