"""Control laws from outside the package, looked at before anything moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from cutjoint.control.function import WANTED, LawOfFunction, as_law, fitted_law
from cutjoint.control.law import Law
from cutjoint.errors import InputError
from cutjoint.plugins import OutsidePart, made_by

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
    try:
        law = as_law(made)
    except InputError as error:
        raise InputError(f"{told}: {error}") from error
    if isinstance(law, LawOfFunction):
        law = replace(law, settings={name: value for name, value in given.items() if name != "model"})  # type: ignore
    return fitted_law(law, n, told)
