"""The robots by name: the closed chain of any of them, and the published reduced model of those that have one.

Adding a published model is one row in `PUBLISHED`; adding a robot is a folder under urdf/ and needs no code.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.errors import UnknownNameError
from cutjoint.mechanism import Mechanism

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.motion import Trajectory


@dataclass(frozen=True)
class Published:
    """A robot with a published reduced model.

    Attributes:
        robot: its folder under urdf/.
        variant: the inertia variant that holds the paper's hypothesis exactly.
        physical: the variant that does without the hypothesis.
        model: makes the reduced model.
        trajectory: makes the paper's own trajectory.
    """

    robot: str
    variant: str
    physical: str
    model: Callable[[], Mechanism]
    trajectory: Callable[[], Trajectory]


def _cpm() -> Mechanism:
    from cutjoint.papers.cpm import CpmModel

    return CpmModel()


def _cpm_rotary() -> Mechanism:
    from cutjoint.papers.cpm import CpmRotaryModel

    return CpmRotaryModel()


def _omega3() -> Mechanism:
    from cutjoint.papers.omega3 import Omega3Model

    return Omega3Model()


def _circle() -> Trajectory:
    from cutjoint.motion import Circle
    from cutjoint.papers.cpm.published import CIRCLE

    return Circle(np.array(CIRCLE.centre), CIRCLE.radius, CIRCLE.omega)


def _curve() -> Trajectory:
    from cutjoint.motion import Lissajous
    from cutjoint.papers.omega3.published import PATH

    return Lissajous(
        centre=np.array([PATH.x, 0.0, 0.0]),
        amplitude=np.array([0.0, PATH.y, PATH.z]),
        rate=np.array([0.0, PATH.omega, 2.0 * PATH.omega]),
        phase=np.array([0.0, 0.0, -0.5 * pi]),
        duration=PATH.duration,
        name="figure of eight (43)",
    )


PUBLISHED = {
    row.robot: row
    for row in (
        Published("cpm", "lumped", "distributed", _cpm, _circle),
        Published("cpm_rotary", "lumped", "distributed", _cpm_rotary, _circle),
        Published("omega3", "lumped", "distributed", _omega3, _curve),
    )
}


def load(robot: str | os.PathLike[str], variant: str | None = None, home: str | None = None) -> ClosedChain:
    """The closed chain of a robot.

    Args:
        robot: name of a robot that ships with cutjoint or example-robot-data, or a path to its file or folder.
        variant: named set of inertias; default those of the robot's own file.
        home: named home posture; default the first.

    Raises:
        UnknownNameError: no such robot, variant or home.
        DescriptionError: its files are wrong; the error lists every problem.
        ClosureError: its loops cannot be closed at home.
    """
    from cutjoint.chain import ClosedChain
    from cutjoint.description import load_description

    return ClosedChain(load_description(robot, variant), home)


def published(robot: str) -> Mechanism:
    """The reduced model of a robot as its paper derives it.

    Raises:
        UnknownNameError: there is none.
    """
    if robot not in PUBLISHED:
        raise UnknownNameError("robot with a published model", robot, list(PUBLISHED))
    return PUBLISHED[robot].model()
