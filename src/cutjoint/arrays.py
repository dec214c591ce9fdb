"""Float arrays as cutjoint hands them out (read-only) and takes them in (checked)."""

from __future__ import annotations

from math import isfinite

import numpy as np
import numpy.typing as npt

from cutjoint.errors import InputError

Array = npt.NDArray[np.float64]


def readonly(values: npt.ArrayLike) -> Array:
    """A float copy of `values` that nobody can write into."""
    array = np.array(values, dtype=np.float64)
    array.setflags(write=False)
    return array


def as_vector(name: str, values: npt.ArrayLike, size: int, unit: str = "") -> Array:
    """`values` as a finite float vector of `size` entries.

    Raises:
        InputError: wrong size, not numbers, or not finite; the message names the argument.
    """
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be {size} numbers{unit and f' [{unit}]'}, found {values!r}") from error
    if array.shape == (size,) and isfinite(array.dot(array)):  # the quick way through for what is right
        return array
    if array.shape != (size,):
        raise InputError(f"{name} must have shape ({size},){unit and f' [{unit}]'}, found shape {array.shape}")
    if not np.isfinite(array).all():
        raise InputError(f"{name} must be finite, found {array.tolist()}")
    return array


def positive(name: str, value: float, unit: str = "") -> float:
    """`value` as a finite float > 0.

    Raises:
        InputError: it is not; the message names the argument.
    """
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise InputError(f"{name} must be a number > 0{unit and f' [{unit}]'}, found {value!r}") from error
    if not (np.isfinite(number) and number > 0.0):
        raise InputError(f"{name} must be finite and > 0{unit and f' [{unit}]'}, found {number!r}")
    return number
