"""Where everything is: the placements of all elementary joints at a configuration, as expressions in world axes.

World axes leave zeros for a planar limb where rotated axes would leave rotated zeros.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from cutjoint.compile.equations.inertia import BodyInertia, PointMass
from cutjoint.compile.equations.tree import JointTree
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import IDENTITY, ZERO, Matrix, Vector, add, cross, dot, product, turn

PlacedFrame = tuple[int, Matrix, Vector]
"""A frame: the step that carries it, its rotation and its lever there."""


@dataclass(frozen=True, eq=False)
class Arguments:
    """What of a robot is an argument of the function that is traced; all else is constant.

    Attributes:
        numbers: path into the description (`cutjoint.description.paths`) -> its value.
        bodies, points: bodies with inertias, and masses, that are expressions.
        held_up: bodies of the masses whose weight is compensated, expressions or not.
        placed: step -> its rotation and translation in its parent, where these are expressions.
        frames: `tool`, `cuts.NAME.a`, `cuts.NAME.b` -> that frame, where its place is an expression.
        rotors: rate -> what the rotor behind it weighs there, [kg m2] or [kg], expression or not.
    """

    numbers: Mapping[str, Number] = field(default_factory=dict)
    bodies: tuple[BodyInertia, ...] = ()
    points: tuple[PointMass, ...] = ()
    held_up: tuple[BodyInertia, ...] = ()
    placed: Mapping[int, tuple[Matrix, Vector]] = field(default_factory=dict)
    frames: Mapping[str, PlacedFrame] = field(default_factory=dict)
    rotors: Mapping[int, Number] = field(default_factory=dict)


class TreePose:
    """Placements of all steps for a configuration `q` (expressions, Pinocchio's layout).

    Attributes:
        given: path into the description -> its value, for the numbers that are arguments.
        bodies, points: those of the tree, and further ones whose masses are expressions.
        held_up: bodies of the masses whose weight is compensated.
        rotors: rate -> what the rotor behind it weighs there, [kg m2] or [kg].
        gravity: acceleration of gravity [m/s2].
        rotation: of every step, in world axes.
        placed: rotation before the step's own motion.
        offset: from the parent's origin to the step's, in world axes.
        directions: what the rates of every step are along or about, in world axes.
    """

    def __init__(self, tree: JointTree, q: Sequence[Number], arguments: Arguments | None = None) -> None:
        own = Arguments() if arguments is None else arguments
        self.tree, self.q, self.given, self._frames = tree, tuple(q), own.numbers, own.frames
        self.bodies, self.points, self.rotors = (*tree.bodies, *own.bodies), own.points, own.rotors
        self.held_up = own.held_up
        x, y, z = (self.given.get(f"gravity.{axis}", g) for axis, g in zip("xyz", tree.gravity, strict=True))
        self.gravity: Vector = (x, y, z)
        self.rotation: list[Matrix] = [IDENTITY]
        self.placed: list[Matrix] = [IDENTITY]
        self.offset: list[Vector] = [ZERO]
        self.directions: list[tuple[Vector, ...]] = [()]
        for k, step in enumerate(tree.steps[1:], start=1):
            carrier = self.rotation[step.parent]
            own_rotation, translation = own.placed.get(k, (step.rotation, step.translation))
            placed = product(carrier, own_rotation)
            rotation, offset = step.displaced(placed, turn(carrier, translation), self.q)
            self.placed.append(placed)
            self.rotation.append(rotation)
            self.offset.append(offset)
            self.directions.append(step.directions(placed))

    @property
    def mass(self) -> Number:
        """Mass of everything that moves [kg]."""
        total: Number = self.tree.mass
        for body in self.bodies[len(self.tree.bodies) :]:
            total = total + body.mass
        for point in self.points:
            total = total + point.mass
        return total

    def frame(self, name: str, constant: PlacedFrame) -> PlacedFrame:
        """A frame by its name in `Arguments.frames`, or the constant one where it is no argument."""
        return self._frames.get(name, constant)

    def origin(self, step: int) -> Vector:
        """Origin of a step in the world."""
        total = ZERO
        for k in self.tree.path(step):
            total = add(self.offset[k], total)
        return total

    def lever(self, step: int, lever: Vector) -> Vector:
        """A vector of a step's frame in world axes."""
        return turn(self.rotation[step], lever)

    def columns(self, step: int, lever: Vector) -> list[tuple[int, Vector, Vector]]:
        """(rate, velocity of a point, angular velocity) for every rate that moves the point `lever` [m] of `step`."""
        arm = self.lever(step, lever)
        found: list[tuple[int, Vector, Vector]] = []
        for k in self.tree.path(step):
            here = self.tree.steps[k]
            for rate, along in enumerate(self.directions[k], start=here.u):
                found.append((rate, along, ZERO) if here.kind.slides else (rate, cross(along, arm), along))
            arm = add(arm, self.offset[k])
        return found

    def own_rate(self, k: int, u: Sequence[Number]) -> Vector:
        """What the rates `u` give to a step beside what carries it: a velocity where it slides, else an angular one."""
        rates = u[self.tree.steps[k].u :][: len(self.directions[k])]
        x, y, z = (dot(rates, along) for along in zip(*self.directions[k], strict=True))
        return x, y, z
