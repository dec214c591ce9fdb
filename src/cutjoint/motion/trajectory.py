"""What a trajectory is: a function from time to position, velocity and acceleration of the tool."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from cutjoint.arrays import Array, Frozen


@dataclass(frozen=True, eq=False)
class ToolMotion(Frozen):
    """The tool at one instant, in the world frame.

    Attributes:
        position: shape (3,), [m].
        velocity: shape (3,), [m/s].
        acceleration: shape (3,), [m/s2].
    """

    position: Array
    velocity: Array
    acceleration: Array


@runtime_checkable
class Trajectory(Protocol):
    """A desired motion of the tool, defined for every time from 0 on."""

    @property
    def name(self) -> str:
        """For messages, tables and file names."""

    @property
    def duration(self) -> float:
        """Time after which it repeats or rests [s]."""

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
