"""Tolerances, warmth and backlash as people write them: texts of a command line, and files of TOML.

[tolerances]                        # path or pattern: half the width, evenly spread
"cuts.*.b.z" = "0.1 mm"
"joints.arm*.origin.yaw" = { sigma = "0.01 deg" }      # or a standard deviation
"tool.*" = { within = 5e-5 }
[backlash]                          # actuator or pattern: half the width, at the joint
"*" = "1 arcmin"
[warm]                              # link, rod or sliding actuator: kelvins above the rest
"arm*" = 15
[expansion]                         # part or pattern: a material, or a number in 1/K
"*" = "aluminium"
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial

from cutjoint.accuracy.deviations import ACTUATORS, Deviation, ErrorSource, sources
from cutjoint.description.model import RobotDescription
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError, shown
from cutjoint.reprs import line
from cutjoint.toml.reading import read_settings
from cutjoint.toml.table import TomlTable
from cutjoint.toml.taking import each
from cutjoint.units import Kind, in_si

_HOW = ("within", "sigma")
NORMAL = "normal"
"""What stands behind a tolerance on a command line that is a standard deviation: 0.1 mm normal."""


@dataclass(frozen=True)
class Errors:
    """What is off, warm and loose.

    Attributes:
        tolerances: path or pattern -> deviation.
        backlash: actuator or pattern -> half the width [m] or [rad].
        warm: part or pattern -> by how much it is warmer [K].
        expansion: part or pattern -> material, or number [1/K].
    """

    tolerances: Mapping[str, Deviation] = field(default_factory=dict)
    backlash: Mapping[str, float] = field(default_factory=dict)
    warm: Mapping[str, float] = field(default_factory=dict)
    expansion: Mapping[str, str | float] = field(default_factory=dict)

    __repr__ = line("tolerances", "backlash", "warm", "expansion", backlash="m or rad", warm="K")

    @property
    def empty(self) -> bool:
        """Whether nothing is off."""
        return not (self.tolerances or self.backlash or self.warm)


def errors_from_file(path: str | os.PathLike[str], robot: RobotDescription) -> Errors:
    """What is off, from a file of TOML.

    Raises:
        SettingsError: it cannot be read, or says what the robot does not have: all that is wrong, with lines.
    """
    return read_settings(path, partial(_taken, robot))


def _taken(robot: RobotDescription, top: TomlTable) -> Errors:
    found = Errors(
        each(top.table("tolerances"), partial(_deviation, robot)),
        each(top.table("backlash"), partial(_backlash, robot)),
        each(top.table("warm"), _warmth),
        each(top.table("expansion"), _material),
    )
    top.finish()
    return found


def errors_of(
    robot: RobotDescription,
    tolerances: Mapping[str, object],
    backlash: Mapping[str, object],
    warm: Mapping[str, object],
    expansion: Mapping[str, object],
) -> Errors:
    """What is off, from numbers in SI units and texts with units.

    Raises:
        InputError: a number or unit that is none.
        UnknownNameError: a path is not known.
    """
    return Errors(
        {name: _deviation(robot, name, one) for name, one in tolerances.items()},
        {name: _backlash(robot, name, one) for name, one in backlash.items()},
        {name: _warmth(name, one) for name, one in warm.items()},
        {name: _material(name, one) for name, one in expansion.items()},
    )


def both(first: Errors, second: Errors) -> Errors:
    """All of two; the second goes before the first where they name the same."""
    return Errors(
        {**first.tolerances, **second.tolerances},
        {**first.backlash, **second.backlash},
        {**first.warm, **second.warm},
        {**first.expansion, **second.expansion},
    )


def _deviation(robot: RobotDescription, name: str, given: object) -> Deviation:
    what, normal = f"tolerance of '{name}'", False
    if isinstance(given, dict):
        if wrong := [key for key in given if key not in _HOW]:
            raise UnknownNameError(f"key of the {what}", wrong[0], _HOW)
        if len(given) != 1:
            raise InputError(f"{what} is given by one of {' and '.join(_HOW)}, found {len(given)}")
        normal, given = "sigma" in given, next(iter(given.values()))
    elif isinstance(given, str) and given.rstrip().endswith(NORMAL):
        normal, given = True, given.rstrip()[: -len(NORMAL)]
    return Deviation(_size(robot, name, what, given), normal)


def _backlash(robot: RobotDescription, name: str, given: object) -> float:
    return _size(robot, f"{ACTUATORS}.{name}", f"backlash of '{name}'", given)


def _warmth(name: str, given: object) -> float:
    return in_si(f"warmth of '{name}'", given, "warmth")


def _size(robot: RobotDescription, name: str, what: str, given: object) -> float:
    """A tolerance in the unit of what it is of."""
    found: tuple[ErrorSource, ...] = sources(robot, [name])
    kinds = sorted({source.kind for source in found})
    if len(kinds) > 1:
        raise InputError(f"'{name}' means numbers of several kinds, {', '.join(kinds)}; state their tolerances apart")
    if kinds == ["ratio"]:
        return in_si(what, given, "length") if not isinstance(given, str) else _bare(what, given)
    kind: Kind = "length" if kinds == ["length"] else "angle"
    return in_si(what, given, kind)


def _bare(what: str, given: str) -> float:
    try:
        return float(given)
    except ValueError as error:
        raise InputError(f"{what} must be a number, found '{shown(given)}'") from error


def _material(name: str, given: object) -> str | float:
    if isinstance(given, bool) or not isinstance(given, str | int | float):
        raise InputError(f"expansion of '{name}' must be a material or a number [1/K], found {described(given)}")
    if isinstance(given, str):
        try:
            return float(given)
        except ValueError:
            return given
    return float(given)
