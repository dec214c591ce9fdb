"""What a trajectory is: a function from time to the desired motion, which is that of the tool or of the actuators."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from cutjoint.arrays import Array, Frozen, readonly
from cutjoint.doors import described
from cutjoint.errors import InputError
from cutjoint.mechanism.task import NAMES
from cutjoint.reprs import line

POSITION, ROTATION = NAMES[:3], NAMES[3:]


@dataclass(frozen=True, eq=False)
class ToolMotion(Frozen):
    """The tool at one instant, in the world frame.

    Without a rotation the tool keeps its orientation of home, where the robot leads it.

    Attributes:
        position: of the tool point, shape (3,), [m].
        velocity: shape (3,), [m/s].
        acceleration: shape (3,), [m/s2].
        rotation: axes of the tool as columns, shape (3, 3); or None.
        angular_velocity: shape (3,), [rad/s]; given where the rotation is.
        angular_acceleration: shape (3,), [rad/s2]; given where the rotation is.
        given: which coordinates of the task are prescribed, some of x, y, z, rx, ry, rz; None for x, y, z, and the
            rotations where there is one.  Those that are not stay as at home, where the robot leads them.
    """

    position: Array
    velocity: Array
    acceleration: Array
    rotation: Array | None = None
    angular_velocity: Array | None = None
    angular_acceleration: Array | None = None
    given: tuple[str, ...] | None = None

    __repr__ = line(
        position="m", velocity="m/s", acceleration="m/s2", angular_velocity="rad/s", angular_acceleration="rad/s2"
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("position", "velocity", "acceleration"):
            if (shape := self.__dict__[name].shape) != (3,):
                raise InputError(f"a tool motion has a {name} of shape {shape}; it must have shape (3,)")
        turning = (self.rotation, self.angular_velocity, self.angular_acceleration)
        if any(one is not None for one in turning):
            if any(one is None for one in turning):
                raise InputError(
                    "a tool motion that turns has rotation, angular_velocity and angular_acceleration; some are None"
                )
            own = self.__dict__
            for name in ("rotation", "angular_velocity", "angular_acceleration"):
                own[name] = readonly(own[name])
        if self.given is not None:
            _check_given(self.given, self.rotation is not None)

    @property
    def prescribed(self) -> tuple[str, ...]:
        """The coordinates of the task that it prescribes, some of x, y, z, rx, ry, rz."""
        if self.given is not None:
            return self.given
        return POSITION if self.rotation is None else NAMES


@dataclass(frozen=True, eq=False)
class JointMotion(Frozen):
    """The actuators at one instant: coordinates, velocity and acceleration, shape (n,), in the robot's order.

    Attributes:
        q: [m] or [rad].
        v: [m/s] or [rad/s].
        a: [m/s2] or [rad/s2].
    """

    q: Array
    v: Array
    a: Array

    __repr__ = line(q="m or rad", v="m/s or rad/s", a="m/s2 or rad/s2")

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.q.ndim != 1 or not self.q.shape == self.v.shape == self.a.shape:
            found = f"{self.q.shape}, {self.v.shape}, {self.a.shape}"
            raise InputError(f"a joint motion has q, v and a of one shape (n,), found {found}")


@runtime_checkable
class Trajectory(Protocol):
    """A desired motion of the tool or of the actuators, defined for every time from 0 on."""

    @property
    def name(self) -> str:
        """For messages, tables and file names."""

    @property
    def duration(self) -> float:
        """Time after which it repeats or rests [s]."""

    def at(self, t: float) -> ToolMotion | JointMotion:
        """The desired motion at time `t` [s]; the same kind at every time."""


def _check_given(given: tuple[str, ...], turns: bool) -> None:
    if not isinstance(given, tuple | list):
        raise InputError(f"given must be some of {', '.join(NAMES)} in a tuple, found {described(given)}")
    unknown = [name for name in given if name not in NAMES]
    if unknown:
        raise InputError(f"'{unknown[0]}' is no coordinate of a tool; they are {', '.join(NAMES)}")
    if not turns and (turned := [name for name in given if name in ROTATION]):
        raise InputError(f"{', '.join(turned)} cannot be prescribed without a rotation")
