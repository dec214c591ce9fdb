"""Coordinates by name: the actuated ones as they are given, and all of those that a posture stores."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from textwrap import fill
from typing import Literal

import numpy.typing as npt

from cutjoint.arrays import Array, Values, as_vector, readonly
from cutjoint.doors import described, door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import clipped, line

COLUMNS = 80
"""Longest line of a posture in words."""
SHOWN = 1e-12
"""Smaller numbers, [m] or [rad], are shown as 0: rounding, as a rule."""

ActuatedCoordinates = npt.ArrayLike | Mapping[str, float]
"""Coordinates of all actuators, [m] or [rad]: in their order, shape (n,), or by name."""


@door
@dataclass(frozen=True)
class Actuator:
    """An actuated joint: its name and whether it turns or slides."""

    name: str
    kind: Literal["rotation", "translation"]

    __repr__ = line("name", "kind", "unit")

    @property
    def unit(self) -> str:
        """Unit of the coordinate."""
        return "rad" if self.kind == "rotation" else "m"

    @property
    def effort_unit(self) -> str:
        """Unit of the effort."""
        return "N m" if self.kind == "rotation" else "N"


def actuated_values(q: ActuatedCoordinates, actuators: tuple[Actuator, ...]) -> Array:
    """Coordinates of the actuators in their order, shape (n,).

    Raises:
        UnknownNameError: a name is none of an actuator.
        InputError: an actuator is missing, wrong shape, no numbers or not finite.
    """
    return as_vector("q", in_order(q, actuators), len(actuators))


def in_order(q: ActuatedCoordinates, actuators: tuple[Actuator, ...]) -> npt.ArrayLike:
    """Coordinates by name as the list of them; what is no mapping comes back as it is.

    Raises:
        UnknownNameError, InputError: a name is none of an actuator, or one is missing.
    """
    if not isinstance(q, Mapping):
        return q
    names = [actuator.name for actuator in actuators]
    for name in q:
        if name not in names:
            raise UnknownNameError("actuator", str(name), names)
    missing = [name for name in names if name not in q]
    if missing:
        raise InputError(
            f"q must give every actuator, and lacks {', '.join(missing)}; to move only some, take the others from a "
            f'posture `at`, as in {{**at.actuated, "{names[0]}": 0.1}}'
        )
    return [q[name] for name in names]


@dataclass(frozen=True)
class Stored:
    """Coordinates that a posture stores in `q_full` under one name.

    Attributes:
        name: of the joint.
        units: `m` or `rad` of each coordinate, or nothing.
        start, count: where they are stored.
        read: makes coordinates of what is stored, where these are not the same numbers; a function of a module, since
            postures pickle it.
    """

    name: str
    units: tuple[str, ...]
    start: int
    count: int = 1
    read: Callable[[Array], Array] | None = None

    __repr__ = line("name", "units", "start", "count")

    def of(self, q_full: Array) -> float | Array:
        """A number, or the list of coordinates, shape (coordinates,)."""
        if self.count == 1 and self.read is None:
            return float(q_full[self.start])
        own = q_full[self.start : self.start + self.count]
        return readonly(own if self.read is None else self.read(own))


@dataclass(frozen=True)
class Layout(Values):
    """What the numbers of a robot's postures are called.  All of its postures share one.

    Attributes:
        robot: its name.
        actuators: names of the numbers of `q`.
        passive: names of what `q_full` has besides.
    """

    robot: str
    actuators: tuple[Actuator, ...]
    passive: tuple[Stored, ...]

    __repr__ = line("robot", "names")

    @classmethod
    def of_numbers(cls, robot: str, actuators: tuple[Actuator, ...], stored: tuple[str, ...]) -> Layout:
        """Of a robot whose `q_full` has the numbers `stored`, each a name with its unit, as `x[m]`."""
        pairs = [one.removesuffix("]").partition("[") for one in stored]
        return cls(robot, actuators, tuple(Stored(name, (unit,), index) for index, (name, _, unit) in enumerate(pairs)))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """All names, the actuators first."""
        return (*self._actuated, *(name for name in self._stored if name not in self._actuated))

    def value(self, name: str, q: Array, q_full: Array) -> float | Array:
        """What is called `name`.

        Raises:
            UnknownNameError: nothing is.
            InputError: that is no name.
        """
        if not isinstance(name, str):
            raise InputError(f"a coordinate of {self.robot} has a name, found {described(name)}")
        if (index := self._actuated.get(name)) is not None:
            return float(q[index])
        if (stored := self._stored.get(name)) is not None:
            return stored.of(q_full)
        raise UnknownNameError(f"coordinate of {self.robot}", str(name), self.names)

    def rows(self, q: Array, q_full: Array) -> list[tuple[str, str, str]]:
        """All names, with values and units, and whether they are actuated."""
        found = []
        for name in self.names:
            actuated = name in self._actuated
            units = (self.actuators[self._actuated[name]].unit,) if actuated else self._stored[name].units
            numbers = _with_units(self.value(name, q, q_full), units)
            found.append((clipped(name), numbers, "actuated" if actuated else ""))
        return found

    def words(self, q: Array, q_full: Array) -> str:
        """All names with values and units, a line each."""
        width = min(30, max((len(clipped(name)) for name in self.names), default=0))
        lines = []
        for name, values, actuated in self.rows(q, q_full):
            numbers = f"{values}  {actuated}".rstrip()
            begin = f"  {name:<{width}}  "
            indent = " " * min(len(begin), width + 4)
            lines.append(fill(numbers, COLUMNS, initial_indent=begin, subsequent_indent=indent, break_long_words=False))
        return "\n".join(lines)

    @cached_property
    def _actuated(self) -> dict[str, int]:
        return {actuator.name: index for index, actuator in enumerate(self.actuators)}

    @cached_property
    def _stored(self) -> dict[str, Stored]:
        return {one.name: one for one in self.passive}


def _with_units(value: float | Array, units: tuple[str, ...]) -> str:
    """Numbers, each run of the same unit with it at the end."""
    numbers = [value] if isinstance(value, float) else value.tolist()
    said = []
    for index, (number, unit) in enumerate(zip(numbers, units, strict=True)):
        last = index + 1 == len(units) or units[index + 1] != unit
        shown = number if abs(number) >= SHOWN else 0.0
        said.append(f"{shown:.6g}" + (f" {unit}" if last and unit else ""))
    return ", ".join(said)
