"""Values that are worked out when first asked for, by one thread only, however many ask at once."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, Self, TypeVar, overload

Owner = TypeVar("Owner")
T = TypeVar("T")


class once(Generic[Owner, T]):
    """A cached property of an object that has a re-entrant lock `_lock`: others wait for the value.

    `functools.cached_property` does that in Python 3.11 only, and there with one lock for all objects of the class.
    """

    def __init__(self, function: Callable[[Owner], T]) -> None:
        self.function, self.name = function, function.__name__
        self.__doc__ = function.__doc__

    @overload
    def __get__(self, instance: None, owner: type | None = None) -> Self: ...
    @overload
    def __get__(self, instance: Owner, owner: type | None = None) -> T: ...
    def __get__(self, instance: Owner | None, owner: type | None = None) -> Self | T:
        if instance is None:
            return self
        known: dict[str, T] = instance.__dict__
        if self.name not in known:
            with vars(instance)["_lock"]:
                if self.name not in known:
                    known[self.name] = self.function(instance)
        return known[self.name]
