"""The quickest motion from point to point with bounded jerk, where no way is prescribed: `quickest_moves`.

Each move is from rest to rest.  ruckig finds the quickest one of every actuator within its limits of speed,
acceleration and jerk, and lets all of them arrive together, on a straight line of the actuators where that costs no
time (L. Berscheid, T. Kroeger: Jerk-limited Real-time Trajectory Generation with Arbitrary Target States. Robotics:
Science and Systems XVII, 2021).  The jerk is constant between switches, so the motion is a cubic spline whose knots are
the switches of all actuators: a `JointSpline`, and a motion file, hold it as it is.

Efforts, power and the tool are looked at afterwards, by inverse dynamics.  A move that asks too much is gone slower as
a whole: times longer by k, speeds by 1/k, accelerations by 1/k^2.  That keeps the limits, and is not the quickest then.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.doors import door, of_type
from cutjoint.errors import InputError, RetimingError
from cutjoint.extras import needed
from cutjoint.mechanism import NO_LOADS, Loads, Mechanism, Posture
from cutjoint.motion import JointSpline, Reference
from cutjoint.motion.following import size_of
from cutjoint.motion.splines import is_closed
from cutjoint.retiming import peaks
from cutjoint.retiming.jerk_limited import NOWHERE, quickest_move
from cutjoint.retiming.limit_peaks import peaks_of
from cutjoint.retiming.limits import OF_TOOL, MotionLimits
from cutjoint.retiming.moved import Moved
from cutjoint.retiming.slowing import Slowed
from cutjoint.retiming.terms import has_tool

Told = Callable[[float], None]
LOOKS = 120
"""Instants of each move at which it is looked at, beside those around its peaks."""
KEPT, AIM = 1e-4, 5e-5
"""Beyond a limit by at most this part of it; and what a slower move aims at."""
ROUNDS = 6
SAME = 1e-5
"""By how much the tool may be elsewhere in the same posture, beside the size of the robot, closed along other ways."""
MOST_POINTS = 1000


@dataclass
class _Looked:
    """A motion at some instants."""

    motion: JointSpline
    t: Array
    postures: list[Posture]
    v: Array
    a: Array
    jerk: Array


@door
def quickest_moves(
    robot: Mechanism,
    points: Sequence[Posture | npt.ArrayLike],
    limits: MotionLimits,
    *,
    loads: Loads = NO_LOADS,
    progress: Told | None = None,
) -> Moved:
    """The quickest motion with bounded jerk from home to points one after the other, at rest at each of them.

    Args:
        robot: that moves, from its home.
        points: postures, or coordinates of the actuators, shape (n,) each, [m] or [rad].
        limits: from `limits_of`; every actuator needs one of acceleration and one of jerk.
        loads: that act from outside meanwhile.
        progress: told the part of the work that is done.

    Raises:
        MissingPackageError: ruckig is not installed.
        InputError: no points, not as many coordinates as actuators, a point that is where the robot is already, limits
            of another robot, or an actuator without a limit of acceleration or of jerk.
        LimitError, UnreachableError, ClosureError, SingularError: a joint would go beyond its limits on the way, or the
            loops cannot be kept closed.
        RetimingError: however slow, a limit cannot be kept: it tells which, and where; or a posture among the points is
            on another branch.
    """
    of_type("loads", loads, tuple, list)
    told = progress or (lambda _: None)
    _check_limits(robot, limits)
    places = _places(robot, points)
    wanted = {k: one for k, one in enumerate(points, start=1) if isinstance(one, Posture)}
    ruckig = needed("ruckig", "the quickest motion from point to point")
    moves = [quickest_move(ruckig, start, end, limits) for start, end in pairwise(places)]
    slowed = np.ones(len(moves))
    for i in range(ROUNDS):
        looked = _looked(robot, moves, slowed)
        if i == 0:
            _check_branches(robot, looked, _stops(moves, slowed), wanted)
        used = _asked(robot, looked, limits, loads)
        told(0.2 + 0.7 * i / ROUNDS)
        if peaks.worst_of(used) <= 1.0 + KEPT:
            break
        slowed = _slower(robot, looked, limits, loads, (moves, slowed, used))
    else:
        raise RetimingError(
            f"the moves keep their limits only to {100.0 * peaks.worst_of(used) - 100.0:.2g} %, which is too much",
            limits=[],
            place=0.0,
            t=0.0,
        )
    return _answer(robot, limits, looked, used, (moves, slowed))


def _check_limits(robot: Mechanism, limits: MotionLimits) -> None:
    """That they are of this robot, and bound acceleration and jerk of every actuator."""
    if tuple(one.name for one in limits.actuators) != tuple(one.name for one in robot.actuators):
        raise InputError(f"the limits are those of another robot; limits_of makes those of {robot.name}")
    if any(np.isfinite(limits.of(one)).any() for one in OF_TOOL) and not has_tool(robot):
        raise InputError(f"{robot.name} has no tool, so its speed and acceleration cannot be limited")
    for quantity in ("acceleration", "jerk"):
        free = [one.name for one, most in zip(limits.actuators, limits.of(quantity), strict=True) if np.isinf(most)]
        if free:
            raise InputError(
                f"moves from point to point need a limit of {quantity} of every actuator; {', '.join(free)} "
                f"{'has' if len(free) == 1 else 'have'} none"
            )


def _places(robot: Mechanism, points: Sequence[Posture | npt.ArrayLike]) -> list[Array]:
    """Coordinates of home and of all points."""
    of_type("points", points, Sequence, np.ndarray)
    if not 1 <= len(points) <= MOST_POINTS:
        raise InputError(f"points must be 1 to {MOST_POINTS} places to go to, found {len(points)}")
    places = [np.asarray(robot.home.q)]
    for number, point in enumerate(points, start=1):
        try:
            q = np.asarray(point.q if isinstance(point, Posture) else point, dtype=np.float64).reshape(-1)
        except (TypeError, ValueError) as error:
            raise InputError(f"point {number} must be a posture or {robot.n} numbers") from error
        if q.shape != (robot.n,) or not np.isfinite(q).all():
            raise InputError(f"point {number} must be {robot.n} finite numbers, found {q.tolist()}")
        if np.abs(q - places[-1]).max() <= NOWHERE * max(1.0, float(np.abs(q).max())):
            raise InputError(f"point {number} is where the robot is already, so there is no move to it")
        places.append(q)
    return places


def _joined(name: str, moves: Sequence[tuple[Array, Array]], slowed: Array) -> JointSpline:
    """All moves, one after the other."""
    times, rows = [np.zeros(1)], [moves[0][1][:1]]
    for (own, q), by in zip(moves, slowed.tolist(), strict=True):
        times.append(times[-1][-1] + by * own[1:])
        rows.append(q[1:])
    q = np.concatenate(rows)
    return JointSpline(np.concatenate(times), q, is_closed(q), f"{name}, from point to point")


def _stops(moves: Sequence[tuple[Array, Array]], slowed: Array) -> Array:
    """When each move begins, and the last ends, shape (moves + 1,) [s]."""
    return np.concatenate([[0.0], np.cumsum([by * own[-1] for (own, _), by in zip(moves, slowed, strict=True)])])


def _looked(robot: Mechanism, moves: Sequence[tuple[Array, Array]], slowed: Array) -> _Looked:
    motion, stops = _joined(robot.name, moves, slowed), _stops(moves, slowed)
    parts = [np.linspace(start, end, LOOKS) for start, end in pairwise(stops.tolist())]
    t = np.unique(np.concatenate([motion.times, *parts]))
    t = t[np.concatenate([[True], np.diff(t) > 1e-12 * t[-1]])]
    spline, reference = peaks.spline_of(motion), Reference(motion, robot)
    desired = [reference.at(float(one)) for one in t]
    v, a = np.array([one.v for one in desired]), np.array([one.a for one in desired])
    return _Looked(motion, t, [one.posture for one in desired], v, a, spline(t, 3))


def _check_branches(robot: Mechanism, at: _Looked, stops: Array, wanted: Mapping[int, Posture]) -> None:
    """Whether the actuators lead to the very postures that are wanted.

    Raises:
        RetimingError: at one of them the robot is closed in another way, on another branch.
    """
    for k, posture in wanted.items():
        there = at.postures[int(np.argmin(np.abs(at.t - stops[k])))]
        if has_tool(robot):
            off = np.abs(robot.tool(there).position - robot.tool(posture).position) / size_of(robot)
        else:
            off = np.abs(there.q_full - posture.q_full)
            off = np.minimum(off, np.abs(2.0 * np.sin(0.5 * off)))
        if off.max() > SAME:
            raise RetimingError(
                f"move {k} leads to the wanted coordinates of the actuators, but there the loops are closed in another "
                "way than in the posture of that point; go there by more points",
                limits=[],
                place=0.0,
                t=float(stops[k]),
            )


def _asked(robot: Mechanism, at: _Looked, limits: MotionLimits, loads: Loads) -> peaks.Used:
    """Parts of the limits."""
    return peaks.asked(robot, at.postures, (at.v, at.a, at.jerk), limits=limits, loads=loads)


def _slower(
    robot: Mechanism,
    at: _Looked,
    limits: MotionLimits,
    loads: Loads,
    gone: tuple[Sequence[tuple[Array, Array]], Array, peaks.Used],
) -> Array:
    """By what factors the moves must be slower."""
    moves, slowed, used = gone
    stops, found = _stops(moves, slowed), slowed.copy()
    for k in range(len(moves)):
        here = np.flatnonzero((at.t >= stops[k]) & (at.t <= stops[k + 1]))
        now = {quantity: part[here] for quantity, part in used.items()}
        if peaks.worst_of(now) <= 1.0 + KEPT:
            continue
        some = _Looked(at.motion, at.t[here], [at.postures[i] for i in here], at.v[here], at.a[here], at.jerk[here])
        when = Slowed(robot, some.postures, some.v, some.a, now, limits, loads)
        by = peaks.stretch_that_keeps(lambda longer, when=when: peaks.worst_of(when.by(longer)), 1.0 + AIM)  # type: ignore[misc]
        if not np.isfinite(by):
            raise _never(when.by(1e6), some.t, limits, k)
        found[k] *= by
    return found


def _never(used: peaks.Used, t: Array, limits: MotionLimits, move: int) -> RetimingError:
    """The error where even the slowest move asks too much."""
    quantity = max(used, key=lambda one: float(np.abs(used[one]).max()))
    i, j = np.unravel_index(int(np.argmax(np.abs(used[quantity]))), used[quantity].shape)
    limit, unit = float(limits.of(quantity)[j]), limits.unit(quantity, int(j))
    needs = abs(float(used[quantity][i, j])) * limit
    return RetimingError(
        f"no move {move + 1}, however slow: at t = {t[i]:.4g} s {limits.named(quantity, int(j))} is {needs:.4g} {unit} "
        f"nearly at rest, and its limit is {limit:.4g} {unit}. Raise that limit, or lighten the robot or its load",
        limits=[limits.named(quantity, int(j))],
        place=0.0,
        t=float(t[i]),
    )


def _answer(
    robot: Mechanism,
    limits: MotionLimits,
    at: _Looked,
    used: peaks.Used,
    gone: tuple[Sequence[tuple[Array, Array]], Array],
) -> Moved:
    moves, slowed = gone
    told = list(limits.told)
    stops = _stops(moves, slowed)
    told += [
        f"move {k + 1} is gone slower by a factor of {by:.4g}, so that the other limits are kept; it is not the "
        "quickest then"
        for k, by in enumerate(slowed.tolist())
        if by > 1.0 + 1e-6
    ]
    rows, columns = peaks_of(used, limits, at.t)
    points = np.array([moves[0][1][0], *(q[-1] for _, q in moves)])
    gap = (max(one.gap[0] for one in at.postures), max(one.gap[1] for one in at.postures))
    return Moved(
        robot.name,
        at.motion,
        robot.actuators,
        limits,
        stops,
        points,
        slowed,
        rows,
        len(at.t),
        gap,
        at.t,
        columns,
        tuple(told),
    )
