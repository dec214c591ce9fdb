"""Quantities as people write them: `0.1 mm`, `20 N/um`, `1e5`; without a unit they are in SI units and radians."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from typing import Literal

from cutjoint.errors import InputError, shown

Kind = Literal["length", "angle", "stiffness", "turning stiffness", "warmth"]
"""What a quantity is."""

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9}
_ANGLES = {
    "rad": 1.0,
    "mrad": 1e-3,
    "urad": 1e-6,
    "deg": math.pi / 180.0,
    "arcmin": math.pi / 10800.0,
    "arcsec": math.pi / 648000.0,
}
_FORCES = {"mN": 1e-3, "N": 1.0, "kN": 1e3, "MN": 1e6}
UNITS: Mapping[Kind, Mapping[str, float]] = {
    "length": _LENGTHS,
    "angle": _ANGLES,
    "stiffness": {f"{force}/{length}": a / b for force, a in _FORCES.items() for length, b in _LENGTHS.items()},
    "turning stiffness": {
        f"{force}m/{angle}": a / b for force, a in (_FORCES | {"uN": 1e-6}).items() for angle, b in _ANGLES.items()
    },
    "warmth": {"K": 1.0, "mK": 1e-3},
}
"""Kind -> unit -> how much of the SI unit it is."""
_FORM = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?|[-+]?inf)\s*(.*?)\s*")


def quantity(what: str, given: object, *kinds: Kind) -> float:
    """A number in SI units, from a number or a text with one of the units of `kinds`.

    Raises:
        InputError: no number, or another unit; the message calls it `what`.
    """
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given)
    wanted = " or ".join(kinds)
    if not isinstance(given, str) or not (found := _FORM.fullmatch(given)):
        raise InputError(f"{what} must be a {wanted}, such as '{_example(kinds[0])}', found {shown(repr(given), 60)}")
    number, unit = float(found[1]), re.sub(r"[\s·*]", "", found[2])
    for kind in kinds:
        if not unit:
            return number
        if unit in UNITS[kind]:
            return number * UNITS[kind][unit]
    known = [one for kind in kinds for one in UNITS[kind] if one[0] not in "µμ" and "µ" not in one and "μ" not in one]
    few = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    raise InputError(
        f"{what} must be a {wanted} [{few}], found the unit '{shown(found[2], 40)}' in '{shown(given, 60)}'"
    )


def _example(kind: Kind) -> str:
    return {
        "length": "0.1 mm",
        "angle": "0.02 deg",
        "stiffness": "20 N/um",
        "turning stiffness": "3e4 N m/rad",
        "warmth": "15 K",
    }[kind]


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


def told(values: Sequence[float], size: float = 0.0, digits: int = 4) -> str:
    """Numbers with commas; what is rounding beside the largest, or beside `size`, is 0."""
    largest = max([size, *map(abs, values)])
    return ", ".join("0" if abs(one) <= 1e-9 * largest else f"{one:.{digits}g}" for one in values)
