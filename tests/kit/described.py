"""What differs between two descriptions of a robot, and where a writer puts one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path

import numpy as np

from cutjoint.description import Joint

FILES = {"loops": "loops.toml", "urdf": "robot.urdf", "mjcf": "robot.xml"}
UNORDERED = ("links", "joints", "cuts", "couplings", "homes", "variants")


def differences(a: object, b: object, where: str = "", tolerance: float = 4e-15) -> list[str]:
    """What differs between two values, lists of named things matched by name; places in files do not count."""
    if (a is None) is not (b is None):
        return [f"{where}: {a!r} / {b!r}"]
    if isinstance(a, np.ndarray):
        same = np.allclose(a, b, rtol=1e-14, atol=tolerance * max(1.0, float(np.abs(a).max())))
        return [] if same else [f"{where}: {a.tolist()} / {np.asarray(b).tolist()}"]
    if isinstance(a, float) and isinstance(b, (float, int)):
        return [] if abs(a - b) <= 1e-14 * max(1.0, abs(a)) else [f"{where}: {a} / {b}"]
    if is_dataclass(a):
        found = []
        for field in fields(a):
            unused = field.name == "axis" and not a.type.axes if isinstance(a, Joint) else False
            if field.name not in ("place", "places", "path") and not unused:
                found += differences(getattr(a, field.name), getattr(b, field.name), f"{where}.{field.name}")
        return found
    if isinstance(a, Path) and isinstance(b, Path):
        a, b = a.resolve(), b.resolve()
    if isinstance(a, tuple) and where.rsplit(".", 1)[-1] in UNORDERED:
        a, b = ({item.name: item for item in items} for items in (a, b))
    if isinstance(a, Mapping):
        if set(a) != set(b):
            return [f"{where}: {sorted(a)} / {sorted(b)}"]
        return [one for key in a for one in differences(a[key], b[key], f"{where}[{key}]")]
    if isinstance(a, tuple):
        if len(a) != len(b):
            return [f"{where}: {len(a)} / {len(b)} items"]
        return [one for n, pair in enumerate(zip(a, b, strict=True)) for one in differences(*pair, f"{where}[{n}]")]
    return [] if a == b else [f"{where}: {a!r} / {b!r}"]
