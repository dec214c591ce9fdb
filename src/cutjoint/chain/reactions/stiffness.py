"""Stated stiffnesses of joints: how hard a joint, cut or coupling is where it should not give at all."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.description.model import RobotDescription
from cutjoint.errors import InputError, UnknownNameError

Stiffness: TypeAlias = Mapping[str, npt.ArrayLike]
"""Joint, cut or coupling -> stiffness.

Of joints and cuts six numbers along and about the axes of the child's frame, or of frame b: x, y, z [N/m], then about
x, y, z [N m/rad]; or one [N/m], the others then being that times the square of the robot's length [N m/rad].  Of
couplings one number, [N/m] or [N m/rad] of their joint.  What is not named is rigid, as are infinite ones.
"""


def compliances(stiffness: Stiffness, description: RobotDescription, length: float) -> dict[str, Array]:
    """Compliances by name: (6,) of joints and cuts, (1,) of couplings, [m/N] or [rad/(N m)].

    Raises:
        InputError: not one or six numbers > 0, a bushing, or a name that two of them have.
        UnknownNameError: no joint, cut or coupling has that name.
    """
    found: dict[str, Array] = {}
    gears = [one.name for one in description.couplings]
    known = [*(one.name for one in description.joints), *(one.name for one in description.cuts), *gears]
    rubber = [one.name for one in description.cuts if one.bushing is not None]
    for name, given in stiffness.items():
        if name not in known:
            raise UnknownNameError(f"joint, cut or coupling of {description.name}", str(name), known)
        if known.count(name) > 1:
            raise InputError(f"'{name}' names several of the joints, cuts and couplings of {description.name}")
        if name in rubber:
            raise InputError(f"'{name}' is a bushing, whose stiffness is its own; leave it out of the stated ones")
        wanted = {1: "one number"} if name in gears else {1: "one number", 6: "six"}
        try:
            values = np.atleast_1d(np.asarray(given, dtype=np.float64))
        except (TypeError, ValueError) as error:
            raise InputError(f"stiffness of '{name}' must be numbers, found {given!r}") from error
        if values.ndim != 1 or len(values) not in wanted or not (values > 0.0).all():
            told = " or ".join(wanted.values())
            raise InputError(f"stiffness of '{name}' must be {told} > 0 [N/m], [N m/rad], found {given!r}")
        if name not in gears and len(values) == 1:
            values = values * np.array([1.0] * 3 + [length**2] * 3)
        found[name] = 1.0 / values
    return found
