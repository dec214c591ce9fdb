"""What stays an argument of a chain's compiled functions: names, values, and the ranges that they are compiled for.

A parameter is a path into the description (`cutjoint.description.paths`; one that means several numbers is several
parameters), or in short `payload`, a point mass at the tool point, or the name of a link, whose mass is then the
argument while its centre and the shape of its inertia stay.  Paths joined by `=` are one parameter that stands at all
of them: `cuts.ball1a.b.z = cuts.ball1b.b.z` is the length of two rods that the loops keep equal.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, readonly
from cutjoint.compile.sources.interface import PAYLOAD
from cutjoint.description.model import Inertial, RobotDescription
from cutjoint.description.paths import PLACE, TENSOR, Path, every_path, fields_of, numbers_at
from cutjoint.description.values import number, physics_of, with_values
from cutjoint.errors import InputError, UnknownNameError

Ranges = Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]]
"""Parameter -> its least and largest value."""

Value = TypeVar("Value")
NEIGHBOURHOOD = 0.01
"""Where no range is given: how far around the description's own value, in part of that, of the robot's length, or in
radians."""

_POWERS: Mapping[str, tuple[int, int, int]] = {
    "mass": (1, 0, 0),
    **dict.fromkeys(TENSOR, (1, 2, 0)),
    **dict.fromkeys(PLACE[:3], (0, 1, 0)),
    "damping": (1, 2, -1),
    "friction": (1, 2, -2),
    "friction_speed": (0, 0, -1),
    "stiffness": (1, 2, -2),
    "rotor": (1, 2, 0),
    "stop_stiffness": (1, 2, -2),
    "stop_damping": (1, 2, -1),
    "turning_stiffness": (1, 2, -2),
    "turning_damping": (1, 2, -1),
}
"""Powers of mass, length and time in a number's unit, by its last name; what turns, where it may slide too."""


@dataclass(frozen=True)
class RobotScale:
    """A robot's mass [kg], length [m] and time [s]."""

    mass: float
    length: float
    time: float


class Parameters:
    """The parameters of one robot.

    Args:
        robot: its description.
        names: of what stays an argument.

    Attributes:
        names: of every parameter: its path, one number each, or its short name.
        paths: where those that are paths stand, by name.
        nominal: the description's own values, shape (parameters,).

    Raises:
        UnknownNameError: no such path or link; the nearest one is named.
        InputError: one of them is named twice, there is no tool to carry a payload, or a link has no mass to vary.
    """

    def __init__(self, robot: RobotDescription, names: Sequence[str]) -> None:
        self.robot, self.paths = robot, dict[str, tuple[Path, ...]]()
        found: list[str] = []
        for name in names:
            if self._is_short(name):
                found.append(name)
                continue
            for places in places_of(robot, name):
                self.paths[_named(places)] = places
                found.append(_named(places))
        self.names = tuple(found)
        short = [name for name in found if name not in self.paths]
        taken = [f"links.{name}.{one}" for name in short for one in ("mass", *_TENSORS)]
        taken += [*short, *(str(path) for name in found for path in self.paths.get(name, ()))]
        if len(set(taken)) < len(taken):
            twice = next(name for k, name in enumerate(taken) if name in taken[:k])
            raise InputError(f"parameter {twice} of {robot.name} is given twice")
        self._check_springs()
        self.nominal = readonly([self._nominal(name) for name in found])

    def _check_springs(self) -> None:
        """Raises InputError where a spring may be there of which nobody says where it is at rest."""
        every = [path for places in self.paths.values() for path in places]
        for path in every:
            rest = replace(path, field="rest")
            if path.field != "stiffness" or rest in every or "rest" not in fields_of(self.robot, path.part, path.name):
                continue
            if physics_of(self.robot, path).rest is None:
                raise InputError(
                    f"the spring at {path} of {self.robot.name} has no rest position; name {rest} too, or give it in "
                    "the description"
                )

    def _is_short(self, name: str) -> bool:
        robot = self.robot
        known = {link.name: link for link in robot.links}
        if name == PAYLOAD:
            if robot.tool is None:
                raise InputError(f"{robot.name} has no tool frame to carry a payload")
            return True
        if not isinstance(name, str):
            raise InputError(f"a parameter is the name of a link, 'payload' or a path, found {name!r}")
        if name not in known:
            if "." not in name and name != "gravity":
                raise UnknownNameError("parameter", name, [PAYLOAD, *known])
            return False
        if (known[name].inertial or Inertial(0.0)).mass <= 0.0:
            raise InputError(f"link '{name}' of {robot.name} has no mass to vary; its path is links.{name}.mass")
        return True

    def _nominal(self, name: str) -> float:
        if name in self.paths:
            values = [number(self.robot, path) for path in self.paths[name]]
            if len(set(values)) > 1:
                raise InputError(f"'{name}' of {self.robot.name} is not one number but {values}")
            return values[0]
        inertial = None if name == PAYLOAD else self.robot.link(name).inertial
        return 0.0 if inertial is None else float(inertial.mass)

    @property
    def short(self) -> tuple[str, ...]:
        """Links whose mass is a parameter by their name."""
        return tuple(name for name in self.names if name not in self.paths and name != PAYLOAD)

    @property
    def placing(self) -> tuple[str, ...]:
        """Those on which it depends which postures are closed: places of joints and cuts, and couplings."""
        return tuple(name for name, places in self.paths.items() if any(map(_moves, places)))

    def numbers(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """Values of parameters as values at paths; of the short ones none."""
        return {str(path): value for name, value in values.items() for path in self.paths.get(name, ())}

    def several(self, name: str) -> tuple[str, ...]:
        """The parameters that a name or path means.

        Raises:
            UnknownNameError: it is none, or not all that it means are parameters.
        """
        if name in self.names:
            return (name,)
        try:
            found = tuple(map(_named, places_of(self.robot, name)))
        except UnknownNameError:
            found = ()
        if not found or not set(found) <= set(self.names):
            raise UnknownNameError("parameter of the compiled functions", name, self.names)
        return found

    def columns(self, values: Mapping[str, npt.ArrayLike]) -> dict[str, Array]:
        """Values by name as an array each; what names several has their values along its last axis.

        Raises:
            UnknownNameError: no such parameter.
            InputError: wrong shape, not finite, or negative where that means nothing.
        """
        found: dict[str, Array] = {}
        for name, given in values.items():
            several = self.several(name)
            try:
                array = np.asarray(given, dtype=np.float64)
            except (TypeError, ValueError) as error:
                raise InputError(f"parameter {name} must be numbers, found {given!r}") from error
            if len(several) > 1 and array.shape[-1:] != (len(several),):
                raise InputError(f"parameter {name} must be {len(several)} numbers, found shape {array.shape}")
            for k, one in enumerate(several):
                column = array if len(several) == 1 else array[..., k]
                if not np.isfinite(column).all():
                    raise InputError(f"parameter {one} must be a finite number, found {given!r}")
                if one in self.paths:
                    self.paths[one][0].check(column)
                    if self.paths[one][0].field == "friction_speed" and (column == 0.0).any():
                        raise InputError(
                            f"{one} must be > 0, found 0: true stiction cannot be compiled; take the chain"
                        )
                elif (column < 0.0).any():
                    raise InputError(f"parameter {one} must be a mass >= 0, found {float(column.min()):g}")
                found[one] = column
        return found

    def bounds(self, ranges: Ranges, scale: RobotScale) -> tuple[Array, Array]:
        """Least and largest value of every parameter, shape (parameters,) each: the range that is given, or a
        neighbourhood of the description's own value.

        Raises:
            UnknownNameError: a range of what is no parameter.
            InputError: no range, or upside down.
        """
        around = NEIGHBOURHOOD * self.units(scale)
        low, high = np.array(self.nominal) - around, np.array(self.nominal) + around
        for k, name in enumerate(self.names):
            if name not in self.paths or self.paths[name][0].never_negative:
                low[k] = max(low[k], 0.0)
        for name, pair in ranges.items():
            if not isinstance(pair, Sequence) or len(pair) != 2:
                raise InputError(f"the range of {name} must be its least and its largest value, found {pair!r}")
            where = [self.names.index(one) for one in self.several(name)]
            for bound, given in zip((low, high), pair, strict=True):
                array = np.broadcast_to(np.asarray(given, dtype=np.float64), (len(where),))
                bound[where] = array
                self.columns({name: array if len(where) > 1 else float(array[0])})
            if not (low[where] <= high[where]).all():
                raise InputError(f"the range of {name} is upside down: {pair!r}")
        return low, high

    def units(self, scale: RobotScale) -> Array:
        """Of every parameter a size that is large, shape (parameters,): its own, or for places and what is zero one in
        the robot's units."""
        return np.array([self._unit(name, x, scale) for name, x in zip(self.names, self.nominal, strict=True)])

    def _unit(self, name: str, nominal: float, scale: RobotScale) -> float:
        if name not in self.paths:
            return nominal or scale.mass
        path = self.paths[name][0]
        if path.part == "gravity":
            return scale.length / scale.time**2
        mass, length, time = _POWERS.get(path.last, (0, 0, 0))
        if path.last in PLACE:
            return scale.length**length
        return abs(nominal) or scale.mass**mass * scale.length**length * scale.time**time

    def everything(self) -> list[tuple[str, float]]:
        """All numbers of the description, parameters or not."""
        return [(str(path), number(self.robot, path)) for path in every_path(self.robot)]

    def rebuilt(self, values: Mapping[str, float]) -> RobotDescription:
        """The description with other values of all parameters."""
        robot = with_values(self.robot, self.numbers(values))
        for name in self.short:
            old = robot.link(name).inertial
            assert old is not None, "see `_is_short`"
            robot = robot.with_inertial(name, Inertial(values[name], old.com, old.inertia * (values[name] / old.mass)))
        return robot.with_payload(values[PAYLOAD]) if PAYLOAD in self.names else robot


_TENSORS = tuple(f"inertia.{one}" for one in TENSOR)


def places_of(robot: RobotDescription, name: str) -> list[tuple[Path, ...]]:
    """Of every number that a parameter is, the places where it stands.

    Raises:
        UnknownNameError: no such path; the nearest one is named.
        InputError: paths are joined that are not as many numbers each.
    """
    parts = [numbers_at(robot, one.strip()) for one in name.split("=")]
    if len({len(part) for part in parts}) > 1:
        raise InputError(f"parameter '{name}' joins paths that are not as many numbers each")
    return list(zip(*parts, strict=True))


def _named(places: tuple[Path, ...]) -> str:
    return " = ".join(map(str, places))


def _moves(path: Path) -> bool:
    head = path.field.rpartition(".")[0]
    return path.part == "couplings" or head in ("origin", "a", "b") or path.field == "length"
