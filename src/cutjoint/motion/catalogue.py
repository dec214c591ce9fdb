"""The trajectories by the names that the command line uses.  A new trajectory: its file, and a row here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.paths import Circle, Hold, PointToPoint
from cutjoint.motion.values import Trajectory


@dataclass(frozen=True)
class Argument:
    """A number that a trajectory takes; it must be given where there is no default."""

    name: str
    unit: str
    about: str
    default: float | None = None

    def __str__(self) -> str:
        usual = "" if self.default is None else f", default {self.default:g}"
        return f"{self.name}: {self.unit} {self.about}{usual}"


@dataclass(frozen=True)
class TrajectoryRow:
    """How to make a trajectory that starts at the home posture of a mechanism: make(mechanism, *numbers).

    `arguments` tell the numbers, those with a default last.
    """

    make: Callable[..., Trajectory]
    arguments: tuple[Argument, ...]
    about: str

    @property
    def form(self) -> str:
        """What is written after the name, such as `:X,Y,Z[,SECONDS]`."""
        text = ""
        for i, one in enumerate(self.arguments):
            part = f"{',' if i else ':'}{one.name}"
            text += part if one.default is None else f"[{part}]"
        return text


XYZ = tuple(Argument(axis, "m", "from home") for axis in "XYZ")
TRAJECTORIES: dict[str, TrajectoryRow] = {
    "hold": TrajectoryRow(Hold.at_home, (Argument("SECONDS", "s", "of rest", 1.0),), "rest at home"),
    "line": TrajectoryRow(
        PointToPoint.from_home,
        (*XYZ, Argument("SECONDS", "s", "for the way", 1.0)),
        "a straight line from rest to rest with the least jerk",
    ),
    "circle": TrajectoryRow(
        Circle.through_home,
        (Argument("RADIUS", "m", "of the circle"), Argument("SECONDS", "s", "for a turn", 2.0)),
        "a circle through home at constant speed",
    ),
}


def describe(name: str) -> str:
    """How the trajectory called `name` is written, what it is, and its numbers with their units."""
    row = TRAJECTORIES[name]
    return f"{name}{row.form} ({row.about}; {', '.join(map(str, row.arguments))})"


def trajectory(spec: str, mechanism: Mechanism) -> Trajectory:
    """The trajectory that `spec`, NAME or NAME:NUMBER,NUMBER, names, from the home posture of `mechanism` on.

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong.
    """
    name, _, rest = spec.partition(":")
    if name not in TRAJECTORIES:
        raise UnknownNameError("trajectory", name, list(TRAJECTORIES))
    row = TRAJECTORIES[name]
    try:
        given = [float(one) for one in rest.split(",")] if rest else []
    except ValueError as error:
        raise InputError(f"'{spec}' is no trajectory; write {describe(name)}") from error
    left = [one.default for one in row.arguments[len(given) :]]
    if len(given) > len(row.arguments) or None in left:
        raise InputError(f"'{spec}' is no trajectory; write {describe(name)}")
    return row.make(mechanism, *given, *left)
