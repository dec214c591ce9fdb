"""Springs as people write them: texts such as `leg*.z=20 N/um` of a command line, and files of TOML.

[actuators]                 # actuator or pattern
"*" = "3e4 N m/rad"
[joints]                    # joint or cut, with a direction, one number or six
"ball*" = "50 N/um"
"arm1.rz" = 2e4
[rods]                      # link, or cut of type distance: E A / L along it
"rod*" = "20 N/um"
[rods.coupler]              # or a round rod or tube that bends too
young = 7.0e10              # N/m2
shear = 2.6e10              # N/m2
outer = "20 mm"
inner = "16 mm"
"""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import replace

from cutjoint.description.model import RobotDescription
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.files import path_name, read_file
from cutjoint.stiffness.springs import DIRECTIONS, Beam, Springs, matching
from cutjoint.stiffness.units import Kind, quantity

LARGEST_FILE = 1 << 20
"""Bytes."""
_TUBE = ("young", "shear", "outer", "inner")
_BEAM = ("young", "shear", "area", "bending_y", "bending_z", "torsion")


def toml_tables(path: str | os.PathLike[str], known: Sequence[str]) -> dict[str, dict[str, object]]:
    """The tables of a TOML file, all of them of names that are known.

    Raises:
        FileError: it cannot be read.
        InputError: it is no TOML, or holds something else.
        UnknownNameError: a table of another name.
    """
    name = path_name(path)
    try:
        found = tomllib.loads(read_file(path, LARGEST_FILE).decode("utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"'{name}' is no TOML file: {error}") from error
    for table, content in found.items():
        if table not in known:
            raise UnknownNameError(f"table in '{name}'", table, known)
        if not isinstance(content, dict):
            raise InputError(f"'{table}' in '{name}' must be a table [{table}], found {described(content)}")
    return found


def springs_from_file(path: str | os.PathLike[str], robot: RobotDescription) -> Springs:
    """Springs of a robot, from a file of TOML.

    Raises:
        FileError, InputError, UnknownNameError: it cannot be read, or says what the robot does not have.
    """
    tables = toml_tables(path, ("actuators", "joints", "rods"))
    return springs_of(robot, tables.get("actuators", {}), tables.get("joints", {}), tables.get("rods", {}))


def springs_of(
    robot: RobotDescription,
    actuators: Mapping[str, object],
    joints: Mapping[str, object],
    rods: Mapping[str, object],
) -> Springs:
    """Springs from numbers in SI units and texts with units.

    Raises:
        InputError: a number or unit that is none.
        UnknownNameError: an actuator, or a key of a beam, is not known.
    """
    return Springs(
        {name: _of_actuator(robot, name, one) for name, one in actuators.items()},
        {name: _of_joint(name, one) for name, one in joints.items()},
        {name: _of_rod(name, one) for name, one in rods.items()},
    )


def both(first: Springs, second: Springs) -> Springs:
    """All springs of two; the second goes before the first where they name the same."""
    return replace(
        first,
        actuators={**first.actuators, **second.actuators},
        joints={**first.joints, **second.joints},
        rods={**first.rods, **second.rods},
    )


def _of_actuator(robot: RobotDescription, name: str, given: object) -> float:
    found = matching(name, list(robot.actuators), f"actuator of {robot.name}")
    slide = {robot.joint(one).type.slides for one in found}
    kinds: tuple[Kind, ...] = tuple("stiffness" if one else "turning stiffness" for one in sorted(slide))
    if len(kinds) > 1 and isinstance(given, str) and any(one.isalpha() and one not in "eE" for one in given):
        raise InputError(f"'{name}' means actuators that slide and that turn; state their stiffness apart, with units")
    return quantity(f"stiffness of actuator '{name}'", given, *kinds)


def _of_joint(name: str, given: object) -> float | list[float]:
    what, last = f"stiffness of '{name}'", name.rpartition(".")[2]
    if isinstance(given, list):
        if len(given) != len(DIRECTIONS):
            raise InputError(f"{what} must be one number or six, found {len(given)}")
        pairs = zip(DIRECTIONS, given, strict=True)
        return [quantity(f"{what} {one}", number, _kind(one)) for one, number in pairs]
    return quantity(what, given, _kind(last) if last in DIRECTIONS else "stiffness")


def _kind(direction: str) -> Kind:
    return "turning stiffness" if direction.startswith("r") else "stiffness"


def _of_rod(name: str, given: object) -> float | Beam:
    if not isinstance(given, dict):
        return quantity(f"stiffness of rod '{name}'", given, "stiffness")
    known = tuple(dict.fromkeys((*_TUBE, *_BEAM)))
    if wrong := [key for key in given if key not in known]:
        raise UnknownNameError(f"key of the beam '{name}'", wrong[0], known)
    wanted = _TUBE[:3] if "outer" in given else _BEAM
    missing = [key for key in wanted if key not in given]
    unused = [key for key in given if key not in (_TUBE if "outer" in given else _BEAM)]
    if missing or unused:
        told = f"lacks {', '.join(missing)}" if missing else f"has {', '.join(unused)} too"
        raise InputError(f"beam '{name}' {told}; it wants {', '.join(_TUBE)} (a round tube), or {', '.join(_BEAM)}")
    numbers = {
        key: quantity(f"{key} of beam '{name}'", value, "length")
        if key in ("outer", "inner")
        else _plain(name, key, value)
        for key, value in given.items()
    }
    return Beam.tube(**numbers) if "outer" in given else Beam(**numbers)


def _plain(name: str, key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key} of beam '{name}' must be a number in SI units, found {described(value)}")
    return float(value)
