"""What acts along coordinates by itself, as expressions; the forces are told in `cutjoint.mechanism.physics`.

All are efforts that overcome it.  `springs` depend on the posture alone and have the `potential`; `friction` is what is
left.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from cutjoint.compile.equations.turning import size_of
from cutjoint.compile.expressions.functions import absolute, is_zero, maximum, minimum, where_less
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import ZERO, Vector, add, dot, scale
from cutjoint.mechanism.physics import JointPhysics

Along = list[tuple[int, Number]]
"""Forces along rates of the tree; a rate may stand there more than once."""


@dataclass(frozen=True, eq=False)
class Coefficients:
    """The numbers of a `JointPhysics`, some of them arguments; a rest and a friction speed have their defaults."""

    damping: Number
    friction: Number
    friction_speed: Number
    stiffness: Number
    rest: Number
    rotor: Number
    gear: Number
    stop_stiffness: Number
    stop_damping: Number

    @classmethod
    def of(cls, owner: str, physics: JointPhysics, given: Mapping[str, Number]) -> Coefficients:
        """Those of a joint or cut; `given` has the arguments by their paths, which begin with the `owner`."""
        own: dict[str, Number] = {name: value for name, value in vars(physics).items() if value is not None}
        own["friction_speed"] = physics.speed
        own.setdefault("rest", 0.0)
        return cls(**{name: given.get(f"{owner}.{name}", value) for name, value in own.items()})

    @property
    def armature(self) -> Number:
        """What the rotor weighs at the joint."""
        return self.gear * self.gear * self.rotor

    @property
    def acts(self) -> bool:
        """Whether it does anything but weigh."""
        return not all(map(is_zero, (self.damping, self.friction, self.stiffness, self.stop_stiffness)))

    @property
    def sticks(self) -> bool:
        """Whether its friction jumps, whatever the arguments are."""
        return not is_zero(self.friction) and is_zero(self.friction_speed)

    def resisted(self, speed: Number) -> Number:
        """Effort that overcomes damper and friction at the speed of one coordinate."""
        rubbed = self.damping * speed
        return rubbed if is_zero(self.friction) else rubbed + self.friction * smooth_sign(speed / self.friction_speed)


def smooth_sign(x: Number) -> Number:
    """The sign of x, below a size of 1 the odd quintic that joins it with two continuous derivatives."""
    inside = maximum(minimum(x, 1.0), -1.0)
    square = inside * inside
    return inside * (1.875 - square * (1.25 - 0.375 * square))


class Acting(Protocol):
    """Something that acts between bodies of a tree, at one pose of it."""

    def springs(self) -> Along:
        """Effort that holds springs and stops."""

    def friction(self, u: list[Number]) -> Along:
        """Effort that overcomes dampers and friction at the rates `u`."""

    def potential(self) -> Number:
        """Energy in springs and stops [J]."""


@dataclass(frozen=True, eq=False)
class OnCoordinate:
    """What acts on one coordinate.

    Attributes:
        row: its speed by the rates of the tree.
        value: of the coordinate, [m] or [rad].
        numbers: what acts.
        lower, upper: stops, where there are any.
    """

    row: Mapping[int, Number]
    value: Number
    numbers: Coefficients
    lower: float | None = None
    upper: float | None = None

    def springs(self) -> Along:
        held = self.numbers.stiffness * (self.value - self.numbers.rest)
        for beyond in self._beyond():
            held = held + self.numbers.stop_stiffness * beyond
        return [(rate, along * held) for rate, along in self.row.items()]

    def friction(self, u: list[Number]) -> Along:
        speed = speed_of(self.row, u)
        lost = self.numbers.resisted(speed)
        for beyond, side in zip(self._beyond(), self._sides(), strict=True):
            # a stop pushes and never pulls
            pressed = absolute(self.numbers.stop_stiffness * beyond)
            pushed = maximum(pressed + self.numbers.stop_damping * (side * speed), 0.0)
            lost = lost + where_less(0.0, pressed, side * (pushed - pressed), 0.0)
        return [(rate, along * lost) for rate, along in self.row.items()]

    def potential(self) -> Number:
        stretched = self.value - self.numbers.rest
        energy = 0.5 * self.numbers.stiffness * stretched * stretched
        for beyond in self._beyond():
            energy = energy + 0.5 * self.numbers.stop_stiffness * beyond * beyond
        return energy

    def _sides(self) -> list[float]:
        if is_zero(self.numbers.stop_stiffness):
            return []
        return [side for side, limit in ((-1.0, self.lower), (1.0, self.upper)) if limit is not None]

    def _beyond(self) -> list[Number]:
        """How far it is beyond each of its stops, negative below the lower one."""
        found: list[Number] = []
        for side in self._sides():
            if side < 0.0 and self.lower is not None:
                found.append(minimum(self.value - self.lower, 0.0))
            elif self.upper is not None:
                found.append(maximum(self.value - self.upper, 0.0))
        return found


@dataclass(frozen=True, eq=False)
class OnBall:
    """What acts on a body that turns about a point.

    Attributes:
        rows: angular velocity by the rates of the tree, in world axes.
        turned: rotation vector, in world axes.
        numbers: what acts.
    """

    rows: Mapping[int, Vector]
    turned: Vector
    numbers: Coefficients

    def springs(self) -> Along:
        held = scale(self.numbers.stiffness, self.turned)
        return [(rate, dot(along, held)) for rate, along in self.rows.items()]

    def friction(self, u: list[Number]) -> Along:
        swing = ZERO
        for rate, along in self.rows.items():
            swing = add(swing, scale(u[rate], along))
        factor = self.numbers.damping
        if not is_zero(self.numbers.friction):
            size = size_of(swing)
            factor = factor + self.numbers.friction * smooth_sign(size / self.numbers.friction_speed) / size
        lost = scale(factor, swing)
        return [(rate, dot(along, lost)) for rate, along in self.rows.items()]

    def potential(self) -> Number:
        return 0.5 * self.numbers.stiffness * dot(self.turned, self.turned)


@dataclass(frozen=True, eq=False)
class OnRow:
    """A spring and a damper on one equation of a cut, or a damper on one rate.

    Attributes:
        row: speed by the rates of the tree.
        open: by how much the equation is not met, [m] or [rad].
        stiffness, damping: of it.
    """

    row: Mapping[int, Number]
    open: Number
    stiffness: Number
    damping: Number

    def springs(self) -> Along:
        return [(rate, along * (self.stiffness * self.open)) for rate, along in self.row.items()]

    def friction(self, u: list[Number]) -> Along:
        lost = self.damping * speed_of(self.row, u)
        return [(rate, along * lost) for rate, along in self.row.items()]

    def potential(self) -> Number:
        return 0.5 * self.stiffness * self.open * self.open


def speed_of(row: Mapping[int, Number], u: list[Number]) -> Number:
    """Speed along a row at the rates `u`."""
    return dot(list(row.values()), [u[rate] for rate in row])
