"""What the columns of a motion file are called, and in which units: `x`, `x [mm]`, `x (mm)` or `x_mm`.

Names do not mind capitals.  Without a unit a length is in metres, a time in seconds and a joint in metres or radians;
an angle of the tool needs its unit, and a quaternion has none.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from math import pi

from cutjoint.mechanism import Actuator

POINT = ("x", "y", "z")
QUATERNION = ("qx", "qy", "qz", "qw")
FIXED_AXES = ("roll", "pitch", "yaw")
VECTOR = ("rx", "ry", "rz")

# Kind of quantity -> unit -> factor to SI; the first is SI.
UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "sec": 1.0, "min": 60.0},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6},
    "angle": {"rad": 1.0, "deg": pi / 180.0, "°": pi / 180.0, "degrees": pi / 180.0, "mrad": 1e-3},
    "number": {"1": 1.0, "-": 1.0},
}
KINDS: Mapping[str, str] = {
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
        kind: of the quantity, a key of `UNITS`.
        of_joint: whether it is an actuator.
        factor: what its numbers are multiplied by to be in SI units.
    """

    name: str
    kind: str
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
    units = UNITS[meaning.kind]
    if unit is None:
        if meaning.kind == "angle" and not meaning.of_joint:
            raise ValueError(f"found an angle without a unit; expected '{name} [deg]' or '{name} [rad]'")
        return meaning
    if unit not in units:
        raise ValueError(f"found the unit '{unit}'; expected one of {', '.join(units)} for this {meaning.kind}")
    return replace(meaning, factor=units[unit])


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
    if name and any(unit in units for units in UNITS.values()):
        readings.append((name.strip(), unit))
    return readings
