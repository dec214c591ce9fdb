"""How objects show themselves: one line with names and units, never more, or a table.

A line holds what fits into `WIDTH` columns.  Long arrays, texts and lists are cut, and what cannot be printed is
escaped, so that names from a foreign file do no harm.  Nothing is computed for it and nothing raised.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum

import numpy as np

from cutjoint.errors import shown

WIDTH = 100
MOST = 6
"""Entries of an array or list that are shown."""
ROUNDING = 1e-13
LONGEST = 40
"""Characters of a text that are shown."""


def line(*names: str, **units: str) -> Callable[[object], str]:
    """A `__repr__`: the attributes `names` (default: all fields) of an object, but for those that are as by default.

    Args:
        names: attributes in their order; a leading underscore is not shown.
        units: of those that have one.
    """

    def __repr__(self: object) -> str:
        return told(self, *names, **units)

    return __repr__


def told(one: object, *names: str, **units: str) -> str:
    """What `line` says of an object."""
    return one_line(type(one).__name__, _parts(one, names, units))


def one_line(head: str, parts: Sequence[str], width: int = WIDTH) -> str:
    """`head(part, part, ...)` with the parts that fit."""
    kept: list[str] = []
    room = width - len(head) - len("(, ...)")
    for part in parts:
        if len(part) + 2 <= room:
            kept.append(part)
            room -= len(part) + 2
    rest = ["..."] if len(kept) < len(parts) else []
    return f"{head}({', '.join([*kept, *rest])})"


def short(value: object, unit: str = "") -> str:
    """A value in a few words."""
    try:
        text = _short(value)
    except Exception:  # whatever a foreign object does when it is looked at
        text = type(value).__name__
    return f"{text} {unit}" if unit and value is not None else text


def quoted(text: str, longest: int = LONGEST) -> str:
    """A text in quotes, cut, with what cannot be printed escaped."""
    return f"'{clipped(text, longest)}'"


def clipped(text: str, longest: int = LONGEST) -> str:
    """A text, cut, with what cannot be printed escaped."""
    return shown(text[: 2 * longest], longest)


def counted(count: int, what: str) -> str:
    """So many of something."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def listed(names: Sequence[str], most: int = 4 * MOST) -> str:
    """Names, cut, and how many there are where they are not all."""
    return _listed([clipped(name) for name in names[:most]], len(names))


def _parts(one: object, names: Sequence[str], units: Mapping[str, str]) -> list[str]:
    defaults: dict[str, object] = {}
    if is_dataclass(one):
        own = [field for field in fields(one) if field.repr]
        defaults = {field.name: field.default for field in own if field.default is not MISSING}
        names = names or [field.name for field in own]
    names = names or getattr(one, "_fields", ())
    found = []
    for name in names:
        value = _asked(one, name)
        if value is not MISSING and not _usual(value, defaults.get(name, MISSING)):
            found.append(f"{name.lstrip('_')}={short(value, units.get(name, ''))}")
    return found


def _asked(one: object, name: str) -> object:
    try:
        return getattr(one, name, MISSING)
    except Exception:  # a property that cannot tell
        return MISSING


def _usual(value: object, default: object) -> bool:
    """Whether a value is empty, or a default that says nothing: None, 0, a name."""
    if value is None or (isinstance(value, tuple | list | str | Mapping) and not value):
        return True
    return isinstance(value, bool | int | float | str) and value == default and (not default or default is True)


def _short(value: object) -> str:
    if value is None or isinstance(value, bool | np.bool_ | int):
        return str(value)
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, float | np.floating | np.integer):
        return f"{value:.6g}"
    if isinstance(value, str):
        return quoted(value)
    if isinstance(value, os.PathLike):
        return quoted(os.fspath(value)[-2 * LONGEST :])
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping):
        rows = [f"{clipped(str(name))}: {short(one)}" for name, one in list(value.items())[:MOST]]
        return "{" + _listed(rows, len(value)) + "}"
    if isinstance(value, tuple | list) and not hasattr(value, "_fields"):
        return "(" + _listed([short(one) for one in value[:MOST]], len(value)) + ")"
    return _named(value)


def _array(value: np.ndarray[tuple[int, ...], np.dtype[np.generic]]) -> str:
    if value.ndim != 1:
        return short(value.item()) if value.ndim == 0 else f"array {value.shape}".replace(",)", ")")
    first = value[:MOST]
    if value.dtype.kind == "f":  # what is rounding beside the largest is 0
        first = np.where(np.abs(first) < ROUNDING * np.abs(value).max(initial=0.0), 0.0, first)
    return "(" + _listed([short(one) for one in first.tolist()], value.size) + ")"


def _listed(rows: Sequence[str], count: int) -> str:
    rest = [f"... {count} in all"] if count > len(rows) else []
    return ", ".join([*rows, *rest])


def _named(value: object) -> str:
    """An object by its class and name."""
    if isinstance(value, type) or (callable(value) and hasattr(value, "__name__")):
        return clipped(str(value.__name__))
    kind, own = type(value), getattr(value, "name", None)
    told = f" {quoted(own)}" if isinstance(own, str) else ""
    return f"{clipped(kind.__name__)}{told}"
