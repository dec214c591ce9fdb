"""Whether two descriptions are of one robot as far as it moves: a short text that differs where masses, lengths, axes,
joints, limits, joint physics, cuts or actuators do.  Names of files, places in them, pictures, titles, tools,
homes and variants do not count.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from hashlib import sha256

import numpy as np

from cutjoint.description.model import RobotDescription

DIGITS = 9
"""Of numbers that are compared: two machines may read the same file with other rounding."""
APART = frozenset(
    {
        "place",
        "places",
        "visuals",
        "collisions",
        "homes",
        "variants",
        "variant_name",
        "title",
        "source",
        "path",
        "about",
    }
    | {"tool", "task", "task_axes"}
)
"""Fields that say nothing about how a robot moves; the tool is what is watched of it."""


def fingerprint(robot: RobotDescription) -> str:
    """The text of a robot, 16 characters."""
    return sha256(_words(robot).encode()).hexdigest()[:16]


def _words(value: object) -> str:
    if isinstance(value, Enum):
        return value.name
    if is_dataclass(value):
        own = [f"{one.name}={_words(getattr(value, one.name))}" for one in fields(value) if one.name not in APART]
        return f"{type(value).__name__}({','.join(own)})"
    if isinstance(value, np.ndarray):
        return _words(value.ravel().tolist())
    if isinstance(value, Mapping):
        return _words(sorted((str(name), _words(one)) for name, one in value.items()))
    if isinstance(value, list | tuple):
        return f"[{','.join(map(_words, value))}]"
    if isinstance(value, float):
        return f"{value + 0.0:.{DIGITS}g}" if abs(value) > 1e-14 else "0"
    return repr(value)
