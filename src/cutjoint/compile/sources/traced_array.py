"""Arrays of expressions for code that is written for arrays of floats: NumPy's functions give expressions.

What branches in a law is traced as what it picks: `where`, `sign`, `clip`, `minimum`, `interp` of a table, comparisons.
What needs a number that is not there while tracing (`if`, `float`, an index, `tanh`) is refused, never guessed.  Even a
single entry stays such an array, of no dimension, so that NumPy's functions take it too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, NoReturn

import numpy as np
import numpy.typing as npt

from cutjoint.compile.expressions import functions as fn
from cutjoint.compile.expressions.graph import Expression, Number
from cutjoint.errors import InputError

Objects = npt.NDArray[np.object_]
PI_HALF = 0.5 * np.pi


def _sign(x: Number) -> Number:
    return fn.where_less(x, 0.0, -1.0, fn.where_less(0.0, x, 1.0, 0.0))


def _both(x: Number, y: Number) -> Number:
    return fn.pick(x, fn.pick(y, 1.0, 0.0), 0.0)


def _either(x: Number, y: Number) -> Number:
    return fn.pick(x, 1.0, fn.pick(y, 1.0, 0.0))


def _equal(x: Number, y: Number) -> Number:
    return _both(fn.at_most(x, y), fn.at_most(y, x))


def _power(x: Number, exponent: Number) -> Number:
    if not isinstance(exponent, int | float) or exponent not in (1, 2, 3, 4, -1, -2, 0.5):
        raise InputError(f"a traced law raises to the powers 1, 2, 3, 4, -1, -2 and 0.5 only, found {exponent!r}")
    if exponent == 0.5:
        return fn.sqrt(x)
    whole = x
    for _ in range(abs(int(exponent)) - 1):
        whole = whole * x
    return whole if exponent > 0 else 1.0 / whole


ENTRYWISE: Mapping[str, Callable[..., Number]] = {
    "absolute": fn.absolute,
    "fabs": fn.absolute,
    "sign": _sign,
    "minimum": fn.minimum,
    "maximum": fn.maximum,
    "clip": lambda x, low, high: fn.minimum(fn.maximum(x, low), high),
    "floor": fn.floor,
    "ceil": lambda x: -fn.floor(-x),
    "rint": fn.nearest,
    "less": fn.less,
    "less_equal": fn.at_most,
    "greater": lambda x, y: fn.less(y, x),
    "greater_equal": lambda x, y: fn.at_most(y, x),
    "equal": _equal,
    "not_equal": lambda x, y: 1.0 - _equal(x, y),
    "logical_and": _both,
    "bitwise_and": _both,
    "logical_or": _either,
    "bitwise_or": _either,
    "logical_not": lambda x: fn.pick(x, 0.0, 1.0),
    "invert": lambda x: fn.pick(x, 0.0, 1.0),
    "sqrt": fn.sqrt,
    "sin": fn.sin,
    "cos": fn.cos,
    "tan": lambda x: fn.sin(x) / fn.cos(x),
    "arccos": fn.acos,
    "arcsin": lambda x: PI_HALF - fn.acos(x),
    "arctan2": fn.atan2,
    "arctan": lambda x: fn.atan2(x, 1.0),
    "hypot": lambda x, y: fn.sqrt(x * x + y * y),
    "heaviside": lambda x, middle: fn.where_less(x, 0.0, 0.0, fn.where_less(0.0, x, 1.0, middle)),
    "square": lambda x: x * x,
    "reciprocal": lambda x: 1.0 / x,
    "power": _power,
    "deg2rad": lambda x: x * (np.pi / 180.0),
    "radians": lambda x: x * (np.pi / 180.0),
    "rad2deg": lambda x: x * (180.0 / np.pi),
    "degrees": lambda x: x * (180.0 / np.pi),
}
"""NumPy's functions by name, on one entry each."""
WHOLE = ("add", "subtract", "multiply", "divide", "negative", "positive", "matmul", "vecdot")
"""Those that NumPy does on objects by Python's own arithmetic."""

if TYPE_CHECKING:
    _Base = Objects
else:
    _Base = np.ndarray


class TracedArray(_Base):
    """An array of expressions; see the module."""

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *inputs: object, **options: object) -> object:
        """NumPy's elementwise functions, and their reductions."""
        if options.pop("out", None) is not None:
            raise InputError(f"a traced law may not write the result of np.{ufunc.__name__} into an array")
        given = [_plain(one) for one in inputs]
        if ufunc.__name__ in WHOLE:
            return _traced(getattr(ufunc, method)(*given, **options))
        entrywise = ENTRYWISE.get(ufunc.__name__)
        if entrywise is None:
            _refuse(f"np.{ufunc.__name__}")
        options.pop("dtype", None)
        made = np.frompyfunc(_on_numbers(entrywise), ufunc.nin, 1)
        return _traced(getattr(made, method)(*given, **options))

    def __array_function__(
        self, func: Callable[..., object], types: Iterable[type], args: Iterable[object], kwargs: Mapping[str, object]
    ) -> object:
        """NumPy's other functions."""
        own = FUNCTIONS.get(func.__name__)
        if own is not None:
            return _traced(own(*args, **kwargs))
        found = super().__array_function__(func, types, args, kwargs)
        return [_again(one) for one in found] if isinstance(found, list) else _again(found)

    def __getitem__(self, index: object) -> TracedArray:
        for one in index if isinstance(index, tuple) else (index,):
            if isinstance(one, np.ndarray) and one.dtype == object:
                raise InputError("a traced law may not choose entries by a value; use np.where")
        return _traced(super().__getitem__(index))  # type: ignore[call-overload]

    def __setitem__(self, index: object, value: object) -> None:
        if isinstance(index, np.ndarray) and index.dtype == object:
            raise InputError("a traced law may not choose entries by a value; use np.where")
        super().__setitem__(index, _plain(value))  # type: ignore[call-overload]

    def __iter__(self) -> Iterator[TracedArray]:  # type: ignore[override]
        return (self[k] for k in range(len(self)))

    def __bool__(self) -> bool:
        if self.size == 1:
            return bool(self.flat[0])
        return super().__bool__()

    def round(self, decimals: int = 0, out: None = None) -> TracedArray:  # type: ignore[override]
        """To `decimals` digits behind the point."""
        if out is not None:
            raise InputError("a traced law may not write the result of round into an array")
        return _rounded(self, decimals)


def _on_numbers(function: Callable[..., Number]) -> Callable[..., Number]:
    """`function`, on Python's own numbers where NumPy's come."""
    return lambda *values: function(*(float(x) if isinstance(x, int | np.generic) else x for x in values))


def _plain(value: object) -> object:
    """A traced array as an array of objects, whatever it is in."""
    if isinstance(value, TracedArray):
        return value.view(np.ndarray)
    if isinstance(value, list | tuple) and value:
        return flat_objects(value)
    return value


def flat_objects(values: object) -> Objects:
    """Anything like an array, traced or not, as an array of objects."""
    found = np.array(values, dtype=object)
    return np.frompyfunc(lambda x: x.item() if isinstance(x, np.ndarray) else x, 1, 1)(found) if found.ndim else found


def numbers(values: object) -> list[Number]:
    """The entries of an array, traced or not, row by row."""
    found: list[Number] = flat_objects(_plain(values)).ravel().tolist()
    return found


def traced(values: Sequence[Number]) -> TracedArray:
    """Expressions and numbers as an array for a law."""
    made = np.empty(len(values), dtype=object)
    made[:] = list(values)
    return _traced(made)


def _traced(value: object) -> TracedArray:
    """Of an array of objects, or of one object."""
    return np.asarray(value, dtype=object).view(TracedArray)


def _again(value: object) -> object:
    """A result of NumPy's, traced if there are expressions in it."""
    is_traced = isinstance(value, Expression) or (isinstance(value, np.ndarray) and value.dtype == object)
    return _traced(value) if is_traced else value


def _refuse(what: str) -> NoReturn:
    raise InputError(f"{what} cannot be traced; the law still runs between steps (run with a rate)")


def _where(condition: object, *choices: object) -> object:
    if len(choices) != 2:
        _refuse("np.where without what to choose from")
    made = np.frompyfunc(_on_numbers(fn.pick), 3, 1)
    return made(_plain(condition), *map(_plain, choices))


def _interp(
    x: object,
    places: object,
    values: object,
    left: float | None = None,
    right: float | None = None,
    period: None = None,
) -> object:
    """Linear between the rows of a table, as NumPy does it."""
    if period is not None:
        _refuse("np.interp with a period")
    try:
        at, value = np.asarray(places, dtype=np.float64).tolist(), np.asarray(values, dtype=np.float64).tolist()
    except TypeError as error:
        raise InputError("a traced law may look values up in a table of numbers only") from error
    if len(at) != len(value) or not at:
        raise ValueError("np.interp takes as many places as values, and at least one")

    def look(x: Number) -> Number:
        found: Number = value[0] if left is None else left
        for k in range(len(at) - 1):
            slope = (value[k + 1] - value[k]) / (at[k + 1] - at[k])
            found = fn.pick(fn.at_most(at[k], x), slope * (x - at[k]) + value[k], found)
        end = fn.where_less(at[-1], x, value[-1] if right is None else right, value[-1])
        return fn.pick(fn.at_most(at[-1], x), end, found)

    return np.frompyfunc(_on_numbers(look), 1, 1)(_plain(x))


def _rounded(x: object, decimals: int = 0) -> TracedArray:
    scale = 10.0**decimals
    made = np.frompyfunc(_on_numbers(lambda one: fn.nearest(one * scale) / scale), 1, 1)
    return _traced(made(_plain(x)))


def _select(conditions: Sequence[object], choices: Sequence[object], default: object = 0) -> object:
    found = _plain(default)
    for condition, choice in zip(reversed(conditions), reversed(choices), strict=True):
        found = _where(condition, choice, found)
    return found


FUNCTIONS: Mapping[str, Callable[..., object]] = {
    "where": _where,
    "interp": _interp,
    "round": _rounded,
    "around": _rounded,
    "select": _select,
    "norm": lambda x: np.sqrt(np.sum(np.square(x))),
}
"""NumPy's functions that are not elementwise, by name; what is not here it does by its own elementwise ones."""
