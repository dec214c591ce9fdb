"""The public classes of cutjoint: what its modules offer by `__all__`, and what public functions and methods return."""

from __future__ import annotations

import importlib
import inspect
import pkgutil
import typing
from collections.abc import Iterator

import cutjoint


def modules() -> Iterator[object]:
    """All modules of the package, but for the command line's."""
    for one in pkgutil.walk_packages(cutjoint.__path__, "cutjoint."):
        if not one.name.startswith(("cutjoint.__main__", "cutjoint.cli", "cutjoint.commands")):
            yield importlib.import_module(one.name)


def public_classes() -> set[type]:
    """Classes of cutjoint that a user meets, errors and protocols left out."""
    todo = [getattr(module, name) for module in modules() for name in getattr(module, "__all__", ())]
    found: set[type] = set()
    while todo:
        one = todo.pop()
        if inspect.isclass(one):
            if one in found or not one.__module__.startswith("cutjoint."):
                continue
            found.add(one)
            todo += [call for call in _calls(one) if call is not None]
        elif callable(one):
            todo += _returned(one)
    return {one for one in found if not issubclass(one, BaseException) and not getattr(one, "_is_protocol", False)}


def _calls(kind: type) -> Iterator[object]:
    """Public methods and properties of a class."""
    for name, member in inspect.getmembers(kind):
        if not name.startswith("_"):
            yield member.fget if isinstance(member, property) else getattr(member, "func", member)


def _returned(call: object) -> list[type]:
    """The classes that the annotation of what a function returns names."""
    plain = inspect.unwrap(call) if callable(call) else call
    annotation = getattr(plain, "__annotations__", {}).get("return")
    if annotation is None:
        return []
    try:
        kind = eval(annotation, getattr(plain, "__globals__", {})) if isinstance(annotation, str) else annotation
    except NameError:  # imported for type checkers alone; such classes are returned elsewhere too
        return []
    return list(_inside(kind))


def _inside(kind: object) -> Iterator[type]:
    if inspect.isclass(kind) and typing.get_origin(kind) is None:
        yield kind
    for one in typing.get_args(kind):
        yield from _inside(one)
