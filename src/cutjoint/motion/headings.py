"""What the columns of a motion file are called, and in which units: `x`, `x [mm]`, `x (mm)` or `x_mm`.

Names do not mind capitals.  Without a unit a length is in metres, a time in seconds and a joint in metres or radians;
an angle of the tool needs its unit, and a quaternion has none.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches

from cutjoint.mechanism import Actuator
from cutjoint.units import UNITS, Kind, factor

POINT = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
FIXED_AXES = ("roll", "pitch", "yaw")
VECTOR = ("rx", "ry", "rz")

KINDS: Mapping[str, Kind] = {
    "t": "time",
    "time": "time",
    **dict.fromkeys(POINT, "length"),
    **dict.fromkeys(QUATERNION, "number"),
    **dict.fromkeys((*FIXED_AXES, *VECTOR), "angle"),
}
_IN_BRACKETS = re.compile(r"(.*?)\s*(?:\[([^\[\]]*)\]|\(([^()]*)\))")


@dataclass(frozen=True)
class Meaning:
    """What a column tells.

    Attributes:
        name: t, a coordinate of the tool, or an actuator.
        kind: of the quantity, a key of `cutjoint.units.UNITS`.
        of_joint: whether it is an actuator.
        factor: what its numbers are multiplied by to be in SI units.
    """

    name: str
    kind: Kind
    of_joint: bool = False
    factor: float = 1.0


def meaning_of(heading: str, actuators: Sequence[Actuator]) -> Meaning:
    """What a heading means for a robot with these actuators.

    Raises:
        ValueError: nothing that is known, several things, or an unknown unit or none where one is needed; the message
            says what was found and what was expected.
    """
    known = _known(actuators)
    readings = _readings(heading)
    name, unit = next(((name, unit) for name, unit in readings if name in known), (readings[-1][0], None))
    if name not in known:
        near = get_close_matches(name, known, n=1)
        hint = f"; did you mean '{known[near[0]][0].name}'?" if near else ";"
        words = dict.fromkeys(one.name for found in known.values() for one in found)
        raise ValueError(f"found an unknown heading{hint} expected some of {', '.join(words)}, or no such column")
    found = known[name]
    if len(found) > 1:
        raise ValueError(
            f"found a heading that means both an actuator and the tool; expected 'joint.{name}' or 'tool.{name}'"
        )
    (meaning,) = found
    if unit is None:
        if meaning.kind == "angle" and not meaning.of_joint:
            raise ValueError(f"found an angle without a unit; expected '{name} [deg]' or '{name} [rad]'")
        return meaning
    scale = factor(unit, meaning.kind)
    if scale is None:
        known_units = ", ".join(UNITS[meaning.kind])
        raise ValueError(f"found the unit '{unit}'; expected one of {known_units} for this {meaning.kind}")
    return replace(meaning, factor=scale)


def _known(actuators: Sequence[Actuator]) -> Mapping[str, list[Meaning]]:
    known: dict[str, list[Meaning]] = {}
    for name, kind in KINDS.items():
        meaning = Meaning("t" if kind == "time" else name, kind)
        known[name] = [meaning]
        if kind != "time":
            known[f"tool.{name}"] = [meaning]
    for one in actuators:
        meaning = Meaning(one.name, "angle" if one.kind == "rotation" else "length", True)
        for name in (one.name, f"joint.{one.name}"):
            known.setdefault(name.casefold(), []).append(meaning)
    return known


def _readings(heading: str) -> list[tuple[str, str | None]]:
    """Name and unit as a heading may be read, the likeliest first."""
    whole = heading.casefold()
    readings: list[tuple[str, str | None]] = [(whole, None)]
    if match := _IN_BRACKETS.fullmatch(whole):
        readings.append((match[1], (match[2] if match[3] is None else match[3]).strip()))
    name, _, unit = whole.rpartition("_")
    if name and any(factor(unit, kind) is not None for kind in KINDS.values()):
        readings.append((name.strip(), unit))
    return readings
