"""Kinds of values beside those of `TomlTable`: each is taken, what is wrong with it is noted, a harmless one given."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from cutjoint.errors import CutjointError
from cutjoint.findings import nearest
from cutjoint.toml.table import TomlTable

Made = TypeVar("Made")


def whole(table: TomlTable, key: str, least: int, most: int) -> int | None:
    """A whole number, or None where it is missing or wrong."""
    value = table.take(key)
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if value is None or (isinstance(value, int) and not isinstance(value, bool) and least <= value <= most):
        return value
    table.wrong(key, value, f"a whole number from {least} to {most:.4g}")
    return None


def positive(table: TomlTable, key: str, *, zero: bool = False) -> float | None:
    """A number > 0 (or >= 0 with `zero`), or None where it is missing or wrong."""
    value = table.number(key, None)
    if value is not None and not (value > 0.0 or (zero and value == 0.0)):
        table.wrong(key, value, "a number >= 0" if zero else "a number > 0")
        return None
    return value


def truth(table: TomlTable, key: str) -> bool:
    """True or false; false where it is missing or wrong."""
    value = table.take(key)
    if value is not None and not isinstance(value, bool):
        table.wrong(key, value, "true or false")
    return value is True


def one_of(table: TomlTable, key: str, known: Sequence[str], default: str) -> str:
    """One of the known texts; `default` where it is missing or wrong."""
    value = table.string(key, default)
    if value in known:
        return value
    table.findings.error(
        f"{key} of {table.name} is '{value[:60]}'",
        " or ".join(f'"{one}"' for one in known if one),
        nearest(value, known),
        table.place(key),
    )
    return default


def texts(table: TomlTable, key: str, required: bool = False) -> tuple[str, ...]:
    """A text or a list of texts; none where it is missing or wrong."""
    if isinstance(table.data.get(key), str):
        return (table.string(key),)
    found = table.strings(key, required)
    if found == ():
        table.wrong(key, [], "a list that is not empty")
    return found or ()


def several(table: TomlTable, key: str) -> list[TomlTable]:
    """One table, [key], or an array of them, [[key]]."""
    if isinstance(table.data.get(key), dict):
        one = table.table(key)
        return [] if one is None else [one]
    return list(table.tables(key))


def each(table: TomlTable | None, made: Callable[[str, object], Made]) -> dict[str, Made]:
    """What `made` makes of every key and its value, by key; its errors are noted at the key, which is left out."""
    found = {}
    for key in () if table is None else table.data:
        assert table is not None
        try:
            found[key] = made(key, table.take(key))
        except CutjointError as error:
            table.findings.error(str(error), at=table.place(key))
    return found
