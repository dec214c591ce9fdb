"""What control laws are given while they are traced, symbolic twins, and what they answer: efforts, compared."""

from __future__ import annotations

import copy
from collections.abc import Callable

import numpy as np

from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.compile.sources.traced_array import numbers
from cutjoint.doors import described
from cutjoint.errors import InputError


def twin_of(one: object, symbolic: Callable[[str, object], object]) -> object:
    """A copy of an object with what is symbolic in place of its gains and models."""
    twin = copy.copy(one)
    for name, value in list(getattr(one, "__dict__", {}).items()):
        if (other := symbolic(name, value)) is not value:
            object.__setattr__(twin, name, other)  # a frozen one too: nobody else has seen this copy
    return twin


def efforts_in(answer: object, n: int) -> list[Number]:
    """A law's answer as efforts of n actuators.

    Raises:
        InputError: it is none.
    """
    found = np.asarray(answer)
    if answer is None or found.dtype.kind not in "biufO":
        raise InputError(f"it must return efforts, one an actuator; it returned {described(answer)}")
    if found.shape != (n,):
        raise InputError(f"it asks for efforts of shape {found.shape}; the robot has {n} actuators: shape ({n},)")
    return numbers(answer)


def same(one: Number, other: Number) -> bool:
    """Whether two values are one, which in a graph is there only once."""
    if isinstance(one, Expression) and isinstance(other, Expression):
        return one.ref == other.ref
    return not isinstance(one, Expression) and not isinstance(other, Expression) and one == other
