"""What of a robot gives way, and how hard it is: springs at actuators, in joints and cuts, and along rods.

Names may be patterns (`leg*`, `ball?a.z`); an exact name goes before a pattern.  What is not named is rigid.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from fnmatch import fnmatchcase

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, positive
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.reprs import line

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
"""Along and about the axes of the child's frame of a joint, or of frame b of a cut."""


@dataclass(frozen=True)
class Beam:
    """A slender rod that gives way along its axis, about it, and sideways: a beam clamped at its near end.

    Attributes:
        young, shear: moduli [N/m2].
        area: of its cross-section [m2].
        bending_y, bending_z: second moments of area about the y and z axis of the section [m4]; where y and z are lies
            in `cutjoint.stiffness.softening.end_axes`.
        torsion: of the section [m4].
    """

    young: float
    shear: float
    area: float
    bending_y: float
    bending_z: float
    torsion: float

    __repr__ = line(young="N/m2", shear="N/m2", area="m2", bending_y="m4", bending_z="m4", torsion="m4")

    def __post_init__(self) -> None:
        for name in ("young", "shear", "area", "bending_y", "bending_z", "torsion"):
            positive(f"{name} of a beam", getattr(self, name))

    @staticmethod
    def tube(young: float, shear: float, outer: float, inner: float = 0.0) -> Beam:
        """A round rod or tube, by its diameters [m].

        Raises:
            InputError: a number that is none, or a bore that is no smaller than the rod.
        """
        outer = positive("outer diameter of a beam", outer, "m")
        if not 0.0 <= inner < outer:
            raise InputError(f"inner diameter of a beam must be from 0 to the outer one {outer:g} m, found {inner!r}")
        area, second = (math.pi / 4 * (outer**2 - inner**2), math.pi / 64 * (outer**4 - inner**4))
        return Beam(young, shear, area, second, second, 2.0 * second)

    def stiffness(self, length: float) -> Array:
        """Of its far end against its near end, shape (6, 6): x along the rod; [N/m], [N], [N m/rad].

        Euler and Bernoulli's beam; W. C. Young, R. G. Budynas: Roark's Formulas for Stress and Strain, 2002, table 8.1.
        """
        matrix = np.zeros((6, 6))
        matrix[0, 0], matrix[3, 3] = self.young * self.area / length, self.shear * self.torsion / length
        for across, about, second, sign in ((1, 5, self.bending_z, -1.0), (2, 4, self.bending_y, 1.0)):
            bend = self.young * second / length**3
            matrix[across, across], matrix[about, about] = 12.0 * bend, 4.0 * bend * length**2
            matrix[across, about] = matrix[about, across] = sign * 6.0 * bend * length
        return matrix


@dataclass(frozen=True, eq=False)
class Springs(Frozen):
    """How hard the parts of a robot are that give way.

    Attributes:
        actuators: actuator -> stiffness of its control, motor and gear, [N/m] where it slides, [N m/rad] where it
            turns.
        joints: joint or cut -> how hard its bearing is.  `NAME.z` is one direction of `DIRECTIONS`, with [N/m] or
            [N m/rad]; `NAME` takes six numbers, or one [N/m], the turning ones then being that times the square of the
            robot's length.  0 is no resistance at all, infinity rigid.
        rods: link, or cut of type distance -> stiffness E A / L along its axis [N/m], or a `Beam`.
    """

    actuators: Mapping[str, float] = field(default_factory=dict)
    joints: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    rods: Mapping[str, float | Beam] = field(default_factory=dict)

    __repr__ = line(actuators="N/m or N m/rad", joints="N/m or N m/rad", rods="N/m")

    def __post_init__(self) -> None:
        super().__post_init__()
        for table in (self.actuators, self.joints, self.rods):
            for key, one in table.items():
                if not isinstance(key, str) or isinstance(one, bool):
                    raise InputError(f"springs are numbers by name, found {described(key)}: {described(one)}")
        for name, k in self.actuators.items():
            positive(f"stiffness of actuator '{name}'", k, "N/m or N m/rad")
        for name, rod in self.rods.items():
            if not isinstance(rod, Beam):
                positive(f"stiffness of rod '{name}'", rod, "N/m")
        for name, given in self.joints.items():
            _numbers(name, given)

    @property
    def empty(self) -> bool:
        """Whether nothing gives way."""
        return not (self.actuators or self.joints or self.rods)

    def of_joints(self, known: Mapping[str, tuple[str, ...]], length: float, robot: str) -> dict[str, dict[str, float]]:
        """Joint or cut -> direction -> stiffness.

        Args:
            known: all joints and cuts, with the directions that they leave free.
            length: of the robot [m].

        Raises:
            UnknownNameError: no joint or cut is called so.
            InputError: a direction that is left free, or one that is given twice.
        """
        found: dict[str, dict[str, float]] = {}
        for exact in (False, True):
            level = dict[str, dict[str, float]]()
            for key, given in self.joints.items():
                stem, dot, last = key.rpartition(".")
                one = dot and last in DIRECTIONS and key not in known
                names = matching(stem if one else key, list(known), f"joint or cut of {robot}")
                if (len(names) == 1 and names[0] == (stem if one else key)) is not exact:
                    continue
                values = _numbers(key, given)
                for name in names:
                    for direction, k in _directions(key, name, last if one else "", values, known[name], length):
                        if direction in level.setdefault(name, {}):
                            raise InputError(f"stiffness {direction} of '{name}' is given twice, also by '{key}'")
                        level[name][direction] = k
            for name, few in level.items():
                found[name] = found.get(name, {}) | few
        return found


def _numbers(name: str, given: npt.ArrayLike) -> Array:
    try:
        values = np.atleast_1d(np.asarray(given, dtype=np.float64))
    except (TypeError, ValueError) as error:
        raise InputError(f"stiffness of '{name}' must be numbers, found {described(given)}") from error
    if values.shape not in ((1,), (6,)) or not (values >= 0.0).all():
        raise InputError(
            f"stiffness of '{name}' must be one number or six >= 0 [N/m], [N m/rad], found {described(given)}"
        )
    return values


def _directions(
    key: str, name: str, one: str, values: Array, free: tuple[str, ...], length: float
) -> list[tuple[str, float]]:
    if one:
        if len(values) > 1:
            raise InputError(f"stiffness of '{key}' is one number, found six; without '.{one}' there may be six")
        if one in free:
            if "*" in key or "?" in key or "[" in key:
                return []
            raise InputError(
                f"'{name}' moves freely along {one}, so a spring there does nothing; where an actuator drives it, "
                "state that of the actuator"
            )
        return [(one, float(values[0]))]
    if len(values) == 1:
        values = values * np.array([1.0] * 3 + [length**2] * 3)
    return [(which, float(k)) for which, k in zip(DIRECTIONS, values, strict=True) if which not in free]


def matching(pattern: str, known: list[str], kind: str) -> list[str]:
    """The names that a name or pattern means.

    Raises:
        UnknownNameError: none; it names the nearest.
    """
    if pattern in known:
        return [pattern]
    found = [one for one in known if fnmatchcase(one, pattern)]
    if not found:
        raise UnknownNameError(kind, pattern, known)
    return found


def by_pattern(given: Mapping[str, float | Beam], known: list[str], kind: str) -> dict[str, float | Beam]:
    """Values by exact name; an exact name goes before a pattern.

    Raises:
        UnknownNameError: nothing is called so.
        InputError: two patterns mean the same.
    """
    found: dict[str, float | Beam] = {name: value for name, value in given.items() if name in known}
    exact = set(found)
    for pattern, value in given.items():
        if pattern in exact:
            continue
        for name in matching(pattern, known, kind):
            if name in exact:
                continue
            if name in found:
                raise InputError(f"the stiffness of '{name}' is given twice, also by '{pattern}'")
            found[name] = value
    return found
