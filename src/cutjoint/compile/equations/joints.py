"""What the compiler asks about a type of joint: of which elementary joints it is made, and how these move.

A row of `JOINTS` is a type, and the elementary joints that stand in its place, one behind the other.  Rates of
elementary joints (`u` in this room) are scalars along axes, or components in world axes, where they enter as they
stand; Pinocchio's own velocities `v` are in the moving body's axes and converted at the border
(`cutjoint.compile.equations.coordinates`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum

from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import (
    IDENTITY,
    Matrix,
    Vector,
    about,
    add,
    column,
    cross,
    dot,
    from_quaternion,
    product,
    scale,
    transposed,
    turn,
)
from cutjoint.description.model import JointType


class StepKind(Enum):
    """Elementary joints.

    Attributes:
        about: what moves.
        coordinates, rates: how many it has of these.
        slides: whether its rates are velocities; else they are angular velocities.
        in_world: whether they are components in world axes; else they are along axes that the parent carries.
    """

    # about, coordinates, rates, slides, in world axes
    TURN = "a turn about an axis", 1, 1, False, False
    SLIDE = "a slide along an axis", 1, 1, True, False
    SPIN = "a turn about z, given by its cosine and sine", 2, 1, False, False
    FLAT = "translations along x and y of the joint's placement", 2, 2, True, False
    SHIFT = "free translation", 3, 3, True, True
    BALL = "free rotation, a unit quaternion x, y, z, w", 4, 3, False, True

    def __init__(self, about: str, coordinates: int, rates: int, slides: bool, in_world: bool) -> None:
        self.about, self.coordinates, self.rates = about, coordinates, rates
        self.slides, self.in_world = slides, in_world

    @property
    def lengths(self) -> int:
        """How many of its first coordinates and rates are lengths."""
        return self.rates if self.slides else 0

    @property
    def has_axis(self) -> bool:
        """Whether the model says along which axis it is."""
        return self.coordinates == 1


JOINTS: Mapping[JointType, tuple[StepKind, ...]] = {
    JointType.REVOLUTE: (StepKind.TURN,),
    JointType.CONTINUOUS: (StepKind.TURN,),
    JointType.PRISMATIC: (StepKind.SLIDE,),
    JointType.UNIVERSAL: (StepKind.TURN, StepKind.TURN),
    JointType.SPHERICAL: (StepKind.BALL,),
    JointType.PLANAR: (StepKind.FLAT, StepKind.SPIN),
    JointType.FLOATING: (StepKind.SHIFT, StepKind.BALL),
}
"""A type -> its elementary joints, which share its coordinates and rates in this order."""


@dataclass(frozen=True, eq=False)
class TreeStep:
    """An elementary joint in the tree.

    Attributes:
        parent: step that carries it; -1 for the world.
        rotation, translation: its constant placement there.
        kind: what moves.
        axis: along which of its own axes (0, 1, 2), where it is along one.
        q, u: its first coordinate and first rate.
        body: last step of the joint that it is part of; the joint's body moves with that one.
    """

    parent: int
    rotation: Matrix
    translation: Vector
    kind: StepKind
    axis: int
    q: int
    u: int
    body: int

    def displaced(self, placed: Matrix, offset: Vector, q: Sequence[Number]) -> tuple[Matrix, Vector]:
        """Rotation and offset from the parent's origin, both in world axes, once it has moved.

        Args:
            placed, offset: the same before it moves.
            q: configuration.
        """
        own = q[self.q : self.q + self.kind.coordinates]
        match self.kind:
            case StepKind.TURN:
                return product(placed, about(self.axis, functions.sin(own[0]), functions.cos(own[0]))), offset
            case StepKind.SPIN:
                return product(placed, about(self.axis, own[1], own[0])), offset
            case StepKind.BALL:
                return product(placed, from_quaternion(own[0], own[1], own[2], own[3])), offset
            case StepKind.SLIDE:
                return placed, add(offset, scale(own[0], column(placed, self.axis)))
            case StepKind.FLAT:
                return placed, add(offset, turn(placed, (own[0], own[1], 0.0)))
            case StepKind.SHIFT:
                return placed, add(offset, turn(placed, (own[0], own[1], own[2])))

    def directions(self, placed: Matrix) -> tuple[Vector, ...]:
        """What its rates are along or about, in world axes."""
        if self.kind.in_world:
            return IDENTITY
        first = 0 if self.kind is StepKind.FLAT else self.axis
        return tuple(column(placed, first + k) for k in range(self.kind.rates))

    def coordinate_rates(self, placed: Matrix, q: Sequence[Number], u: Sequence[Number]) -> tuple[Number, ...]:
        """Time derivative of its coordinates."""
        own, rates = q[self.q : self.q + self.kind.coordinates], u[self.u : self.u + self.kind.rates]
        match self.kind:
            case StepKind.TURN | StepKind.SLIDE | StepKind.FLAT:
                return tuple(rates)
            case StepKind.SPIN:
                return -rates[0] * own[1], rates[0] * own[0]
            case StepKind.SHIFT:
                return turn(transposed(placed), (rates[0], rates[1], rates[2]))
            case StepKind.BALL:
                half = scale(0.5, turn(transposed(placed), (rates[0], rates[1], rates[2])))
                vector: Vector = (own[0], own[1], own[2])
                return *add(scale(own[3], half), cross(half, vector)), -dot(half, vector)
