"""Float arrays as cutjoint hands them out (read-only) and takes them in (checked), and what all values that hold such
arrays have in common."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from inspect import get_annotations
from types import MappingProxyType
from typing import ClassVar, TypeVar

import numpy as np
import numpy.typing as npt

from cutjoint.doors import described
from cutjoint.errors import InputError

Array = npt.NDArray[np.float64]
T = TypeVar("T")
_FLOAT = np.dtype(np.float64)
LARGEST = 1e100
"""A quantity beyond it, or below its reciprocal, is a slip of the pen; squares and ratios of others are finite."""


def readonly(values: npt.ArrayLike) -> Array:
    """A float copy of `values` that nobody can write into; what nobody can write into already, is as it is."""
    if type(values) is np.ndarray and values.dtype == _FLOAT and not values.flags.writeable:
        base = values.base
        if base is None or (type(base) is np.ndarray and base.base is None and not base.flags.writeable):
            return values
    if type(values) is not np.ndarray and (values is None or np.asarray(values).dtype.kind in "US"):
        raise InputError(f"numbers are wanted, found {described(values)}")
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


class Values:
    """Base of the frozen dataclasses that hold arrays or mappings: pickled and copied, they stay read-only.

    numpy's arrays come out of a pickle or a deepcopy writable, and Python's read-only mappings do not pickle at all.
    So a value is taken apart into its fields, where mappings are plain dicts, and put together again without its
    constructor: no array is changed or checked once more, each is read-only, and each mapping is a view that cannot be
    written through.  What is not a field (a cached property) is left behind.
    """

    __slots__ = ()

    def __reduce__(self) -> tuple[object, ...]:
        parts = {one.name: _portable(getattr(self, one.name)) for one in fields(self)}  # type: ignore[arg-type]
        return _put_together, (type(self), parts)


class Frozen(Values):
    """Base of values whose arrays and mappings are read-only copies of what they are given: the fields that are
    annotated `Array` or `Mapping[...]`, noted once a class."""

    __slots__ = ()
    _arrays: ClassVar[tuple[str, ...]] = ()
    _mappings: ClassVar[tuple[str, ...]] = ()

    def __init_subclass__(cls) -> None:
        kinds = get_annotations(cls).items()
        cls._arrays += tuple(name for name, kind in kinds if kind in ("Array", Array))
        cls._mappings += tuple(name for name, kind in kinds if str(kind).startswith("Mapping["))

    def __post_init__(self) -> None:
        own, name = self.__dict__, ""  # quicker than by object.__setattr__
        try:
            for name in self._arrays:
                own[name] = readonly(own[name])
            for name in self._mappings:
                own[name] = readonly_mapping(own[name])
        except (TypeError, ValueError) as error:
            wanted = "numbers" if name in self._arrays else "a dict"
            what = f"{name} of {type(self).__name__} must be {wanted}, found {described(own[name])}"
            raise InputError(what) from error


class Sealed:
    """Base of objects whose public attributes are given once, when they are made."""

    def __setattr__(self, name: str, value: object) -> None:
        if name in self.__dict__ and not name.startswith("_"):
            raise AttributeError(f"'{name}' of {type(self).__name__} cannot be changed; make another one with it")
        object.__setattr__(self, name, value)


def readonly_mapping(values: Mapping[str, T]) -> Mapping[str, T]:
    """A copy of `values` that nobody can write into."""
    return MappingProxyType(dict(values))


def _portable(value: object) -> object:
    return dict(value) if isinstance(value, MappingProxyType) else value


def _put_together(kind: type[T], parts: Mapping[str, object]) -> T:
    made = object.__new__(kind)
    for name, value in parts.items():
        if isinstance(value, dict):
            value = MappingProxyType({key: _protected(one) for key, one in value.items()})
        object.__setattr__(made, name, _protected(value))
    return made


def _protected(value: object) -> object:
    """A read-only view of an array, also inside a tuple; anything else as it is."""
    if isinstance(value, np.ndarray):
        if value.flags.writeable:
            value = value.view()
            value.setflags(write=False)
        return value
    if type(value) is tuple:
        return tuple(map(_protected, value))
    return value


def as_vector(name: str, values: npt.ArrayLike, size: int, unit: str = "") -> Array:
    """`values` as a finite float vector of `size` entries.

    Raises:
        InputError: wrong size, not numbers, not finite, or beyond `LARGEST`; the message names the argument.
    """
    try:
        array = np.asarray(values)
        if array.dtype != np.float64:
            if array.dtype.kind in "USb":
                raise TypeError("texts and truth values are no numbers")
            array = array.astype(np.float64, casting="same_kind" if array.dtype.kind in "cmM" else "unsafe")
    except (TypeError, ValueError, OverflowError) as error:
        found = repr(values)
        found = found if len(found) <= 200 else f"{found[:200]}..."
        raise InputError(f"{name} must be {size} numbers{unit and f' [{unit}]'}, found {found}") from error
    if array.shape == (size,) and sum(map(abs, array.tolist())) <= LARGEST:  # the quick way through for what is right
        return array
    if array.shape != (size,):
        raise InputError(f"{name} must have shape ({size},){unit and f' [{unit}]'}, found shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} must be finite, found {array.tolist()}")
    if size and (largest := float(np.abs(array).max())) > LARGEST:
        raise InputError(f"{name} must be of numbers up to {LARGEST:g} in size, found {largest:g}")
    return array


def sized(name: str, values: npt.ArrayLike, size: int) -> Array:
    """`values` as a float vector of `size` entries; those of a vector are not looked at, as inner loops are quicker so.

    Raises:
        InputError: wrong size, or no vector and not numbers.
    """
    if type(values) is np.ndarray and values.dtype == _FLOAT and values.shape == (size,):
        return values
    return as_vector(name, values, size)


def positive(name: str, value: float, unit: str = "") -> float:
    """`value` as a finite float > 0.

    Raises:
        InputError: it is not; the message names the argument.
    """
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(f"{name} must be a number > 0{unit and f' [{unit}]'}, found {value!r}") from error
    if not (np.isfinite(number) and number > 0.0):
        raise InputError(f"{name} must be finite and > 0{unit and f' [{unit}]'}, found {number!r}")
    if not 1.0 / LARGEST <= number <= LARGEST:
        least = f"between {1.0 / LARGEST:g} and {LARGEST:g}"
        raise InputError(f"{name} must be {least}{unit and f' [{unit}]'}, found {number!r}")
    return number
