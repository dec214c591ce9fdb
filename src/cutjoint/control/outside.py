"""Control laws from outside the package, looked at before anything moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import cast

import numpy as np

from cutjoint.control.function import WANTED, LawOfFunction, as_law
from cutjoint.control.law import Law
from cutjoint.errors import InputError
from cutjoint.plugins import OutsidePart, guarded, made_by

GROUP = "cutjoint.controllers"
"""The entry points of installed packages that are laws."""


def maker(part: OutsidePart) -> Callable[..., object]:
    """What makes the law: a class itself, which takes gains; a function or object is the law already.

    Raises:
        InputError: it is none of these.
    """
    value = part.value
    if isinstance(value, type):
        return value
    if not callable(value) and not hasattr(value, "effort"):
        raise InputError(f"{part.told} is {value!r}, which is neither called nor has an effort; {WANTED}")
    return lambda: value


def outside_law(make: Callable[..., object], told: str, n: int, **given: object) -> Law:
    """The law that a maker gives for n actuators.

    Raises:
        InputError: it does not take what is given, raises, or what it gives is no law.
    """
    made = made_by(make, told, "a class of laws takes its gains by name, and `model` where it wants one", **given)
    missing = [name for name in ("name", "gains", "memory", "effort", "memory_rate") if not hasattr(made, name)]
    if missing and hasattr(made, "effort"):
        raise InputError(f"{told} has an effort but no {', '.join(missing)}; {WANTED} (PD as base class has the rest)")
    try:
        law = as_law(made)
    except InputError as error:
        raise InputError(f"{told}: {error}") from error
    if isinstance(law, LawOfFunction):
        law = replace(law, settings={name: value for name, value in given.items() if name != "model"})  # type: ignore
    size = guarded(f"{told}.memory", law.memory, n)
    if not isinstance(size, int) or size < 0:
        raise InputError(f"{told}.memory({n}) must give the number of the law's own states, it gave {size!r}")
    gains = guarded(f"{told}.gains", lambda: law.gains)
    try:
        for value in cast(dict[str, object], gains).values():
            np.atleast_2d(np.asarray(value, dtype=np.float64))
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(f"{told}.gains must be a dict of names and numbers, it is {gains!r}") from error
    return law
