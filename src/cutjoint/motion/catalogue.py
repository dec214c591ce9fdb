"""The trajectories by the names that the command line uses.  A new trajectory: its file, and a row here."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite

from cutjoint.doors import door_but, of_type
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.from_file import is_motion_file, motion_from_file
from cutjoint.motion.joint_space import JointChirp, JointSine
from cutjoint.motion.outside import outside_trajectory
from cutjoint.motion.paths import Circle, Hold, Lissajous, PointToPoint, Trapezoidal
from cutjoint.motion.pick_and_place import PickAndPlace
from cutjoint.motion.pose_moves import PoseMove
from cutjoint.motion.swings import SIZE, about_home
from cutjoint.motion.values import Trajectory
from cutjoint.motion.waypoints import JointWaypoints, Waypoints
from cutjoint.motion.winding import Spiral


@dataclass(frozen=True)
class Argument:
    """A number that a trajectory takes; it must be given where there is no default."""

    name: str
    unit: str
    about: str
    default: float | None = None

    def __str__(self) -> str:
        usual = "" if self.default is None else f", default {self.default:g}"
        return f"{self.name}: {self.unit}{self.unit and ' '}{self.about}{usual}"


@dataclass(frozen=True)
class TrajectoryRow:
    """How to make a trajectory that starts at the home posture of a mechanism: make(mechanism, *numbers).

    `arguments` tell the numbers, those with a default last; after them come those of `repeated`, as often as wanted.
    """

    make: Callable[..., Trajectory]
    arguments: tuple[Argument, ...]
    about: str
    repeated: tuple[Argument, ...] = ()

    @property
    def form(self) -> str:
        """What is written after the name, such as `:X,Y,Z[,SECONDS]`."""
        text = ""
        for i, one in enumerate(self.arguments):
            part = f"{',' if i else ':'}{one.name}"
            text += part if one.default is None else f"[{part}]"
        group = ",".join(one.name for one in self.repeated)
        return f"{text},{group}[,{group}...]" if group else text


METRES = tuple(Argument(axis, "m", "from home") for axis in "XYZ")
DEGREES = tuple(Argument(axis, "deg", "from home") for axis in ("RX", "RY", "RZ"))
AMPLITUDE = Argument("AMPLITUDE", "m or rad", "of every actuator about home")


def _seconds(about: str, default: float | None = None) -> Argument:
    return Argument("SECONDS", "s", about, default)


TRAJECTORIES: dict[str, TrajectoryRow] = {
    "about-home": TrajectoryRow(
        about_home,
        (Argument("SIZE", "", "of the way out, in robot sizes or rad", SIZE), _seconds("for out and back", 1.0)),
        "a small motion out and back, of the tool or the actuators, as far as the robot can",
    ),
    "hold": TrajectoryRow(Hold.at_home, (_seconds("of rest", 1.0),), "rest at home"),
    "line": TrajectoryRow(
        PointToPoint.from_home,
        (*METRES, _seconds("for the way", 1.0)),
        "a straight line from rest to rest with the least jerk",
    ),
    "trapezoidal": TrajectoryRow(
        Trapezoidal.from_home,
        (*METRES, _seconds("for the way", 1.0)),
        "a straight line from rest to rest with ramps of the speed",
    ),
    "waypoints": TrajectoryRow(
        Waypoints.from_home, (_seconds("for the way"),), "straight legs with blends, from rest to rest", METRES
    ),
    "pick-and-place": TrajectoryRow(
        PickAndPlace.from_home,
        (
            _seconds("for a cycle", 1.0),
            Argument("WIDTH", "m", "across, 0 for 305 mm or what the robot reaches of it", 0.0),
        ),
        "up, across, down, and back, with round corners",
    ),
    "circle": TrajectoryRow(
        Circle.through_home,
        (Argument("RADIUS", "m", "of the circle"), _seconds("for a turn", 2.0)),
        "a circle through home at constant speed",
    ),
    "lissajous": TrajectoryRow(
        Lissajous.through_home,
        (Argument("WIDTH", "m", "across"), Argument("HEIGHT", "m", "up"), _seconds("for all of it", 2.0)),
        "a figure of eight through home",
    ),
    "spiral": TrajectoryRow(
        Spiral.from_home,
        (Argument("RADIUS", "m", "at the end"), Argument("TURNS", "", "of it", 3.0), _seconds("for the way", 2.0)),
        "a spiral from home outwards, from rest to rest",
    ),
    "helix": TrajectoryRow(
        Spiral.helix_from_home,
        (
            Argument("RADIUS", "m", "of it"),
            Argument("RISE", "m", "along z"),
            Argument("TURNS", "", "of it", 3.0),
            _seconds("for the way", 2.0),
        ),
        "a helix about z from home, from rest to rest",
    ),
    "turn": TrajectoryRow(
        PoseMove.turn_at_home,
        (*DEGREES, _seconds("for the way", 1.0)),
        "a turn about one axis from rest to rest with the least jerk",
    ),
    "pose": TrajectoryRow(
        PoseMove.from_home,
        (*METRES, *DEGREES, _seconds("for the way", 1.0)),
        "a straight line and a turn about one axis at once",
    ),
    "joint-waypoints": TrajectoryRow(
        JointWaypoints.from_home,
        (_seconds("for the way"),),
        "way-points of the actuators with blends, from rest to rest",
        (Argument("Q1,..,QN", "m or rad", "of every actuator from home"),),
    ),
    "joint-sine": TrajectoryRow(
        JointSine.from_home, (AMPLITUDE, Argument("HZ", "Hz", "of the sine", 1.0)), "all actuators along a sine"
    ),
    "joint-chirp": TrajectoryRow(
        JointChirp.from_home,
        (
            AMPLITUDE,
            Argument("HZ1", "Hz", "at the start", 0.1),
            Argument("HZ2", "Hz", "at the end", 2.0),
            _seconds("for the way", 10.0),
        ),
        "all actuators along a sine of rising frequency, from rest to rest",
    ),
}


def describe(name: str) -> str:
    """How the trajectory called `name` is written, what it is, and its numbers with their units."""
    row = TRAJECTORIES[name]
    return f"{name}{row.form} ({row.about}; {', '.join(map(str, (*row.arguments, *row.repeated)))})"


@door_but("mechanism")
def trajectory(spec: str, mechanism: Mechanism) -> Trajectory:
    """The trajectory that `spec`, NAME or NAME:NUMBER,NUMBER, names, from the home posture of `mechanism` on; or the
    one that the file of this path tells.

    Raises:
        UnknownNameError: no such trajectory.
        InputError: its numbers are wrong, or the mechanism cannot follow such a one.
        UnreachableError: it is fitted to what the mechanism reaches, and that is nothing.
    """
    if not hasattr(mechanism, "home"):
        of_type("mechanism of trajectory", mechanism, Mechanism)
    name = spec.partition(":")[0]
    if name not in TRAJECTORIES and is_motion_file(spec):
        return motion_from_file(spec, mechanism)
    if name not in TRAJECTORIES:
        return outside_trajectory(spec, mechanism, list(TRAJECTORIES))
    return TRAJECTORIES[name].make(mechanism, *numbers_of(spec))


def numbers_of(spec: str) -> list[float]:
    """The numbers behind the name in `spec`, the name of a row of `TRAJECTORIES`; defaults where they are left out.

    Raises:
        InputError: they are wrong, too few or too many.
    """
    name, _, rest = spec.partition(":")
    row = TRAJECTORIES[name]
    wrong = f"'{spec}' is no trajectory; write {describe(name)}"
    words = rest.split(",") if rest else []
    given = [_number(word, wrong) for word in words]
    left = [one.default for one in row.arguments[len(given) :] if one.default is not None]
    found = given + left
    if len(found) < len(row.arguments) or (len(given) > len(row.arguments)) != bool(row.repeated):
        raise InputError(f"{wrong}. Found {len(given)} numbers")
    return found


def _number(word: str, wrong: str) -> float:
    try:
        number = float(word)
    except ValueError as error:
        raise InputError(f"{wrong}. '{word.strip()}' is no number") from error
    if not isfinite(number):
        raise InputError(f"{wrong}. '{word.strip()}' is not finite")
    return number
