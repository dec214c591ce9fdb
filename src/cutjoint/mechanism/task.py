"""The task of a robot: which motions of its tool are led, in which axes; and what a target asks of them.

A task is some of x, y, z, rx, ry, rz.  Its coordinates are the tool's position along the axes of the task [m], and the
rotation vector [rad] by which the tool is turned away from how it stands at home, in the same axes.  Where only some
rotations are led, with Q the rotation since home and Q_d the wanted one, Q = Q_d E, and what is asked of E is that its
quaternion has no part along the led axes:

- all three: Q = Q_d;
- two, such as rx and ry: the third axis, carried by the tool, points where it should (tilt, whatever the torsion);
- one, such as rz: the turn about it is as wanted, whatever the swing.

With q, w the quaternion of E in the task's axes A, and (v, u) the velocity and angular velocity of the tool, the error
e = (A' (p - p_d), 2 q), of which the led rows are kept, changes by

    e_dot = C ((v, u) - (v_d, u_d)),    C = diag(A', (w 1 - [q]) A' Q_d')

After I. A. Bonev, D. Zlatanov, C. M. Gosselin: Advantages of the modified Euler angles in the design and control of
PKMs (2002), for tilt and torsion; and J. S. Dai: Euler-Rodrigues formula variations, quaternion conjugation and
intrinsic connections.  Mech. Mach. Theory 92 (2015) 144-152, for the rates of quaternions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from math import hypot, isfinite
from typing import Literal, TypeAlias

import numpy as np

from cutjoint.arrays import Array, Frozen, as_vector
from cutjoint.doors import door, door_but
from cutjoint.errors import InputError
from cutjoint.mechanism.pose import FORMS, Pose, PoseLike
from cutjoint.mechanism.rotations import Quaternion, crossing, quaternion_of, turned, vector_of
from cutjoint.reprs import line, one_line, short

NAMES = ("x", "y", "z", "rx", "ry", "rz")
Axes = Literal["world", "tool"]
TargetLike: TypeAlias = PoseLike | Mapping[str, float]
"""What tells a target: a point (3,) [m], a pose (see `FORMS`), or coordinates by name, [m] and [rad]."""


@dataclass(frozen=True, eq=False)
class Target(Frozen):
    """What is asked of the tool.

    Attributes:
        pose: the wanted pose; what is not asked for is as at home.
        led: numbers of the rows (of the six) that lead the robot there.
        asked: numbers of the rows that must be met.
        names: what was given by name, for messages; empty where it was a point or a pose.
    """

    pose: Pose
    led: tuple[int, ...]
    asked: tuple[int, ...]
    names: Mapping[str, float] = field(default_factory=dict)

    def __repr__(self) -> str:
        given = {**dict.fromkeys(NAMES[:3], "m"), **dict.fromkeys(NAMES[3:], "rad")}
        named = [f"{name}={short(value, given.get(name, ''))}" for name, value in self.names.items()]
        return one_line(
            "Target", named or [f"{x}={short(value, 'm')}" for x, value in zip("xyz", self.pose.position, strict=True)]
        )

    def __str__(self) -> str:
        if self.names:
            return ", ".join(f"{name} {value:.6g}" for name, value in self.names.items())
        place = f"{np.round(self.pose.position, 6).tolist()} m"
        return place if self.asked == _POINT else f"the pose at {place}"


@door
@dataclass(frozen=True, eq=False)
class Task(Frozen):
    """Which motions of a tool are led.

    Attributes:
        names: some of `NAMES`, in that order.
        home: pose of the tool at home.
        robot: its name, for messages.
        axes: "world", or "tool": the tool's axes at home, from where it is then.
    """

    names: tuple[str, ...]
    home: Pose
    robot: str
    axes: Axes = "world"

    __repr__ = line("names", "robot", "axes", "home")

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """Numbers of its rows."""
        return tuple(NAMES.index(name) for name in self.names)

    @property
    def units(self) -> tuple[str, ...]:
        """Unit of every coordinate."""
        return tuple("m" if row < 3 else "rad" for row in self.rows)

    @cached_property
    def is_of_point(self) -> bool:
        """Whether the tool point says all that is led."""
        return all(row < 3 for row in self.rows)

    @property
    def basis(self) -> Array:
        """Its axes as columns, shape (3, 3)."""
        return self.home.rotation if self.axes == "tool" else _UNIT

    def __str__(self) -> str:
        return " ".join(self.names) + (" in the axes of the tool at home" if self.axes == "tool" else "")

    # ---- coordinates -----------------------------------------------------------------------------------------------

    @door
    def coordinates(self, pose: Pose) -> Array:
        """Coordinates of a pose of the tool, shape (rows,), [m] and [rad]."""
        basis = self.basis
        start = self.home.position if self.axes == "tool" else np.zeros(3)
        place = basis.T @ (pose.position - start)
        turn = np.zeros(3)
        led = [row - 3 for row in self.rows if row >= 3]
        if led:
            since = basis.T @ pose.rotation @ self.home.rotation.T @ basis
            turn = vector_of(since)
            if len(led) == 2:
                (free,) = {0, 1, 2}.difference(led)
                turn = _tilt(since[:, free], free)
            elif len(led) == 1:
                quaternion = quaternion_of(since)
                turn[led[0]] = 2.0 * np.arctan2(quaternion[led[0]], quaternion[3])
        return np.concatenate([place, turn])[list(self.rows)]

    def pose(self, coordinates: Mapping[str, float] | Sequence[float] | Array) -> Pose:
        """The pose with these coordinates, by name or in the order of `names`; the others are as at home.

        Raises:
            InputError: not the right number of them, or not finite.
        """
        if not isinstance(coordinates, Mapping):
            coordinates = dict(zip(self.names, as_vector("coordinates", coordinates, len(self.names)), strict=True))
        unknown = [name for name in coordinates if name not in NAMES]
        if unknown:
            raise InputError(f"'{unknown[0]}' is no coordinate of a tool; they are {', '.join(NAMES)}")
        basis, at_home = self.basis, self.axes == "tool"
        start = np.zeros(3) if at_home else self.home.position
        values = np.concatenate([start, np.zeros(3)])
        for name, value in coordinates.items():
            values[NAMES.index(name)] = _number(name, value)
        place = basis @ values[:3] + (self.home.position if at_home else 0.0)
        return Pose(place, turned(basis @ values[3:]) @ self.home.rotation)

    # ---- targets ---------------------------------------------------------------------------------------------------

    @door_but("given")
    def target(self, given: TargetLike, free: bool = False) -> Target:
        """What `given` asks of the tool: a point (3,), a pose (see `FORMS`), or coordinates by name.

        Args:
            free: whether what is not given may be as it likes.

        Raises:
            InputError: it is none of these; or it does not fix what the robot leads, and the rest is not free.
        """
        if isinstance(given, Mapping):
            return self._by_name(given, free)
        shape = _shape(given)
        if shape == (3,):
            point = as_vector("target", np.asarray(given), 3, "m")
            if not (self.is_of_point or free):
                raise InputError(
                    f"a point does not fix {self.robot}, whose task is {self}: give a pose ({FORMS}) or the "
                    f"coordinates by name, such as {self._example()}; or say that the rest is free (free=True)"
                )
            return Target(Pose(point, self.home.rotation), _POINT, _POINT)
        if shape is not None and shape not in ((7,), (4, 4)):
            raise InputError(
                f"a target is a point (3,), a pose ({FORMS}) or coordinates by name ({self._example()}); found shape "
                f"{shape}"
            )
        pose = Pose.of(given)
        return Target(pose, self.rows, self.rows if free else _ALL)

    def _by_name(self, said: Mapping[str, float], free: bool) -> Target:
        given = {str(name): _number(name, value) for name, value in said.items()}
        missing = [name for name in self.names if name not in given]
        other = [name for name in given if name not in self.names]
        if not given:
            raise InputError(
                f"no coordinate is given to reach; the task of {self.robot} is {self}, as {self._example()}"
            )
        if other and not free:
            raise InputError(
                f"{self.robot} cannot be led by {', '.join(other)}; its task is {self}, so give {self._example()}"
            )
        if missing and not free:
            raise InputError(
                f"{', '.join(given) or 'nothing'} does not fix {self.robot}, whose task is {self}: give also "
                f"{', '.join(missing)}, or say that the rest is free (free=True)"
            )
        pose = self.pose(given)
        rows = tuple(row for row, name in enumerate(NAMES) if name in given)
        return Target(pose, rows, rows, given)

    def _example(self) -> str:
        at_home = np.round(self.coordinates(self.home), 12) + 0.0
        return "{" + ", ".join(f'"{name}": {value:.4g}' for name, value in zip(self.names, at_home, strict=True)) + "}"

    # ---- errors and rates ------------------------------------------------------------------------------------------

    def towards(self, wanted: Pose, rows: Sequence[int]) -> Condition:
        """What `rows` (numbers of the six) ask of the tool at a wanted pose."""
        return Condition(self, wanted, rows)

    def left(self, at: Pose, target: Target) -> tuple[float, float]:
        """How far [m] and by how much turned [rad] a pose is from what a target asks for."""
        missed = self.towards(target.pose, target.asked).error(at.position, at.rotation).tolist()
        pairs = list(zip(target.asked, missed, strict=True))
        return hypot(*(x for row, x in pairs if row < 3)), hypot(*(x for row, x in pairs if row >= 3))


class Condition:
    """Rows of a task at one wanted pose: the error e and the matrix C of the module's head, and their rates.

    The tool is told by its position (3,) and rotation (3, 3) in the world.
    """

    __repr__ = line()

    def __init__(self, task: Task, wanted: Pose, rows: Sequence[int]) -> None:
        basis = task.basis
        self._basis, self._place, self._rows = basis, wanted.position, list(rows)
        self._since = task.home.rotation.T @ basis
        self._into = self._since.T @ wanted.rotation.T  # A' Q_d'
        self._turns = any(row >= 3 for row in rows)

    def error(self, position: Array, rotation: Array) -> Array:
        """What the rows miss, shape (rows,), [m] and [rad]."""
        found = np.zeros(6)
        found[:3] = self._basis.T @ (position - self._place)
        if self._turns:
            x, y, z, _ = self._away(rotation)
            found[3:] = 2.0 * x, 2.0 * y, 2.0 * z
        return found[self._rows]

    def matrix(self, rotation: Array) -> Array:
        """C, shape (rows, 6)."""
        found = np.zeros((6, 6))
        found[:3, :3] = self._basis.T
        if self._turns:
            x, y, z, w = self._away(rotation)
            found[3:, 3:] = np.array(((w, z, -y), (-z, w, x), (y, -x, w))) @ self._into
        return found[self._rows]

    def turning(self, rotation: Array, twist: Array, wanted_twist: Array) -> Array:
        """C_dot ((v, u) - (v_d, u_d)), shape (rows,): what the second derivative of the error has beside
        C times the difference of the accelerations."""
        found, away = np.zeros(6), twist[3:] - wanted_twist[3:]
        if self._turns and away.any():
            *vector, w = self._away(rotation)
            q, rate = np.array(vector), self._into @ away
            half = w * _UNIT - crossing(q)
            q_rate, w_rate = 0.5 * half @ rate, -0.5 * float(q @ rate)
            swept = half @ (self._into @ (crossing(wanted_twist[3:]) @ away))
            found[3:] = w_rate * rate - crossing(q_rate) @ rate - swept
        return found[self._rows]

    def _away(self, rotation: Array) -> Quaternion:
        """E in the axes of the task."""
        return quaternion_of(self._into @ rotation @ self._since)


_UNIT = np.eye(3)
_UNIT.setflags(write=False)
_POINT, _ALL = (0, 1, 2), (0, 1, 2, 3, 4, 5)


def is_pose(given: TargetLike) -> bool:
    """Whether a target is a pose, if it is one at all: neither coordinates by name nor a point."""
    return not isinstance(given, Mapping) and _shape(given) != (3,)


def _shape(given: object) -> tuple[int, ...] | None:
    """Shape of an array or of lists, None of anything else."""
    if not isinstance(given, list | tuple | np.ndarray):
        return None
    try:
        return np.shape(given)
    except ValueError:  # lists of different lengths
        return ()


def _number(name: object, value: float) -> float:
    """A coordinate; raises InputError where it is no finite number."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"coordinate {name} must be a number, found {value!r}") from error
    if not isfinite(number):
        raise InputError(f"coordinate {name} must be finite, found {value!r}")
    return number


def _tilt(carried: Array, axis: int) -> Array:
    """The rotation vector without a part along `axis` that brings that axis to where it is carried."""
    from_axis = np.zeros(3)
    from_axis[axis] = 1.0
    across = np.cross(from_axis, carried)
    size = float(np.linalg.norm(across))
    if size < 1e-300:
        return across
    return np.asarray(across * (np.arctan2(size, carried[axis]) / size))
