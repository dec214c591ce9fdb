"""Which posture the command line means: home, coordinates of the actuators, or a place of the tool."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import numpy as np
import typer

from cutjoint.commands.options import numbers
from cutjoint.errors import InputError

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.mechanism import Posture

At = Annotated[
    str | None,
    typer.Option("--at", metavar="Q1,Q2,...", help="Coordinates of the actuators, in m or rad; default home."),
]
Reach = Annotated[
    str | None,
    typer.Option("--reach", metavar="X,Y,Z", help="Place of the tool in m; of a pose x,y,z,qx,qy,qz,qw. Default home."),
]


def posture_of(chain: ClosedChain, at: str | None, reach: str | None) -> Posture:
    """The posture that is asked for.

    Raises:
        InputError: both are given, or no numbers; or as of `close` and `reach`.
    """
    if at is not None and reach is not None:
        raise InputError("--at and --reach both say where the robot is; give one of them")
    if at is not None:
        return chain.close(np.atleast_1d(np.asarray(numbers("--at", at), dtype=np.float64)))
    if reach is not None:
        return chain.reach(np.atleast_1d(np.asarray(numbers("--reach", reach), dtype=np.float64)))
    return chain.home
