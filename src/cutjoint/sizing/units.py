"""Units of catalogues of motors, and what they are in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from math import pi, radians

INCH, POUND = 0.0254, 4.4482216152605
"""[m], [N]."""

UNITS: Mapping[str, Mapping[str, float]] = {
    "torque": {
        "N m": 1.0, "mN m": 1e-3, "kN m": 1e3, "N cm": 1e-2, "N mm": 1e-3, "lbf in": POUND * INCH,
        "lbf ft": 12.0 * POUND * INCH, "ozf in": POUND * INCH / 16.0,
    },
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3, "lbf": POUND},
    "speed of rotation": {
        "rad/s": 1.0, "rpm": pi / 30.0, "1/min": pi / 30.0, "rev/s": 2.0 * pi, "deg/s": radians(1.0),
    },
    "speed": {"m/s": 1.0, "mm/s": 1e-3, "m/min": 1.0 / 60.0, "mm/min": 1e-3 / 60.0},
    "inertia": {"kg m2": 1.0, "kg cm2": 1e-4, "kg mm2": 1e-6, "g m2": 1e-3, "g cm2": 1e-7, "g mm2": 1e-9},
    "mass": {"kg": 1.0, "g": 1e-3},
    "resistance": {"Ohm": 1.0, "mOhm": 1e-3},
    "torque constant": {"N m/A": 1.0, "mN m/A": 1e-3, "N cm/A": 1e-2},
    "force constant": {"N/A": 1.0},
    "thermal resistance": {"K/W": 1.0},
    "temperature": {"degC": 1.0},
}  # fmt: skip
"""Quantity -> its units -> how many SI units they are (temperatures in degrees Celsius)."""

_SAME = {
    "C": "degC",
    "\u00b0C": "degC",
    "\u2126": "Ohm",
    "\u03a9": "Ohm",
    "ohm": "Ohm",
    "min-1": "1/min",
    "r/min": "1/min",
    "C/W": "K/W",
    "\u00b0C/W": "K/W",
}


def plainly_written(unit: str) -> str:
    """A unit without spaces, dots and raised digits, by which it is looked up."""
    text = unit.strip().replace("\u00b2", "2").replace("^", "").replace("\u207b\u00b9", "-1")
    for one in (" ", "*", "\u00b7", "."):
        text = text.replace(one, "")
    return _SAME.get(text, text)


def factor(unit: str, quantity: str) -> float | None:
    """How many SI units a unit of a quantity is; None where it is none of this quantity."""
    return {plainly_written(one): value for one, value in UNITS[quantity].items()}.get(plainly_written(unit))


def quantities_of(unit: str) -> tuple[str, ...]:
    """What the unit measures; nothing where it is not known."""
    return tuple(quantity for quantity in UNITS if factor(unit, quantity) is not None)
