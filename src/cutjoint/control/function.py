"""A control law that is just a function, and what may be given where a law is wanted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from inspect import signature
from typing import cast

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Values
from cutjoint.control.given import GivenEfforts, efforts_of
from cutjoint.control.law import Law
from cutjoint.control.pd import NOTHING
from cutjoint.doors import described
from cutjoint.errors import InputError, shown
from cutjoint.motion import Desired
from cutjoint.plugins import guarded
from cutjoint.reprs import line

WANTED = (
    "a law is a function (t, desired, q, v) -> efforts, a function t -> efforts, or an object with name, gains, "
    "memory(n), effort(desired, q, v, memory) and memory_rate(desired, q, v, asked, given)"
)


@dataclass(frozen=True)
class LawOfFunction(Values):
    """`function(t, desired, q, v)`: time [s], desired motion, measured actuated coordinates and velocities (n,); it
    returns the efforts (n,), [N] or [N m].  No memory.

    Attributes:
        function: the function, or an object that is called like one.
        settings: the gains that such an object was made with, for reports and result files.
    """

    function: Callable[[float, Desired, Array, Array], npt.ArrayLike]
    settings: Mapping[str, npt.ArrayLike] = field(default_factory=dict)

    __repr__ = line("name", "settings")

    @property
    def name(self) -> str:
        """The function's name."""
        return str(getattr(self.function, "__name__", type(self.function).__name__))

    @property
    def gains(self) -> dict[str, list[list[float]]]:
        """Its settings."""
        return {name: np.atleast_2d(np.asarray(one, dtype=np.float64)).tolist() for name, one in self.settings.items()}

    def memory(self, n: int) -> int:
        """No memory."""
        return 0

    def effort(self, desired: Desired, q: Array, v: Array, memory: Array) -> Array:
        """What the function says, shape (n,)."""
        return efforts_of(self.name, self.function(desired.t, desired, q, v))

    def memory_rate(self, desired: Desired, q: Array, v: Array, asked: Array, given: Array) -> Array:
        """Nothing to remember."""
        return NOTHING


def as_law(given: object) -> Law:
    """A law, or what is as good as one: a function (t, desired, q, v) -> efforts, or t -> efforts.

    Raises:
        InputError: it is neither.
    """
    if isinstance(given, type):
        raise InputError(f"{given.__name__} is a class, expected a law: make one of it")
    if isinstance(given, Law):
        return given
    if hasattr(given, "effort"):
        missing = [name for name in ("name", "gains", "memory", "memory_rate") if not hasattr(given, name)]
        raise InputError(
            f"{type(given).__name__} has an effort but no {', '.join(missing)}; {WANTED} (PD as base class has it)"
        )
    if not callable(given):
        raise InputError(f"{described(given)} is no control law: {WANTED}")
    for count, make in ((4, LawOfFunction), (1, GivenEfforts)):
        try:
            signature(given).bind(*[None] * count)
        except (TypeError, ValueError):
            continue
        return make(given)
    name = getattr(given, "__name__", type(given).__name__)
    raise InputError(f"{name}{signature(given)} is no control law: {WANTED}")


def fitted_law(given: object, n: int, told: str = "") -> Law:
    """The same, held to what a law says of itself for n actuators: the number of its states, its gains, its name.

    Raises:
        InputError: it is no law; it, which is called `told`, says something else, or its gains do not fit.
    """
    law = as_law(given)
    told = told or f"controller '{law.name}'"
    size = guarded(f"{told}.memory", law.memory, n)
    if isinstance(size, bool) or not isinstance(size, int | np.integer) or size < 0:
        raise InputError(
            f"{told}.memory({n}) must give the number of the law's own states, it gave {shown(repr(size))}"
        )
    gains = guarded(f"{told}.gains", lambda: law.gains)
    try:
        for value in cast(dict[str, object], gains).values():
            np.atleast_2d(np.asarray(value, dtype=np.float64))
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(f"{told}.gains must be a dict of names and numbers, it is {shown(repr(gains))}") from error
    if not isinstance(law.name, str):
        raise InputError(f"{told}.name must be a text, it is {described(law.name)}")
    return law
