"""One design judged: the robot with its values closed on the branch of the old one, and what it comes to.

A design whose lengths are far from those of the robot as it was could close on another branch at home.  So the values
are taken from the old ones to the new ones in halves until no joint moves far between two of them at home.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.description import RobotDescription
from cutjoint.errors import ClosureError, CutjointError, InputError
from cutjoint.motion import Trajectory
from cutjoint.reprs import line
from cutjoint.synthesis.quantities import QUANTITIES, Subject
from cutjoint.synthesis.variables import Variable, chosen
from cutjoint.synthesis.wants import Want

FAR = 0.4
"""How far a link may be from where it was, at home, between two designs [rad], or in lengths of the robot: more may be
another branch."""
HALVES = 5


@dataclass(frozen=True, eq=False)
class DesignProblem(Frozen):
    """What may be chosen of a robot, and what is wanted of it.

    Attributes:
        robot: as it is.
        variables: what may be chosen.
        wants: what is wanted.
        trajectories: those that wants name, by their spec.
        home: name of the home posture; None for the first.
    """

    robot: RobotDescription
    variables: tuple[Variable, ...]
    wants: tuple[Want, ...]
    trajectories: Mapping[str, Trajectory]
    home: str | None = None

    __repr__ = line("robot", "variables", "wants")

    @property
    def now(self) -> Array:
        """Values of all variables in the robot as it is."""
        return np.array([one.now(self.robot) for one in self.variables])

    @property
    def goals(self) -> tuple[Want, ...]:
        """The wants that are to be most or least."""
        return tuple(one for one in self.wants if one.goal is not None)


@dataclass(frozen=True, eq=False)
class Design(Frozen):
    """One design.

    Attributes:
        values: of the variables, shape (variables,).
        found: want by name -> value; of those that could be told.
        why: why it does not do; "" where it does.
    """

    values: Array
    found: Mapping[str, float]
    why: str = ""

    __repr__ = line("values", "found", "why")


def check_problem(problem: DesignProblem) -> None:
    """Look whether all that is wanted has a meaning for the robot as it is.

    Raises:
        InputError: something has not, or a package is missing.
    """
    try:
        subject = Subject(ClosedChain(problem.robot, problem.home), problem.trajectories)
        for want in problem.wants:
            QUANTITIES[want.quantity].judge(subject, want.options)
    except InputError:
        raise
    except CutjointError:
        return  # what the robot as it is cannot do, another design may


def judged(problem: DesignProblem, values: npt.ArrayLike) -> Design:
    """What a design comes to; one that does not close, follow or keep the bounds says why."""
    numbers = np.asarray(values, dtype=np.float64)
    found: dict[str, float] = {}
    try:
        chain = closed(problem, numbers)
        subject = Subject(chain, problem.trajectories)
        for want in problem.wants:
            found[want.name] = QUANTITIES[want.quantity].judge(subject, want.options)
    except CutjointError as error:
        return Design(numbers, found, f"{type(error).__name__}: {error}")
    missed = [want for want in problem.wants if want.missed_by(found[want.name])]
    return Design(numbers, found, "; ".join(f"{want.name} {_beyond(want, found[want.name])}" for want in missed))


def _beyond(want: Want, found: float) -> str:
    low = want.at_least is not None and found < want.at_least
    return f"{found:.4g} is {'less than' if low else 'more than'} {want.at_least if low else want.at_most:.4g}"


def closed(problem: DesignProblem, values: Array) -> ClosedChain:
    """The robot with values of the variables, on the branch of the robot as it is.

    Raises:
        ClosureError: at home it would be on another branch; or as of `ClosedChain`.
    """
    start, now = ClosedChain(problem.robot, problem.home), problem.now

    def at(part: float) -> ClosedChain:
        robot = chosen(problem.robot, problem.variables, now + part * (values - now))
        return ClosedChain(robot, problem.home)

    return _walked(start, at(1.0), 0.0, 1.0, at, HALVES)


def _walked(
    before: ClosedChain, after: ClosedChain, low: float, high: float, at: Callable[[float], ClosedChain], halves: int
) -> ClosedChain:
    """`after`, where the way to it from `before` is one of short steps."""
    if _away(before, after) <= FAR:
        return after
    if halves == 0:
        raise ClosureError(
            "at home the loops close on another branch than those of the robot as it was",
            gap=(0.0, 0.0),
            cut=before.description.cuts[0].name if before.description.cuts else "",
        )
    half = 0.5 * (low + high)
    middle = _walked(before, at(half), low, half, at, halves - 1)
    return _walked(middle, after, half, high, at, halves - 1)


def _away(before: ClosedChain, after: ClosedChain) -> float:
    """How far the links of two robots are from each other at home: the largest turn [rad], or way in robot lengths."""
    first, second = before.link_placements(before.home), after.link_placements(after.home)
    most = 0.0
    for name, one in first.items():
        way = float(np.linalg.norm(one[:3, 3] - second[name][:3, 3])) / before.length
        turn = one[:3, :3].T @ second[name][:3, :3]
        sine = 0.5 * float(np.linalg.norm([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]))
        most = max(most, way, math.atan2(sine, 0.5 * (float(np.trace(turn)) - 1.0)))
    return most
