"""The robots by name: the closed chain of any of them, and the published reduced model of those that have one.

Adding a published model is one row in `PUBLISHED`; adding a robot is a folder under urdf/ and needs no code.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from math import pi
from typing import TYPE_CHECKING, Literal

import numpy as np

from cutjoint.doors import door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.values import ToolMotion

if TYPE_CHECKING:
    from cutjoint.chain import ClosedChain
    from cutjoint.crosscheck import Cost
    from cutjoint.motion import Trajectory


@dataclass(frozen=True)
class Published:
    """A robot with a published reduced model.

    Attributes:
        model: makes the reduced model.
        variant: the inertia variant that holds the paper's hypothesis exactly; None: the inertias of the robot's file.
        physical: the variant that does without the hypothesis, if there is one.
        path: makes the paper's own trajectory, if it has one.
    """

    model: Callable[[], Mechanism]
    variant: str | None = None
    physical: str | None = None
    path: Callable[[], Trajectory] | None = None

    def trajectory(self) -> Trajectory:
        """The paper's own trajectory.

        Raises:
            InputError: it has none.
        """
        if self.path is None:
            raise InputError(f"the paper of {self.model().name} has no trajectory; give one of your own")
        return self.path()


def _paper(folder: str, name: str) -> Callable[[], Mechanism]:
    """What makes the model `name` of a folder of papers/, which is imported only then: names are to be had quickly."""

    def make() -> Mechanism:
        made: Mechanism = getattr(import_module(f"cutjoint.papers.{folder}"), name)()
        return made

    return make


def _circle() -> Trajectory:
    from cutjoint.motion import Circle
    from cutjoint.papers.cpm.published import CIRCLE

    return Circle(np.array(CIRCLE.centre), CIRCLE.radius, CIRCLE.omega)


def _curve() -> Trajectory:
    from cutjoint.motion import Lissajous
    from cutjoint.papers.omega3.published import CURVE

    return Lissajous(
        centre=np.array([CURVE.x, 0.0, 0.0]),
        amplitude=np.array([0.0, CURVE.y, CURVE.z]),
        rate=np.array([0.0, CURVE.omega, 2.0 * CURVE.omega]),
        phase=np.array([0.0, 0.0, -0.5 * pi]),
        duration=CURVE.duration,
        name="figure of eight (43)",
    )


PUBLISHED: dict[str, Published] = {
    "cpm": Published(_paper("cpm", "CpmModel"), "lumped", "distributed", _circle),
    "cpm_rotary": Published(_paper("cpm", "CpmRotaryModel"), "lumped", "distributed", _circle),
    "omega3": Published(_paper("omega3", "Omega3Model"), "lumped", "distributed", _curve),
}
"""Folder under urdf/ -> its published model."""


def named_trajectory(spec: str, chain: ClosedChain, mechanism: Mechanism | None = None) -> Trajectory:
    """The trajectory that `spec` names: "paper" is that of the robot's paper, all else as of `motion.trajectory`, from
    the home posture of `mechanism` (default: `chain`) on.

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong, or the robot has no published trajectory.
    """
    from cutjoint.motion.catalogue import TRAJECTORIES, trajectory

    name, _, rest = spec.partition(":")
    if name != "paper":
        try:
            return trajectory(spec, chain if mechanism is None else mechanism)
        except UnknownNameError as error:
            if error.kind != "trajectory":
                raise
            hint = "`cutjoint simulate --help` explains all"
            raise UnknownNameError("trajectory", error.name, ("paper", *error.known), hint) from error
    if rest:
        raise InputError(f"'{spec}' is no trajectory; paper takes no numbers")
    robot = chain.description.name
    known = [name for name, row in PUBLISHED.items() if row.path is not None]
    if robot not in known:
        others = ", ".join(f"{one}{row.form}" for one, row in TRAJECTORIES.items())
        raise InputError(f"{robot} has no published trajectory (known: {', '.join(known)}); use {others}")
    return PUBLISHED[robot].trajectory()


Dynamics = Literal["real", "ideal"]
"""Whether joints have what their files say (damping, friction, springs, rotors, stops, bushings), or move freely."""


@door
def load(
    robot: str | os.PathLike[str],
    variant: str | None = None,
    home: str | None = None,
    *,
    dynamics: Dynamics = "real",
    lenient: bool = False,
) -> ClosedChain:
    """The closed chain of a robot.

    Args:
        robot: name of a robot that ships with cutjoint or example-robot-data, or a path to its file or folder.
        variant: named set of inertias; default those of the robot's own file.
        home: named home posture; default the first.
        dynamics: "real", or "ideal" for joints that move freely whatever its files say.
        lenient: pass flaws that do not change the motion, each with a `DescriptionWarning`: see `load_description`.

    Raises:
        InputError: `dynamics` is neither.
        UnknownNameError: no such robot, variant or home.
        DescriptionError: its files are wrong; the error lists every problem.
        ClosureError: its loops cannot be closed at home.
    """
    from cutjoint.chain import ClosedChain
    from cutjoint.description import load_description

    if dynamics not in ("real", "ideal"):
        raise InputError(f'dynamics must be "real" or "ideal", found {dynamics!r}')
    description = load_description(robot, variant, lenient)
    return ClosedChain(description if dynamics == "real" else description.ideal(), home)


@door
def published(robot: str) -> Mechanism:
    """The reduced model of a robot as its paper derives it.

    Raises:
        UnknownNameError: there is none.
    """
    if robot not in PUBLISHED:
        raise UnknownNameError("robot with a published model", robot, list(PUBLISHED))
    return PUBLISHED[robot].model()


@door
def hypothesis_cost_of(robot: str) -> Cost:
    """What the simplifying hypothesis of a robot's paper costs along the paper's own trajectory.

    Raises:
        UnknownNameError: the robot has no published model.
        InputError: its paper has no trajectory.
    """
    from cutjoint.crosscheck import hypothesis_cost

    simplified = published(robot)
    trajectory = PUBLISHED[robot].trajectory()
    motions = [trajectory.at(float(t)) for t in np.linspace(0.0, trajectory.duration, 401)]
    path = [(one.position, one.velocity, one.acceleration) for one in motions if isinstance(one, ToolMotion)]
    return hypothesis_cost(simplified, load(robot, PUBLISHED[robot].physical), path)
