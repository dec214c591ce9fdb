"""Trajectories through way-points at given times, unevenly spaced or not: cubic splines, whose position, velocity and
acceleration are continuous, of points, of poses and of the actuators.

A way starts and ends at rest, where its acceleration steps from and to zero; before, it is at the first way-point, and
after at the last.  A closed way, whose last way-point is the first again, goes round for ever, with a continuous
velocity and acceleration there as well.  Time counts from the first way-point, whatever its own time.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from math import floor

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values, readonly
from cutjoint.doors import door, door_but, of_type
from cutjoint.errors import InputError, WaypointError
from cutjoint.mechanism.pose import Pose, PoseLike
from cutjoint.mechanism.rotations import NOT_QUITE
from cutjoint.motion.rotation_spline import FELT, RotationSpline
from cutjoint.motion.values import JointMotion, ToolMotion
from cutjoint.reprs import line

SAME = 1e-9
"""By how much the last way-point of a closed way may miss the first: [m] or [rad], or beside the range of the
coordinate where that is more than one."""

APART = 1e-12
"""[s]; way-points that follow one another closer than that are at one time."""

LONGEST = 1e9
"""[s]; a way of more than thirty years has a slip of the pen in its times."""

MOST = 1e100
"""What is more, in whatever unit, is no place: its cubics might not be numbers."""

STILL = readonly(np.zeros(3))


@door
@dataclass(frozen=True, eq=False)
class PointSpline(Values):
    """Through `points`, shape (n, 3) [m], at `times`, shape (n,) [s].

    Attributes:
        closed: whether the last point is the first again, and the way goes round.
        given: which coordinates of the task are prescribed; see `ToolMotion`.

    Raises:
        WaypointError: times that do not ascend, numbers that are not finite, or a closed way that is not.
        InputError: the shapes are wrong.
    """

    times: Array
    points: Array
    closed: bool = False
    given: tuple[str, ...] | None = None
    name: str = "point spline"

    __repr__ = line(times="s", points="m")

    def __post_init__(self) -> None:
        _set(self, times=as_times(self.times), points=as_rows("points", self.points, 3))
        _set(self, points=_ended(self.times, self.points, self.closed))
        _ = self._curve

    @cached_property
    def _curve(self) -> _Curve:
        return _Curve(self.times, self.points, self.closed)

    @property
    def duration(self) -> float:
        """From the first way-point to the last [s]."""
        return float(self.times[-1])

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s] since the first way-point."""
        step, s, moves = instant(self.times, t, self.closed)
        position, velocity, acceleration = self._curve.at(step, s)
        if not moves:
            velocity = acceleration = STILL
        return ToolMotion(position, velocity, acceleration, given=self.given)


@door_but("poses")
@dataclass(frozen=True, eq=False)
class PoseSpline(Values):
    """Through `poses` at `times`, shape (n,) [s]: the rotation by `RotationSpline`, half a turn a step at most.

    Attributes:
        poses: rows x, y, z [m], qx, qy, qz, qw, shape (n, 7); made of those or of n poses in any form that `Pose.of`
            takes.  q and -q are the same rotation.
        closed: whether the last pose is the first again, and the way goes round.
        given: which coordinates of the task are prescribed; see `ToolMotion`.

    Raises:
        WaypointError: times that do not ascend, numbers that are not finite, a quaternion that is none, a step of half
            a turn, or a closed way that is not.
        InputError: the shapes are wrong, or something is no pose.
    """

    times: Array
    poses: Array
    closed: bool = False
    given: tuple[str, ...] | None = None
    name: str = "pose spline"

    __repr__ = line(times="s", poses="m, quaternions")

    def __post_init__(self) -> None:
        _set(self, times=as_times(self.times), poses=as_poses(self.poses))
        _set(self, poses=_ended(self.times, self.poses, self.closed))
        _ = self._curve, self._rotation

    @cached_property
    def _curve(self) -> _Curve:
        return _Curve(self.times, self.poses[:, :3], self.closed)

    @cached_property
    def _rotation(self) -> RotationSpline:
        return RotationSpline(self.times, self.poses[:, 3:], self.closed)

    @property
    def duration(self) -> float:
        """From the first way-point to the last [s]."""
        return float(self.times[-1])

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s] since the first way-point."""
        step, s, moves = instant(self.times, t, self.closed)
        motion, rotation = self._curve.at(step, s), self._rotation.at(step, s)
        if not moves:
            motion, rotation = (motion[0], STILL, STILL), (rotation[0], STILL, STILL)
        return ToolMotion(*motion, *rotation, given=self.given)


@door
@dataclass(frozen=True, eq=False)
class JointSpline(Values):
    """Through actuated coordinates `q`, shape (n, actuators) [m] or [rad], at `times`, shape (n,) [s].

    Attributes:
        closed: whether the last coordinates are the first again, and the way goes round.

    Raises:
        WaypointError: times that do not ascend, numbers that are not finite, or a closed way that is not.
        InputError: the shapes are wrong.
    """

    times: Array
    q: Array
    closed: bool = False
    name: str = "joint spline"

    __repr__ = line(times="s", q="m or rad")

    def __post_init__(self) -> None:
        _set(self, times=as_times(self.times), q=as_rows("q", self.q, None))
        _set(self, q=_ended(self.times, self.q, self.closed))
        _ = self._curve

    @cached_property
    def _curve(self) -> _Curve:
        return _Curve(self.times, self.q, self.closed)

    @property
    def duration(self) -> float:
        """From the first way-point to the last [s]."""
        return float(self.times[-1])

    def at(self, t: float) -> JointMotion:
        """The desired motion at time `t` [s] since the first way-point."""
        step, s, moves = instant(self.times, t, self.closed)
        q, v, a = self._curve.at(step, s)
        return JointMotion(q, v, a) if moves else JointMotion(q, np.zeros_like(q), np.zeros_like(q))


class _Curve:
    """A cubic spline through the rows of `values`, shape (n, k), at rest at both ends or closed."""

    def __init__(self, times: Array, values: Array, closed: bool) -> None:
        spans = np.diff(times)[:, None]
        chords = np.diff(values, axis=0) / spans
        if closed:
            around = np.arange(-FELT, len(spans) + FELT) % len(spans)
            rates = _rates(chords[around], spans[around])[FELT : FELT + len(times)]
            rates[-1] = rates[0]
        else:
            rates = _rates(chords, spans)
        first, last = rates[:-1], rates[1:]
        square, cubic = (3.0 * chords - 2.0 * first - last) / spans, (first + last - 2.0 * chords) / spans**2
        self._steps = np.stack([cubic, square, first, values[:-1]], axis=1)

    def at(self, step: int, s: float) -> tuple[Array, Array, Array]:
        """Value, rate and second derivative, shape (k,), `s` [s] into a step."""
        cubic, square, line, start = self._steps[step]
        bent = 3.0 * s * cubic
        return start + s * (line + s * (square + s * cubic)), line + s * (2.0 * square + bent), 2.0 * (square + bent)


def _rates(chords: Array, spans: Array) -> Array:
    """The rates (n, k) at the way-points with which the second derivative is continuous, and which vanish at both ends,
    for mean rates (n - 1, k) over `spans` (n - 1, 1) [s]."""
    from scipy.linalg import solve_banded

    rates = np.zeros((len(spans) + 1, chords.shape[1]))
    if len(spans) > 1:
        pace = 1.0 / spans
        band = np.zeros((3, len(pace) - 1))
        band[0, 1:] = band[2, :-1] = pace[1:-1, 0]
        band[1] = 2.0 * (pace[:-1, 0] + pace[1:, 0])
        rates[1:-1] = solve_banded((1, 1), band, 3.0 * (pace[:-1] * chords[:-1] + pace[1:] * chords[1:]))
    return rates


def instant(times: Array, t: float, closed: bool) -> tuple[int, float, bool]:
    """Where `t` [s] lies among times that start at 0: number of the step, time since its start, whether it moves."""
    whole = float(times[-1])
    moves = closed or 0.0 <= t <= whole
    t = t - floor(t / whole) * whole if closed else min(max(t, 0.0), whole)
    step = min(max(int(np.searchsorted(times, t, side="right")) - 1, 0), len(times) - 2)
    return step, t - float(times[step]), moves


def is_closed(rows: Array) -> bool:
    """Whether the last row of way-points (n, k) is the first again."""
    return bool((np.abs(rows[-1] - rows[0]) <= SAME * np.maximum(1.0, np.ptp(rows, axis=0))).all())


def as_times(values: npt.ArrayLike) -> Array:
    """Times of way-points since the first of them, as a read-only array (n,) [s].

    Raises:
        WaypointError: one is not finite, or not later than the one before by at least a picosecond.
        InputError: they are not two numbers or more.
    """
    times = as_rows("times", np.reshape(np.asarray(values, dtype=np.float64), (-1, 1)), 1)[:, 0]
    late = np.flatnonzero(np.diff(times) < APART)
    if len(late):
        at = int(late[0])
        what = "before" if times[at + 1] < times[at] else "the same as"
        raise WaypointError(
            f"the time {times[at + 1]:.9g} s is {what} that of the way-point before it, {times[at]:.9g} s; expected "
            "ascending times",
            waypoint=at + 1,
        )
    if times[-1] - times[0] > LONGEST:
        late = np.flatnonzero(times - times[0] > LONGEST)
        raise WaypointError(
            f"it is {times[late[0]] - times[0]:.6g} s after the first way-point; {LONGEST:g} s are the most",
            waypoint=int(late[0]),
        )
    return readonly(times - times[0])


def as_rows(name: str, values: npt.ArrayLike, width: int | None) -> Array:
    """`values` as a read-only array (n, width), n at least 2.

    Raises:
        WaypointError: a number is not finite, or beyond `MOST`.
        InputError: it has another shape.
    """
    rows = readonly(values)
    if rows.ndim != 2 or len(rows) < 2 or (width is not None and rows.shape[1] != width) or rows.shape[1] < 1:
        raise InputError(
            f"{name} must have a row a way-point, two or more, of {width or 'some'} numbers; found shape {rows.shape}"
        )
    wrong = np.flatnonzero(~(np.abs(rows) <= MOST).all(axis=1))
    if len(wrong):
        at = int(wrong[0])
        raise WaypointError(f"{name} must be finite, found {rows[at].tolist()}", waypoint=at)
    return rows


def as_poses(given: Iterable[PoseLike]) -> Array:
    """Poses as read-only rows x, y, z [m], qx, qy, qz, qw, shape (n, 7), the quaternions of length 1 and on one side.

    Raises:
        WaypointError: a number is not finite, or a quaternion is none.
        InputError: they are no poses, or less than two.
    """
    if not (isinstance(given, np.ndarray) and given.ndim == 2):
        of_type("poses", given, Iterable)
        found = [_pose(number, one) for number, one in enumerate(given)]
        given = np.reshape([[*one.position, *one.quaternion] for one in found], (-1, 7))
    rows = np.array(as_rows("poses", given, 7))
    sizes = np.linalg.norm(rows[:, 3:], axis=1)
    wrong = np.flatnonzero(np.abs(sizes - 1.0) > 1e3 * NOT_QUITE)
    if len(wrong):
        at = int(wrong[0])
        raise WaypointError(
            f"a quaternion qx, qy, qz, qw must have length 1, found {rows[at, 3:].tolist()} of length {sizes[at]:.6g}",
            waypoint=at,
        )
    rows[:, 3:] /= np.copysign(sizes, rows[:, 3:] @ rows[0, 3:])[:, None]
    return readonly(rows)


def _pose(number: int, given: PoseLike) -> Pose:
    try:
        return Pose.of(given)
    except InputError as error:
        raise WaypointError(str(error), waypoint=number) from error


def _ended(times: Array, rows: Array, closed: bool) -> Array:
    """The rows, of a closed way with the very first as the last."""
    if len(rows) != len(times):
        raise InputError(f"as many way-points as times are wanted, {len(times)}; found {len(rows)}")
    if not closed:
        return rows
    if not is_closed(rows):
        raise WaypointError(
            f"a closed way comes back to its first way-point, {rows[0].tolist()}; found {rows[-1].tolist()}",
            waypoint=len(rows) - 1,
        )
    return readonly(np.concatenate([rows[:-1], rows[:1]]))


def _set(made: object, **values: Array) -> None:
    for name, value in values.items():
        object.__setattr__(made, name, value)
