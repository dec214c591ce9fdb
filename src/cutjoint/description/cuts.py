"""The types of cut joints.  Each member is a row of the table: the equations that hold, and how it is told.

A cut joins frame A on one body to frame B on another.  What it holds is made of few kinds of equations, which every
reader of them knows: the chain in numbers (`cutjoint.chain.closure`), the compiler in expressions
(`cutjoint.compile.equations.cut_rows`), loop forces, exporters.  So a new type is a row here.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, StrEnum
from typing import Self


class Kind(Enum):
    """What an equation says."""

    POINT = "p_B - p_A = 0"
    SLIDE = "axis of A . (p_B - p_A) = 0"
    LOCK = "rotation vector of R_A' R_B = 0"
    HINGE = "z_A stays along z_B: x_A . z_B = y_A . z_B = 0, stretched from the sine to the angle between z_A and z_B"
    DOT = "an axis of A stays perpendicular to one of B"
    DISTANCE = "|p_B - p_A| = length of the cut"


class Freedom(Enum):
    """A coordinate that a cut leaves free, along which its dampers, friction and springs act."""

    SLIDE = "of B along z of A"
    TURN = "of B about z of A, from x to x"
    TURN_OF_A = "of y of B about x of A"
    TURN_OF_B = "of x about y of B"
    BALL = "the rotation vector of B against A: about the axis that it turns about"


@dataclass(frozen=True)
class Equation:
    """One or three scalar equations between frame A and frame B of a cut.

    Attributes:
        kind: what they say.
        labels: of each row: a displacement along an axis, a rotation about it, or an angle between two axes.
        axes: which axes (0, 1, 2) they are about: that of A (slide), those of A and B (dot).
    """

    kind: Kind
    labels: tuple[str, ...]
    axes: tuple[int, ...] = ()

    @property
    def rows(self) -> int:
        """Number of scalar equations."""
        return len(self.labels)

    @property
    def is_length(self) -> bool:
        """Whether the residual is a length [m]; else an angle [rad]."""
        return self.kind in (Kind.POINT, Kind.SLIDE, Kind.DISTANCE)


def slide(axis: int) -> Equation:
    """No displacement along an axis of frame A."""
    return Equation(Kind.SLIDE, ("xyz"[axis],), (axis,))


def dot(a: int, b: int, label: str) -> Equation:
    """Axis `a` of frame A stays perpendicular to axis `b` of frame B."""
    return Equation(Kind.DOT, (label,), (a, b))


POINT = Equation(Kind.POINT, ("x", "y", "z"))
LOCK = Equation(Kind.LOCK, ("rx", "ry", "rz"))
HINGE = Equation(Kind.HINGE, ("tilt_x", "tilt_y"))
DISTANCE = Equation(Kind.DISTANCE, ("length",))


class CutType(StrEnum):
    """Cut joints, by the motion that they leave free.

    Attributes:
        equations: what it holds, in the order of its rows.
        axes: which axes of the frames it turns about or slides along: `z` that of both, `xy` the x axis of A and the y
            axis of B, empty where none is special.
        about: what it leaves free, in words.
        freedoms: the coordinates of that; nothing can act along others.
    """

    equations: tuple[Equation, ...]
    axes: str
    about: str
    freedoms: tuple[Freedom, ...]

    def __new__(
        cls,
        name: str,
        equations: tuple[Equation, ...] = (),
        axes: str = "",
        about: str = "",
        freedoms: tuple[Freedom, ...] = (),
    ) -> Self:
        member = str.__new__(cls, name)
        member._value_ = name
        member.equations, member.axes, member.about, member.freedoms = equations, axes, about, freedoms
        return member

    FIXED = "fixed", (POINT, LOCK), "", "nothing moves"
    REVOLUTE = "revolute", (POINT, HINGE), "z", "turns about z", (Freedom.TURN,)
    PRISMATIC = "prismatic", (slide(0), slide(1), LOCK), "z", "slides along z", (Freedom.SLIDE,)
    UNIVERSAL = (
        "universal",
        (POINT, dot(0, 1, "twist")),
        "xy",
        "turns about x of A and y of B",
        (Freedom.TURN_OF_A, Freedom.TURN_OF_B),
    )
    SPHERICAL = "spherical", (POINT,), "", "turns about a point", (Freedom.BALL,)
    DISTANCE = "distance", (DISTANCE,), "", "goes about the other at a fixed distance, as on a massless rod"

    @property
    def rows(self) -> int:
        """Number of independent constraints."""
        return sum(one.rows for one in self.equations)

    @property
    def has_length(self) -> bool:
        """Whether a cut of this type needs a length."""
        return DISTANCE in self.equations

    @property
    def labels(self) -> tuple[str, ...]:
        """What each row holds."""
        return tuple(label for one in self.equations for label in one.labels)

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """The kinds of its equations."""
        return tuple(one.kind for one in self.equations)
