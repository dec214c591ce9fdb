"""The types of joints of the open tree.  Each member is a row of the table: what every other part asks about a type.

What Pinocchio calls a type is in `cutjoint.chain.joints`, how the compiler turns its rates into velocities in
`cutjoint.compile.equations.joints`.
"""

from __future__ import annotations

from enum import StrEnum
from typing import NamedTuple, Self


class Coordinate(NamedTuple):
    """A coordinate of a joint: its name, and its unit, `m` or `rad`."""

    name: str
    unit: str

    @property
    def is_length(self) -> bool:
        """A length, else an angle."""
        return self.unit == "m"


class JointType(StrEnum):
    """Joints of the open tree.

    Attributes:
        coordinates: what a home posture gives, and the velocities, in their order.
        axes: how many axes it needs: none, `axis`, or `axis2` too.
        limited: whether a file may give it a range.
        urdf, sdf: what those formats call it, None where they have no such joint.
        cut: the type of cut joint that leaves the same motion free, or None.
    """

    coordinates: tuple[Coordinate, ...]
    axes: int
    limited: bool
    urdf: str | None
    sdf: str | None
    cut: str | None

    def __new__(
        cls,
        name: str,
        coordinates: str = "",
        axes: int = 0,
        limited: bool = False,
        urdf: str | None = None,
        sdf: str | None = None,
        cut: str | None = None,
    ) -> Self:
        member = str.__new__(cls, name)
        member._value_ = name
        pairs = (one.removesuffix("]").split("[") for one in coordinates.split())
        member.coordinates = tuple(Coordinate(of, unit) for of, unit in pairs)
        member.axes, member.limited = axes, limited
        member.urdf, member.sdf, member.cut = urdf, sdf, cut
        return member

    # name, coordinates, axes, limited, in URDF, in SDF, as a cut joint
    FIXED = "fixed", "", 0, False, "fixed", "fixed", "fixed"
    REVOLUTE = "revolute", "angle[rad]", 1, True, "revolute", "revolute", "revolute"
    CONTINUOUS = "continuous", "angle[rad]", 1, False, "continuous", "continuous", "revolute"
    PRISMATIC = "prismatic", "travel[m]", 1, True, "prismatic", "prismatic", "prismatic"
    UNIVERSAL = "universal", "first[rad] second[rad]", 2, False, None, "universal", "universal"
    SPHERICAL = "spherical", "roll[rad] pitch[rad] yaw[rad]", 0, False, None, "ball", "spherical"
    PLANAR = "planar", "x[m] y[m] angle[rad]", 1, False, "planar", None, None
    FLOATING = "floating", "x[m] y[m] z[m] roll[rad] pitch[rad] yaw[rad]", 0, False, "floating", None, None

    @property
    def dof(self) -> int:
        """Number of coordinates, and of velocities."""
        return len(self.coordinates)

    @property
    def lengths(self) -> tuple[bool, ...]:
        """Which coordinates are lengths; the others are angles."""
        return tuple(one.is_length for one in self.coordinates)

    @property
    def moves(self) -> bool:
        """Whether it lets its link move at all."""
        return bool(self.coordinates)

    @property
    def turns(self) -> bool:
        """One coordinate, an angle."""
        return self.lengths == (False,)

    @property
    def slides(self) -> bool:
        """One coordinate, a length."""
        return self.lengths == (True,)

    @property
    def single(self) -> bool:
        """One coordinate: what an actuator or a coupling can drive."""
        return self.dof == 1
