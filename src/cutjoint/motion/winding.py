"""Ways of the tool point that wind: spiral and helix, from rest to rest with the least jerk."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from cutjoint.arrays import Array, Values, as_vector, positive, readonly
from cutjoint.doors import door
from cutjoint.errors import InputError
from cutjoint.mechanism import Mechanism
from cutjoint.motion.home import ToolAtHome, orthonormal
from cutjoint.motion.timing import minimum_jerk
from cutjoint.motion.values import ToolMotion
from cutjoint.reprs import line


@door
@dataclass(frozen=True, eq=False)
class Spiral(Values):
    """centre + r(s) (cos(2 pi turns s) first + sin(2 pi turns s) second) + s rise first x second.

    s goes from 0 to 1 with the least jerk, and r evenly from one radius to the other: a spiral of Archimedes where
    there is no rise, a helix where the radii are the same.  At rest at both ends, and C2.

    Attributes:
        centre: of its start, shape (3,), [m].
        radii: at the start and at the end, >= 0, shape (2,), [m].
        rise: along its axis [m].
        turns: how often it goes round; negative the other way.
        duration: [s].
        first, second: orthogonal unit vectors that span its plane, shape (3,).
    """

    centre: Array
    radii: Array
    rise: float
    turns: float
    duration: float
    first: Array = field(default_factory=lambda: readonly([1.0, 0.0, 0.0]))
    second: Array = field(default_factory=lambda: readonly([0.0, 1.0, 0.0]))
    name: str = "spiral"

    __repr__ = line(centre="m", radii="m", rise="m", duration="s")

    def __post_init__(self) -> None:
        for name, size, unit in (("centre", 3, "m"), ("radii", 2, "m"), ("first", 3, ""), ("second", 3, "")):
            object.__setattr__(self, name, readonly(as_vector(name, getattr(self, name), size, unit)))
        if self.radii.min() < 0.0:
            raise InputError(f"radii must be >= 0 [m], found {self.radii.tolist()}")
        if not (isfinite(self.rise) and isfinite(self.turns)):
            raise InputError(f"rise and turns must be finite, found {self.rise!r} and {self.turns!r}")
        positive("duration", self.duration, "s")
        orthonormal("first and second", np.column_stack([self.first, self.second]), 2)

    @classmethod
    @door
    def from_home(cls, mechanism: Mechanism, radius: float, turns: float, seconds: float) -> Spiral:
        """A spiral from where the tool is at home outwards to a radius [m], where the tool moves most easily.

        Raises:
            InputError: the tool can only move along a line, or an argument is out of its range.
        """
        home = ToolAtHome.of(mechanism)
        first, second = home.plane("a spiral")
        return cls(
            home.pose.position, np.array([0.0, positive("radius", radius, "m")]), 0.0, turns, seconds, first, second
        )

    @classmethod
    @door
    def helix_from_home(cls, mechanism: Mechanism, radius: float, rise: float, turns: float, seconds: float) -> Spiral:
        """A helix from where the tool is at home, about an axis along z of the task, by `rise` [m] along it.

        Raises:
            InputError: an argument is out of its range.
        """
        home = ToolAtHome.of(mechanism)
        first, second = home.basis[:, 0], home.basis[:, 1]
        start = home.pose.position - positive("radius", radius, "m") * first
        return cls(start, np.array([radius, radius]), rise, turns, seconds, first, second, name="helix")

    def at(self, t: float) -> ToolMotion:
        """The desired motion at time `t` [s]."""
        s, rate, change = minimum_jerk(t, self.duration)
        widening = self.radii[1] - self.radii[0]
        radius, angle, turn = self.radii[0] + s * widening, 2.0 * np.pi * self.turns * s, 2.0 * np.pi * self.turns
        out = np.cos(angle) * self.first + np.sin(angle) * self.second
        aside = np.cos(angle) * self.second - np.sin(angle) * self.first
        along = self.rise * np.cross(self.first, self.second)
        slope = widening * out + radius * turn * aside + along
        bend = 2.0 * widening * turn * aside - radius * turn * turn * out
        return ToolMotion(self.centre + radius * out + s * along, rate * slope, rate * rate * bend + change * slope)
