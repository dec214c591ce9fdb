"""A small motion about home that any robot can follow: out and back, from rest to rest, in every freedom at once.

What is moved is the tool, along all coordinates of its task, where the task is sound: as many coordinates as actuators,
and home far from a singular posture.  Elsewhere it is the actuators.  Where the robot cannot follow, because a joint
limit or a singularity is in the way, directions are turned round and ways are halved until it can; an actuator that
cannot move either way rests.  The motion tells in `chosen` what became of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.errors import (
    ClosureError,
    CutjointError,
    DynamicsError,
    InputError,
    LimitError,
    SingularError,
    UnreachableError,
)
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.motion.following import size_of
from cutjoint.motion.pose_moves import PoseMove
from cutjoint.motion.reference import Reference
from cutjoint.motion.timing import Progress, there_and_back
from cutjoint.motion.values import JointMotion
from cutjoint.reprs import line

SIZE = 0.03
"""How far it goes out if nothing is said: in sizes of the robot, or radians."""
SOUND = 0.02
"""Least over largest singular value of the task's Jacobian at home, from which the tool is led."""
LOSS = 0.5
"""What the way may leave of the least singular value at home."""
GROWTH = 4.0
"""By how much the inertia at an actuator may grow on the way; it grows beyond bounds towards a parallel singularity."""
PARTS = (1.0, 0.5, 0.25, 1 / 16, 1 / 64, 1 / 256)
"""Of the way, tried one after the other."""
NAME = "about home"
_CANNOT = (UnreachableError, SingularError, ClosureError, DynamicsError)
"""A way that leads nowhere, of which another may do."""


@dataclass(frozen=True, eq=False)
class ToolSwing(PoseMove):
    """The tool by a way and a turn, see `PoseMove`, and back again.

    Attributes:
        chosen: what was chosen and why, a sentence each.
    """

    name: str = NAME
    chosen: tuple[str, ...] = ()

    __repr__ = line("start", "by", "turn", "duration", "chosen", by="m", turn="rad", duration="s")

    def progress(self, t: float) -> Progress:
        """How far out it is at time `t` [s]."""
        return there_and_back(t, self.duration)


@dataclass(frozen=True, eq=False)
class JointSwing(Values):
    """The actuators from `centre` out by `way` and back again, shape (n,) each, [m] or [rad], in `duration` [s].

    Attributes:
        chosen: what was chosen and why, a sentence each.
    """

    centre: Array
    way: Array
    duration: float = 1.0
    name: str = NAME
    chosen: tuple[str, ...] = ()

    __repr__ = line("centre", "way", "duration", "chosen", centre="m or rad", way="m or rad", duration="s")

    def __post_init__(self) -> None:
        for name in ("centre", "way"):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), np.size(self.centre))))
        positive("duration", self.duration, "s")

    def at(self, t: float) -> JointMotion:
        """The desired motion at time `t` [s]."""
        s, rate, change = there_and_back(t, self.duration)
        return JointMotion(self.centre + s * self.way, rate * self.way, change * self.way)


def about_home(mechanism: Mechanism, size: float = SIZE, seconds: float = 1.0) -> ToolSwing | JointSwing:
    """The motion for a mechanism; `size` says how far out, in sizes of the robot, or radians.

    Raises:
        InputError: `size` or `seconds` is not > 0, or the robot has no actuator.
        ActuationError: the actuators do not determine the motion.
        SingularError: home is so singular that not even rest can be told.
    """
    positive("size", size, "robot sizes or rad")
    positive("seconds", seconds, "s")
    if mechanism.n == 0:
        raise InputError(f"{mechanism.name} has no actuator that could move it about home")
    mechanism.terms(mechanism.home)
    found = _tool_swing(mechanism, size, seconds)
    return found if isinstance(found, ToolSwing) else _joint_swing(mechanism, size, seconds, found)


# ---- the tool ------------------------------------------------------------------------------------------------------


def _tool_swing(mechanism: Mechanism, size: float, seconds: float) -> ToolSwing | str:
    """The motion of the tool, or why there is none."""
    try:
        task = mechanism.task
    except InputError:
        return "the task of its tool cannot be told"
    if len(task.rows) != mechanism.n:
        many = f"{mechanism.n} actuator{' does' if mechanism.n == 1 else 's do'} not match"
        return f"{many} the {len(task.rows)} coordinates of its tool ({task})"
    sizes = _led(mechanism, mechanism.home)
    if sizes[-1] < SOUND * sizes[0]:
        return "its home is near a posture in which the tool cannot move in some direction"
    length, home, last = size_of(mechanism), mechanism.home, ""
    for part, direction in _directions(len(task.rows)):
        along = np.zeros(6)
        along[list(task.rows)] = part * size * direction
        by, turn = length * (task.basis @ along[:3]), task.basis @ along[3:]
        try:
            goal = ToolSwing(task.home, by, turn, seconds, task.names)
            mechanism.reach(goal.at(0.5 * seconds).position if task.is_of_point else _pose_at(goal), home, free=True)
            there = Reference(goal, mechanism).at(0.5 * seconds).posture
            if _led(mechanism, there)[-1] < LOSS * sizes[-1] or _is_heavier(mechanism, there):
                last = "a singular posture is near"
                continue
        except _CANNOT as error:
            last = _why(error)
            continue
        told = [f"tool {_told(by, turn)} and back"]
        if part < 1.0 or direction.min() <= 0.0:
            told.append(f"not {'further' if part < 1.0 else 'in all coordinates'}: {last}")
        return replace(goal, chosen=tuple(told))
    return f"its tool cannot move about home ({last})"


def _directions(count: int) -> Iterator[tuple[float, Array]]:
    """Parts of the way, and directions of unit length to try: all coordinates, and then each alone."""
    every = np.full(count, count**-0.5)
    for part in PARTS[:4]:
        for side in (1.0, -1.0):
            yield part, side * every
    for part in PARTS[:4]:
        for axis in np.eye(count):
            yield part, axis
            yield part, -axis


def _pose_at(swing: ToolSwing) -> Array:
    motion = swing.at(0.5 * swing.duration)
    pose = np.eye(4)
    assert motion.rotation is not None
    pose[:3, :3], pose[:3, 3] = motion.rotation, motion.position
    return pose


def _led(mechanism: Mechanism, at: Posture) -> Array:
    """Singular values of the task's Jacobian without dimensions, largest first."""
    task, tool, length = mechanism.task, mechanism.tool(at), size_of(mechanism)
    units = np.array([1.0 if one.kind == "rotation" else length for one in mechanism.actuators])
    weights = np.array([length if row < 3 else 1.0 for row in task.rows])
    led = task.towards(tool.pose, task.rows).matrix(tool.rotation) @ tool.frame_jacobian
    return np.linalg.svd(led * units / weights[:, None], compute_uv=False)


def _is_heavier(mechanism: Mechanism, there: Posture) -> bool:
    """Whether the inertia at some actuator is much larger than at home."""
    home, then = (np.diag(mechanism.terms(at).mass) for at in (mechanism.home, there))
    return bool((then > GROWTH * home + 1e-9 * home.max()).any())


def _told(by: Array, turn: Array) -> str:
    way, angle = float(np.linalg.norm(by)), float(np.degrees(np.linalg.norm(turn)))
    words = []
    if way:
        words.append(f"out by {_length(way)} along ({', '.join(f'{x:.2g}' for x in by / way)})")
    if angle:
        axis = turn / np.linalg.norm(turn)
        words.append(f"turned by {angle:.2g} deg about ({', '.join(f'{x:.2g}' for x in axis)})")
    return " and ".join(words)


def _length(metres: float) -> str:
    return f"{metres:.3g} m" if metres >= 0.1 else f"{1e3 * metres:.3g} mm"


# ---- the actuators -------------------------------------------------------------------------------------------------


def _joint_swing(mechanism: Mechanism, size: float, seconds: float, why: str) -> JointSwing:
    """The motion of the actuators; `why` it is not the tool's."""
    length, centre = size_of(mechanism), mechanism.home.q
    units = np.array([1.0 if one.kind == "rotation" else length for one in mechanism.actuators])
    alone, blocked = _alone(mechanism, size * units)
    ways = [part * alone for part in PARTS]
    ways += [row for row in np.diag(alone) if row.any()]  # not all at once: one
    last = next(iter(blocked.values()), "")
    for way in ways if alone.any() else ():
        swing = JointSwing(centre, way, seconds)
        try:
            there = Reference(swing, mechanism).at(0.5 * seconds).posture
        except _CANNOT as error:
            last = _why(error)
            continue
        if _is_heavier(mechanism, there):
            last = "a singular posture is near"
            continue
        return JointSwing(centre, way, seconds, chosen=_of_joints(mechanism, way, why, blocked, last))
    told = f"actuators at rest at home: none can move out and back ({last})"
    return JointSwing(centre, np.zeros(mechanism.n), seconds, chosen=(told,))


def _alone(mechanism: Mechanism, most: Array) -> tuple[Array, dict[str, str]]:
    """How far every actuator can go alone and come back, shape (n,), and why those that cannot do not."""
    home, found, blocked = mechanism.home, np.zeros(mechanism.n), {}
    for k, actuator in enumerate(mechanism.actuators):
        for way in (side * part * float(most[k]) for part in PARTS for side in (1.0, -1.0)):
            out = home.q.copy()
            out[k] += way
            try:
                mechanism.close(home.q, mechanism.close(out, home))
            except _CANNOT as error:
                blocked[actuator.name] = _why(error)
                continue
            found[k] = way
            blocked.pop(actuator.name, None)
            break
    return found, blocked


def _of_joints(mechanism: Mechanism, way: Array, why: str, blocked: dict[str, str], last: str) -> tuple[str, ...]:
    turning = np.array([one.kind == "rotation" for one in mechanism.actuators])
    amounts = []
    for which, unit in ((turning, "rad"), (~turning, "m")):
        if (moved := np.abs(way[which])).any():
            least = f"{moved[moved > 0.0].min():.3g} to " if np.ptp(moved[moved > 0.0]) > 1e-9 * moved.max() else ""
            amounts.append(f"{least}{moved.max():.3g} {unit}")
    count = int(np.count_nonzero(way))
    who = "all actuators" if count == mechanism.n else f"{count} of {mechanism.n} actuators"
    told = [f"{who} out by {' and '.join(amounts)} and back, since {why}"]
    if blocked:
        names = list(blocked)
        shown = ", ".join(names[:4]) + (f" and {len(names) - 4} more" if len(names) > 4 else "")
        told.append(f"at rest: {shown}, which cannot go out and back ({blocked[names[0]]})")
    elif count < mechanism.n:
        told.append(f"the others rest: {last}")
    return tuple(told)


def _why(error: CutjointError) -> str:
    """Why a way cannot be followed, in a few words."""
    if isinstance(error, LimitError):
        (lower, upper), value = error.bounds, error.value
        return f"{error.joint} would be at {value:.4g}, beyond its limits {lower:.4g} to {upper:.4g}"
    if isinstance(error, SingularError) or isinstance(error.__cause__, SingularError):
        return "a singular posture is near"
    return "the loops or the reach do not let it"
