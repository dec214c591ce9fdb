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
from collections.abc import Mapping
from dataclasses import replace
from functools import partial

from cutjoint.description.model import RobotDescription
from cutjoint.doors import described
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.stiffness.springs import DIRECTIONS, Beam, Springs, matching
from cutjoint.toml.reading import read_settings
from cutjoint.toml.table import TomlTable
from cutjoint.toml.taking import each
from cutjoint.units import Kind, in_si

_TUBE = ("young", "shear", "outer", "inner")
_BEAM = ("young", "shear", "area", "bending_y", "bending_z", "torsion")


def springs_from_file(path: str | os.PathLike[str], robot: RobotDescription) -> Springs:
    """Springs of a robot, from a file of TOML.

    Raises:
        SettingsError: it cannot be read, or says what the robot does not have: all that is wrong, with lines.
    """
    return read_settings(path, partial(_taken, robot))


def _taken(robot: RobotDescription, top: TomlTable) -> Springs:
    found = Springs(
        each(top.table("actuators"), partial(_of_actuator, robot)),
        each(top.table("joints"), _of_joint),
        each(top.table("rods"), _of_rod),
    )
    top.finish()
    return found


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
    return in_si(f"stiffness of actuator '{name}'", given, *kinds)


def _of_joint(name: str, given: object) -> float | list[float]:
    what, last = f"stiffness of '{name}'", name.rpartition(".")[2]
    if isinstance(given, list):
        if len(given) != len(DIRECTIONS):
            raise InputError(f"{what} must be one number or six, found {len(given)}")
        pairs = zip(DIRECTIONS, given, strict=True)
        return [in_si(f"{what} {one}", number, _kind(one)) for one, number in pairs]
    return in_si(what, given, _kind(last) if last in DIRECTIONS else "stiffness")


def _kind(direction: str) -> Kind:
    return "turning stiffness" if direction.startswith("r") else "stiffness"


def _of_rod(name: str, given: object) -> float | Beam:
    if not isinstance(given, dict):
        return in_si(f"stiffness of rod '{name}'", given, "stiffness")
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
        key: in_si(f"{key} of beam '{name}'", value, "length")
        if key in ("outer", "inner")
        else _plain(name, key, value)
        for key, value in given.items()
    }
    return Beam.tube(**numbers) if "outer" in given else Beam(**numbers)


def _plain(name: str, key: str, value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key} of beam '{name}' must be a number in SI units, found {described(value)}")
    return float(value)
