"""Numbers out of text: finite, in a plausible range, and with a hint where a person slipped (decimal comma, xacro)."""

from __future__ import annotations

import math
import re

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.model import Place
from cutjoint.findings import LARGEST_LENGTH, Findings, check_range, clip

LARGEST_MASS = 1e9
"""kg.  Beyond it nothing that moves has its mass; the check warns far earlier."""
LARGEST_INERTIA = 1e15
"""kg m2."""
LARGEST_PHYSICS = 1e15
"""Of damping, friction, stiffness, rotors and gears, in SI units."""

_COMMA = re.compile(r"^[+-]?\d+,\d+([eE][+-]?\d+)?$")
_NUMBER = re.compile(r"^[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?$")


def is_xacro(text: str) -> bool:
    """Whether `text` still holds a xacro expression."""
    return "${" in text or "$(" in text


def number_problem(text: str) -> tuple[str, str]:
    """Why `text` is not a number, as (found, mend)."""
    shown = clip(text)
    if is_xacro(text):
        return f"xacro expression '{shown}' left in", "expand the file first: xacro robot.urdf.xacro > robot.urdf"
    if any(_COMMA.match(word.strip(";")) for word in text.split()):
        return f"decimal comma in '{shown}'", "write decimal points: " + re.sub(r"(\d),(\d)", r"\1.\2", shown)
    if "," in text or ";" in text:
        return f"separator in '{shown}'", "separate numbers by spaces"
    return f"'{shown}' is not a number", ""


def parse_number(text: str) -> float | None:
    """`text` as a float (`inf` and `nan` included), or None where it is not one.  Independent of the locale."""
    word = text.strip()
    if _NUMBER.match(word) or word.lower().lstrip("+-") in ("inf", "infinity", "nan"):
        return float(word)
    return None


def read_numbers(
    text: str | None, count: int, what: str, findings: Findings, at: Place | int | None, largest: float = LARGEST_LENGTH
) -> tuple[float, ...] | None:
    """`count` finite numbers out of `text`, or None after noting a problem that names `what`."""
    wanted = "a number" if count == 1 else f"{count} numbers"
    if text is None:
        findings.error(f"{what} is missing", wanted, "", at)
        return None
    words = text.split()
    values = [parse_number(word) for word in words]
    if any(value is None for value in values):
        found, mend = number_problem(text)
        findings.error(f"{what}: {found}", wanted, mend, at)
        return None
    if len(values) != count:
        findings.error(f"{what}: {len(values)} numbers ('{clip(text)}')", wanted, "", at)
        return None
    numbers = tuple(float(value) for value in values if value is not None)
    return numbers if check_range(numbers, what, findings, at, largest) else None


def unit_axis(
    values: tuple[float, ...], name: str, findings: Findings, at: Place | int | None, any_length: bool = False
) -> Array:
    """The direction of `values` as a unit vector (3,).

    A zero axis is an error, a length other than 1 a warning unless the format allows `any_length`.
    """
    length = math.hypot(*values)
    shown = " ".join(f"{value:g}" for value in values)
    if length < 1e-9:
        findings.error(f"axis of joint '{name}' is {shown}", "a direction", 'for example xyz="0 0 1"', at)
        return readonly([1.0, 0.0, 0.0])
    if abs(length - 1.0) > 1e-3 and not any_length:
        findings.warn(f"axis of joint '{name}' ({shown}) has length {length:.6g}", "1", "it was normalised", at)
    return readonly(np.array(values) / length)
