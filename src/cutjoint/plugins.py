"""Parts from outside the package: what a Python file, a module, or an installed package's entry point offers by name.

Written `my_laws.py:SlidingMode` (a file; its folder is where it finds its neighbours), `package.module:Name` (what can
be imported), or as the name of an entry point (https://packaging.python.org/specifications/entry-points/).  All that
can be wrong with such a part is told as one error, before anything is made with it.
"""

from __future__ import annotations

import re
import sys
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from inspect import Parameter, signature
from pathlib import Path
from types import ModuleType

from cutjoint.errors import CutjointError, FileError, InputError, UnknownNameError
from cutjoint.files import check_file, is_file, read_file

FORM = re.compile(r"(?P<place>.+\.py|[A-Za-z_][\w.]*):(?P<name>[A-Za-z_]\w*)(?::(?P<rest>.*))?")

LARGEST = 16 * 2**20
"""Bytes of a Python file."""


@dataclass(frozen=True)
class OutsidePart:
    """Something from outside.

    Attributes:
        value: the class, function or object itself.
        told: how it was written, for messages.
        rest: what was written behind it after a further colon.
    """

    value: object
    told: str
    rest: str = ""


def is_outside(text: str) -> bool:
    """Whether `text` is written like a part of a file or module: a colon and a name behind it, or ending in .py."""
    return text.endswith(".py") or FORM.fullmatch(text) is not None


def part(text: str) -> OutsidePart:
    """The part that `text`, FILE.py:NAME or PACKAGE.MODULE:NAME, with further text behind another colon or not, names.

    Raises:
        InputError: there is no such file or module, it cannot be imported, or `text` names nothing in it.
        UnknownNameError: there is no such name in it.
    """
    match = FORM.fullmatch(text)
    if match is None:
        offered = _offered(_of_file(Path(text))) if text.endswith(".py") else []
        raise InputError(f"say which part of {text} you mean, as {text}:NAME; it has {', '.join(offered) or 'none'}")
    place, name = match["place"], match["name"]
    module = _of_file(Path(place)) if place.endswith(".py") else _of_module(place, name)
    if not hasattr(module, name):
        raise UnknownNameError(f"name in {place}", name, _offered(module))
    return OutsidePart(getattr(module, name), f"{place}:{name}", match["rest"] or "")


@cache
def installed(group: str) -> Mapping[str, tuple[EntryPoint, ...]]:
    """The entry points of a group that installed packages offer, by name; several where packages use one name."""
    found: dict[str, tuple[EntryPoint, ...]] = {}
    for one in entry_points(group=group):
        found[one.name] = (*found.get(one.name, ()), one)
    return found


def installed_part(group: str, name: str) -> OutsidePart:
    """The part that an installed package offers as `name`, one of `installed(group)`.

    Raises:
        InputError: several packages offer the name, or the part cannot be imported.
    """
    offers = installed(group)[name]
    if len({one.value for one in offers}) > 1:
        raise InputError(f"'{name}' is offered as {' and as '.join(one.value for one in offers)}; write out which one")
    place, _, attribute = offers[0].value.partition(":")
    found = part(f"{place.strip()}:{attribute.split('[')[0].strip()}")
    return OutsidePart(found.value, f"{name} ({found.told})")


def raised(error: BaseException, files: str = "") -> str:
    """What an error from outside says: its kind, its words, and the last line of `files` (or any) that it came from."""
    frames = [one for one in traceback.extract_tb(error.__traceback__) if one.filename == files or not files]
    words = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    if isinstance(error, SyntaxError) and error.filename:
        return f"{words.splitlines()[0]} at {error.filename}:{error.lineno}: {(error.text or '').strip()}"
    return f"{words} at {frames[-1].filename}:{frames[-1].lineno}: {frames[-1].line}" if frames else words


def made_by(make: Callable[..., object], told: str, wanted: str, *given: object, **named: object) -> object:
    """What `make(*given, **named)` of a part from outside gives.

    Raises:
        InputError: it does not take these arguments, or raises.
    """
    try:
        takes = signature(make)
    except (TypeError, ValueError):  # written in C
        return guarded(told, make, *given, **named)
    try:
        takes.bind(*given, **named)
    except TypeError as error:
        raise InputError(f"{told}{takes} does not take what it is given ({error}); {wanted}") from error
    return guarded(told, make, *given, **named)


def guarded(told: str, call: Callable[..., object], *given: object, **named: object) -> object:
    """What a call into a part from outside gives; what it raises comes as an InputError that says where."""
    try:
        return call(*given, **named)
    except CutjointError:
        raise
    except Exception as error:
        raise InputError(f"{told} raised {raised(error)}") from error


def parameters(make: Callable[..., object], told: str) -> dict[str, Parameter]:
    """The named parameters of a class or function from outside.

    Raises:
        InputError: they cannot be told.
    """
    try:
        found = signature(make, eval_str=True).parameters
    except Exception as error:  # annotations are evaluated, which may raise anything
        raise InputError(f"the parameters of {told} cannot be read: {raised(error)}") from error
    return {
        name: one for name, one in found.items() if one.kind not in (Parameter.VAR_POSITIONAL, Parameter.VAR_KEYWORD)
    }


def _offered(module: ModuleType) -> list[str]:
    """Classes and functions that a module defines itself."""
    own = {name: one for name, one in vars(module).items() if callable(one) and not name.startswith("_")}
    return [name for name, one in own.items() if getattr(one, "__module__", "") == module.__name__]


def _of_file(path: Path) -> ModuleType:
    try:
        check_file(path, LARGEST)
    except FileError as error:
        if not error.missing:
            raise
        here = sorted(one.name for one in path.parent.glob("*.py")) if path.parent.is_dir() else []
        raise UnknownNameError(f"Python file in {path.parent.resolve()},", path.name, here[:20]) from error
    state = path.stat()
    return _executed(path.resolve(), state.st_mtime_ns, state.st_size)


@cache
def _executed(path: Path, time: int, size: int) -> ModuleType:
    """The module of a file as it is now."""
    module = ModuleType(f"cutjoint_outside_{path.stem}")
    module.__file__ = str(path)
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))  # behind all others, so that nothing is hidden by its neighbours
    sys.modules[module.__name__] = module  # dataclasses look there
    try:
        exec(compile(read_file(path, LARGEST), path, "exec", dont_inherit=True), vars(module))
    except (Exception, SystemExit) as error:
        del sys.modules[module.__name__]
        raise InputError(f"{path.name} cannot be imported: {raised(error, str(path))}") from error
    return module


def _of_module(place: str, name: str) -> ModuleType:
    try:
        return import_module(place)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{place}.".startswith(f"{error.name}."):
            raise InputError(f"{place} cannot be imported: {raised(error)}") from error
        file = f"{place.replace('.', '/')}.py"
        hint = f"; for the file here write {file}:{name}" if is_file(file) else ""
        raise InputError(f"there is no module {error.name} to import{hint}") from error
    except (Exception, SystemExit) as error:
        raise InputError(f"{place} cannot be imported: {raised(error)}") from error
