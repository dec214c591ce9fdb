"""Doors: public functions and classes that look at what they are given before they use it.

`@door` holds arguments to their annotations.  It tells what kind of thing an argument must be; sizes, ranges and units
are for the function itself to check.  Functions that are called thousands of times a second have no door of this kind:
a check costs about a microsecond.
"""

from __future__ import annotations

import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import wraps
from inspect import Parameter, get_annotations, signature
from itertools import chain, repeat
from operator import index
from typing import Annotated, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
import numpy.typing as npt

from cutjoint.errors import InputError, shown

Call = TypeVar("Call", bound=Callable[..., object])
Fits = Callable[[object], bool]
_ARRAY_LIKE = frozenset(get_args(npt.ArrayLike))
_WORDS = {"float": "a number", "int": "a whole number", "str": "a text", "bool": "True or False", "None": "None"}
_MENDS: Mapping[tuple[str, str], str] = {
    ("Reference", "Trajectory"): "Reference(trajectory, robot) makes one of it",
    ("Reference", "str"): "Reference(trajectory, robot) makes one, and cutjoint.motion has the trajectories",
    ("Trajectory", "Reference"): "its .trajectory is one",
    ("Trajectory", "str"): "cutjoint.motion has them: Circle, PointToPoint, Hold, motion_from_file, ...",
    ("Law", "object"): "cutjoint.control has laws: PD, ComputedTorque, ...; a function (t, desired, q, v) is one too",
    ("Mechanism", "str"): "cutjoint.load(name or path) gives a robot",
    ("Mechanism", "PathLike"): "cutjoint.load(name or path) gives a robot",
    ("Mechanism", "RobotDescription"): "cutjoint.ClosedChain(description) builds the robot",
    ("Mechanism", "MinimalCoordinates"): "its .chain is one",
    ("Plant", "MinimalCoordinates"): "MinimalPlant(minimal) simulates it",
    ("ClosedChain", "str"): "cutjoint.load(name or path) gives one",
    ("ClosedChain", "PathLike"): "cutjoint.load(name or path) gives one",
    ("ClosedChain", "RobotDescription"): "cutjoint.ClosedChain(description) builds it",
    ("ClosedChain", "CompiledChain"): "its .chain is one",
    ("RobotDescription", "str"): "cutjoint.load_description(name or path) reads one",
    ("RobotDescription", "ClosedChain"): "its .description is one",
    ("Result", "str"): "cutjoint.simulation.load(path) reads one",
    ("Result", "PathLike"): "cutjoint.simulation.load(path) reads one",
    ("Posture", "ndarray"): "close(q) or reach(target) of the robot gives one",
    ("Posture", "list"): "close(q) or reach(target) of the robot gives one",
    ("Posture", "Pose"): "reach(pose) of the robot gives one",
    ("Sequence", "str"): "put it into a list",
    ("tuple", "str"): "put it into a list",
}
"""What is wanted, what is found -> how to mend it."""


class _Kind:
    """What an argument may be."""

    def __init__(self, fits: Fits, words: str, *names: str, protocols: tuple[type, ...] = ()) -> None:
        self.fits, self.words, self.names, self.protocols = fits, words, frozenset(names), protocols


def door(call: Call) -> Call:
    """A function, or a class by its constructor, that refuses arguments which are not what its annotations say.

    Numbers may be of any kind of number, arrays anything that numpy makes numbers of, but no texts and no truth values.
    Annotations that cannot be read at run time, and those of type variables, are not checked.

    Raises:
        InputError: of the decorated function: it names the argument, what was found, and what was expected.
    """
    return door_but()(call)


def door_but(*left: str) -> Callable[[Call], Call]:
    """The same, but for the arguments `left`, which take more than their annotations say and are looked at inside."""

    def decorate(call: Call) -> Call:
        if isinstance(call, type):
            call.__init__ = _guarded(call.__init__, call.__name__, left)  # type: ignore[misc]
            return call
        return _guarded(call, call.__name__, left)  # type: ignore[return-value]

    return decorate


def of_type(name: str, value: object, *kinds: type) -> None:
    """Where a decorator would be too much, or `kinds` are imported late.

    Raises:
        InputError: `value` is of none of `kinds`; the message calls it `name`.
    """
    if type(value) in kinds:
        return
    wanted = [_kind(one) for one in kinds]
    if not any(one.fits(value) for one in wanted):
        raise _refusal(name, value, _one_of(wanted))


def described(value: object, longest: int = 60) -> str:
    """A value in a few words, for messages: its type, and itself where that is short."""
    if value is None or isinstance(value, bool | int | float | str | bytes):
        text = shown(repr(value), longest)
        return text if value is None or isinstance(value, bool) else f"the {_kind_of_text(value)} {text}"
    if isinstance(value, type):
        return f"the class {value.__name__}"
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape} of {value.dtype}"
    if isinstance(value, list | tuple | dict | set) and not value:
        return f"an empty {type(value).__name__}"
    if isinstance(value, list | tuple):
        return f"{described(value[0], longest)} in {_with_article(type(value).__name__)}"
    return _with_article(shown(type(value).__name__, longest))


def _kind_of_text(value: object) -> str:
    return {"str": "text", "bytes": "bytes"}.get(type(value).__name__, "number")


def _guarded(call: Callable[..., object], told: str, left: tuple[str, ...]) -> Callable[..., object]:
    names: list[str] = []
    kinds: dict[str, _Kind] = {}

    @wraps(call)
    def checked(*given: object, **named: object) -> object:
        if not names:  # read at the first call, when all modules are there
            found = _kinds_of(call, left)
            kinds.update(found)
            names[:] = _places(call)
        for name, value in (*zip(chain(names, repeat(names[-1])), given, strict=False), *named.items()):
            kind = kinds.get(name)
            if kind is not None and not kind.fits(value):
                raise _refusal(f"{name} of {told}", value, kind)
        return call(*given, **named)

    return checked


def _kinds_of(call: Callable[..., object], left: tuple[str, ...]) -> dict[str, _Kind]:
    """What the parameters of a function may be, of those that must be something."""
    kinds = {}
    for name, one in signature(call).parameters.items():
        if one.annotation is not Parameter.empty and one.kind is not Parameter.VAR_KEYWORD and name not in left:
            kind = _kind(_read(call, one.annotation))
            if kind.words:
                kinds[name] = kind
    return kinds


def _places(call: Callable[..., object]) -> list[str]:
    """Names of the parameters that are given by place; the last one takes all that are left."""
    by_place = (Parameter.POSITIONAL_ONLY, Parameter.POSITIONAL_OR_KEYWORD, Parameter.VAR_POSITIONAL)
    parameters = signature(call).parameters
    names = [name for name, one in parameters.items() if one.kind in by_place]
    return names if any(one.kind is Parameter.VAR_POSITIONAL for one in parameters.values()) else [*names, ""]


def _read(call: Callable[..., object], annotation: object) -> object:
    """An annotation as what it means; `object` where that is imported for type checkers alone."""
    scope = types.SimpleNamespace(__annotations__={"it": annotation})
    try:
        return get_type_hints(scope, getattr(call, "__globals__", {}), include_extras=True)["it"]
    except NameError:
        return object


def _kind(annotation: object) -> _Kind:
    """What an annotation allows; without words where that is everything."""
    members = list(_members(annotation))
    if any(one.words == "" for one in members):
        return _Kind(lambda value: True, "")
    return members[0] if len(members) == 1 else _one_of(members)


def _one_of(members: Sequence[_Kind]) -> _Kind:
    *first, last = [one.words for one in members]
    words = f"{', '.join(first)} or {last}" if first else last
    fits = [one.fits for one in members]
    names = {name for one in members for name in one.names}
    protocols = tuple(kind for one in members for kind in one.protocols)
    return _Kind(lambda value: any(one(value) for one in fits), words, *names, protocols=protocols)


def _members(annotation: object) -> Iterator[_Kind]:
    """The kinds of a union, or the one kind that an annotation is."""
    origin, inner = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        yield from _members(inner[0])
    elif origin in (Union, types.UnionType):
        rest = list(inner)
        if set(inner) >= _ARRAY_LIKE:
            rest = [one for one in inner if one not in _ARRAY_LIKE]
            yield _Kind(_is_numbers, "numbers", "array")
        for one in rest:
            yield from _members(one)
    else:
        yield _single(annotation, origin, inner)


def _single(annotation: object, origin: object, inner: tuple[object, ...]) -> _Kind:
    """A kind that is no union."""
    if annotation is None or annotation is type(None):
        return _Kind(lambda value: value is None, "None", "None")
    if origin is Literal:
        return _Kind(
            lambda value: any(type(one) is type(value) and one == value for one in inner),
            " or ".join(map(repr, inner)),
        )
    if origin is np.ndarray or annotation is np.ndarray:
        return _Kind(_is_numbers, "numbers", "array")
    if annotation in _PLAIN:
        return _Kind(_PLAIN[annotation], _WORDS[annotation.__name__], annotation.__name__)  # type: ignore
    if origin is Callable or annotation is Callable:
        return _Kind(callable, "a function", "Callable")
    kind = origin if isinstance(origin, type) else annotation
    if not isinstance(kind, type) or kind is object:
        return _Kind(lambda value: True, "")
    if issubclass(kind, Mapping):
        return _mapping(inner)
    if issubclass(kind, Iterable) and not getattr(kind, "_is_protocol", False) and inner:
        return _several(kind, inner)
    words = _with_article(kind.__name__)
    if getattr(kind, "_is_protocol", False):
        members = _members_of(kind)
        return _Kind(lambda value: not _lacks(value, members), words, kind.__name__, protocols=(kind,))
    return _Kind(lambda value: isinstance(value, kind), words, kind.__name__)


def _with_article(name: str) -> str:
    return f"{'an' if name[:1].lower() in tuple('aeio') else 'a'} {name}"


def _mapping(inner: tuple[object, ...]) -> _Kind:
    key, value = (_kind(one) for one in inner) if len(inner) == 2 else (_kind(object), _kind(object))
    more = f" of {value.words}" if value.words else ""
    return _Kind(
        lambda given: isinstance(given, Mapping) and all(key.fits(a) and value.fits(b) for a, b in given.items()),
        f"a dict{more} by name" if "str" in key.names else f"a dict{more}",
        "Mapping",
    )


def _several(kind: type, inner: tuple[object, ...]) -> _Kind:
    """Lists, tuples and what is iterated; a text is none, and tuples of a known length have that length."""
    each = _kind(inner[0])
    fixed = len(inner) if kind is tuple and inner[-1] is not ... else None
    words = f"a list of {each.words.removeprefix('a ').removeprefix('an ')}s" if each.words else "a list"
    if "float" in each.names or "int" in each.names:
        words = "a list of numbers"
    if fixed is not None:
        words = f"{fixed} of them: ({', '.join(_kind(one).words or 'anything' for one in inner)})"

    def fits(value: object) -> bool:
        if isinstance(value, str | bytes | Mapping) or not isinstance(value, Iterable):
            return False
        if not isinstance(value, Sequence | np.ndarray):  # what can be gone through only once
            return not issubclass(kind, Sequence)
        if fixed is not None:
            return len(value) == fixed and all(_kind(one).fits(x) for one, x in zip(inner, value, strict=True))
        return all(map(each.fits, value))

    return _Kind(fits, words, "tuple" if kind is tuple else "Sequence")


def _members_of(protocol: type) -> tuple[str, ...]:
    """Names that a protocol asks for."""
    bases = [one for one in protocol.__mro__ if getattr(one, "_is_protocol", False)]
    names = {name for one in bases for name in (*vars(one), *get_annotations(one))}
    return tuple(sorted(name for name in names if not name.startswith("_") or name == "__call__"))


def _lacks(value: object, members: tuple[str, ...]) -> list[str]:
    """The members that a value does not have, as far as can be told without asking for them: a property may be dear, or
    raise."""
    kind, own = type(value), getattr(value, "__dict__", {})
    if isinstance(value, type):
        return list(members)
    missing = [name for name in members if not hasattr(kind, name) and name not in own]
    return [name for name in missing if not (hasattr(kind, "__getattr__") and hasattr(value, name))]


def _is_number(value: object) -> bool:
    if isinstance(value, bool | np.bool_ | str | bytes | complex):
        return False
    if isinstance(value, np.ndarray) and (value.ndim or value.dtype.kind not in "iufO"):
        return False
    return hasattr(value, "__float__") or hasattr(value, "__index__")


def _is_whole(value: object) -> bool:
    if isinstance(value, bool | np.bool_):
        return False
    try:
        index(value)  # type: ignore[arg-type]
    except TypeError:
        return False
    return True


def _is_numbers(value: object) -> bool:
    """Whether numpy makes numbers of it; symbols, as objects, are numbers too."""
    if value is None or isinstance(value, bool | np.bool_ | str | bytes | Mapping):
        return False
    try:
        array = np.asarray(value)
    except (TypeError, ValueError, OverflowError):
        return False
    if array.dtype.kind != "O":
        return array.dtype.kind in "iuf"
    return all(_is_number(one) for one in array.ravel().tolist())


_PLAIN: Mapping[object, Fits] = {
    float: _is_number,
    int: _is_whole,
    str: lambda value: isinstance(value, str),
    bool: lambda value: isinstance(value, bool | np.bool_),
}


def _refusal(name: str, value: object, kind: _Kind) -> InputError:
    ways = [one.__name__ for one in type(value).__mro__]
    if hasattr(type(value), "__fspath__"):
        ways.append("PathLike")
    if "Reference" not in ways and not _lacks(value, ("at", "duration")):
        ways.append("Trajectory")
    found = described(value)
    for protocol in kind.protocols:
        members = _members_of(protocol)
        lacking = _lacks(value, members)
        if 2 * len(lacking) <= len(members) and not isinstance(value, type):
            found += f", which as {_with_article(protocol.__name__)} lacks {', '.join(lacking)}"
    mend = next(
        (_MENDS[want, way] for way in ways for want in sorted(kind.names, reverse=True) if (want, way) in _MENDS), ""
    )
    return InputError(f"{name} must be {kind.words}, found {found}{mend and f' ({mend})'}")
