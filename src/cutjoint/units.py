"""Units as people write them: `0.1 mm`, `20 N/um`, `rotor_inertia [kg cm2]`; without a unit a number is in SI units.

One table for all that is read: options, files of TOML, headings of motor tables and of motion files.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import Literal

from cutjoint.errors import InputError, shown

Kind = Literal[
    "time", "number", "length", "angle", "speed", "speed of rotation", "force", "torque", "mass", "inertia",
    "stiffness", "turning stiffness", "warmth", "temperature", "resistance", "torque constant", "force constant",
    "thermal resistance",
]  # fmt: skip
"""What a quantity is."""

INCH, POUND = 0.0254, 4.4482216152605
"""[m], [N]."""
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9}
_ANGLES = {
    "rad": 1.0, "mrad": 1e-3, "urad": 1e-6, "deg": math.radians(1.0), "arcmin": math.radians(1.0 / 60.0),
    "arcsec": math.radians(1.0 / 3600.0),
}  # fmt: skip
_FORCES = {"N": 1.0, "mN": 1e-3, "kN": 1e3, "MN": 1e6}
UNITS: Mapping[Kind, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9, "min": 60.0},
    "number": {"1": 1.0, "-": 1.0},
    "length": _LENGTHS,
    "angle": _ANGLES,
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "m/min": 1.0 / 60.0, "mm/min": 1e-3 / 60.0},
    "speed of rotation": {
        "rad/s": 1.0, "rpm": math.pi / 30.0, "1/min": math.pi / 30.0, "rev/s": 2.0 * math.pi,
        "deg/s": math.radians(1.0),
    },
    "force": {**_FORCES, "lbf": POUND},
    "torque": {
        "N m": 1.0, "mN m": 1e-3, "kN m": 1e3, "N cm": 1e-2, "N mm": 1e-3, "lbf in": POUND * INCH,
        "lbf ft": 12.0 * POUND * INCH, "ozf in": POUND * INCH / 16.0,
    },
    "mass": {"kg": 1.0, "g": 1e-3},
    "inertia": {"kg m2": 1.0, "kg cm2": 1e-4, "kg mm2": 1e-6, "g m2": 1e-3, "g cm2": 1e-7, "g mm2": 1e-9},
    "stiffness": {f"{force}/{length}": a / b for force, a in _FORCES.items() for length, b in _LENGTHS.items()},
    "turning stiffness": {
        f"{force} m/{angle}": a / b for force, a in {**_FORCES, "uN": 1e-6}.items() for angle, b in _ANGLES.items()
    },
    "warmth": {"K": 1.0, "mK": 1e-3},
    "temperature": {"degC": 1.0},
    "resistance": {"Ohm": 1.0, "mOhm": 1e-3},
    "torque constant": {"N m/A": 1.0, "mN m/A": 1e-3, "N cm/A": 1e-2},
    "force constant": {"N/A": 1.0},
    "thermal resistance": {"K/W": 1.0},
}  # fmt: skip
"""Kind -> its units, that of SI first -> how many SI units they are (temperatures in degrees Celsius)."""

_SAME = {
    "C": "degC", "\u00b0C": "degC", "C/W": "K/W", "\u00b0C/W": "K/W",
    "\u2126": "Ohm", "\u03a9": "Ohm", "ohm": "Ohm",
    "min-1": "1/min", "r/min": "1/min",
    "\u00b0": "deg", "degrees": "deg", "sec": "s",
}  # fmt: skip
_PLAIN = str.maketrans({
    " ": None, "\t": None, "*": None, "\u00b7": None, ".": None, "^": None, "\u00b2": "2", "\u207b": "-", "\u00b9": "1",
    "\u00b5": "u", "\u03bc": "u",
})  # fmt: skip
_FORM = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf)\s*(.*?)\s*")
_EXAMPLES: Mapping[Kind, str] = {
    "length": "0.1 mm",
    "angle": "0.02 deg",
    "stiffness": "20 N/um",
    "turning stiffness": "3e4 N m/rad",
    "warmth": "15 K",
}


def plainly_written(unit: str) -> str:
    """A unit without spaces, dots, raised digits and the letter mu, by which it is looked up."""
    text = unit.translate(_PLAIN)
    return _SAME.get(text, text)


_FACTORS = {kind: {plainly_written(unit): one for unit, one in units.items()} for kind, units in UNITS.items()}


def factor(unit: str, kind: Kind) -> float | None:
    """How many SI units a unit of a kind is; None where it is none of this kind."""
    return _FACTORS[kind].get(plainly_written(unit))


def kinds_of(unit: str) -> tuple[Kind, ...]:
    """What the unit measures; nothing where it is not known."""
    return tuple(kind for kind in UNITS if factor(unit, kind) is not None)


def in_si(what: str, given: object, *kinds: Kind) -> float:
    """A number in SI units, from a number or a text with one of the units of `kinds`.

    Raises:
        InputError: no number, or another unit; the message calls it `what`.
    """
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given)
    wanted = " or ".join(kinds)
    if not isinstance(given, str) or not (found := _FORM.fullmatch(given)):
        example = _EXAMPLES.get(kinds[0], f"1 {next(iter(UNITS[kinds[0]]))}")
        raise InputError(f"{what} must be a {wanted}, such as '{example}', found {shown(repr(given), 60)}")
    number = float(found[1])
    if not found[2]:
        return number
    for kind in kinds:
        scale = factor(found[2], kind)
        if scale is not None:
            return number * scale
    known = [one for kind in kinds for one in UNITS[kind]]
    few = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    raise InputError(
        f"{what} must be a {wanted} [{few}], found the unit '{shown(found[2], 40)}' in '{shown(given, 60)}'"
    )


_SHOWN: Mapping[str, tuple[tuple[float, str], ...]] = {
    "m": ((1.0, "m"), (1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm"), (1e-12, "pm")),
    "rad": ((1.0, "rad"), (1e-3, "mrad"), (1e-6, "µrad"), (1e-9, "nrad"), (1e-12, "prad")),
    "N/m": ((1e9, "kN/µm"), (1e6, "N/µm"), (1e3, "N/mm"), (1.0, "N/m"), (1e-3, "mN/m")),
    "N m/rad": ((1e6, "MN m/rad"), (1e3, "kN m/rad"), (1.0, "N m/rad"), (1e-3, "mN m/rad")),
    "m/N": ((1.0, "m/N"), (1e-3, "mm/N"), (1e-6, "µm/N"), (1e-9, "nm/N"), (1e-12, "pm/N")),
}


def handy(size: float, unit: str) -> tuple[float, str]:
    """Factor and unit in which a quantity of a size, in the SI unit `unit`, is a number that can be read."""
    rows = _SHOWN[unit]
    if not 0.0 < size < math.inf:
        return 1.0, unit
    found = next((row for row in rows if size >= row[0]), rows[-1])
    return 1.0 / found[0], found[1]
