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
    from cutjoint.report.named_runs import robot_of
    from cutjoint.robots import load

    if robot is not None:
        return load(robot, variant, lenient=lenient)
    return robot_of(result, variant, lenient=lenient)
