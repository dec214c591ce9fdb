"""Tables of settings in TOML, read key by key: a key that nobody asks for is an error that names the nearest one.

    file = read_settings("synthesis.toml")
    robot = file.text("robot")
    runs = file.whole("designs", 200, least=1)
    for one in file.tables("vary"): ...
    file.finish()

Every error says which file, which table and which key.
"""

from __future__ import annotations

import math
import os
import tomllib
from collections.abc import Mapping, Sequence
from typing import TypeGuard, TypeVar

from cutjoint.errors import InputError, nearest, shown
from cutjoint.files import path_name, read_file
from cutjoint.reprs import line

LARGEST = 4_000_000
"""Bytes of a file of settings."""

Default = TypeVar("Default", bound=object)


class Missing:
    """What stands where no default is given."""

    __repr__ = line()


MISSING = Missing()


class Settings:
    """One table: the file's whole, or one inside it.

    Attributes:
        where: file and table, for messages.
    """

    __repr__ = line("where")

    def __init__(self, data: Mapping[str, object], where: str) -> None:
        self._data, self.where = data, where
        self._asked: list[str] = []
        self._inner: list[Settings] = []

    def __contains__(self, key: object) -> bool:
        return key in self._data

    def wrong(self, key: str, expected: str) -> InputError:
        """The error for a value that is not what is expected."""
        found = shown(repr(self._data[key]), 80) if key in self._data else "nothing"
        return InputError(f"{self.where}: {key} must be {expected}, found {found}")

    def _take(self, key: str, default: object, expected: str) -> object:
        self._asked.append(key)
        if key in self._data:
            return self._data[key]
        if default is MISSING:
            raise self.wrong(key, expected)
        return default

    def text(self, key: str, default: Default | Missing = MISSING, choices: Sequence[str] = ()) -> str | Default:
        """A text; with `choices` one of these.

        Raises:
            InputError: it is none, or not there and without a default.
        """
        expected = f"one of {', '.join(choices)}" if choices else "a text"
        value = self._take(key, default, expected)
        if key not in self._data:
            return value  # type: ignore[return-value]
        if not isinstance(value, str) or (choices and value not in choices):
            raise self.wrong(key, expected)
        return value

    def texts(self, key: str, default: Default | Missing = MISSING) -> tuple[str, ...] | Default:
        """A text or a list of texts.

        Raises:
            InputError: it is neither, or empty, or not there and without a default.
        """
        value = self._take(key, default, "a text or a list of texts")
        if key not in self._data:
            return value  # type: ignore[return-value]
        found = [value] if isinstance(value, str) else value
        if not isinstance(found, list) or not found or not all(isinstance(one, str) for one in found):
            raise self.wrong(key, "a text or a list of texts")
        return tuple(found)

    def number(
        self,
        key: str,
        default: Default | Missing = MISSING,
        *,
        unit: str = "",
        least: float = -math.inf,
        above: float = -math.inf,
    ) -> float | Default:
        """A finite number, at least `least` and larger than `above`.

        Raises:
            InputError: it is none, or not there and without a default.
        """
        expected = "a finite number" + (f" [{unit}]" if unit else "")
        expected += f" >= {least:g}" if least > -math.inf else ""
        expected += f" > {above:g}" if above > -math.inf else ""
        value = self._take(key, default, expected)
        if key not in self._data:
            return value  # type: ignore[return-value]
        if not _is_number(value):
            raise self.wrong(key, expected)
        if value < least or value <= above:
            raise self.wrong(key, expected)
        return float(value)

    def whole(self, key: str, default: Default | Missing = MISSING, *, least: int = 0) -> int | Default:
        """A whole number, at least `least`.

        Raises:
            InputError: it is none, or not there and without a default.
        """
        value = self._take(key, default, f"a whole number >= {least}")
        if key not in self._data:
            return value  # type: ignore[return-value]
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise self.wrong(key, f"a whole number >= {least}")
        return value

    def yes(self, key: str, default: bool) -> bool:
        """True or false.

        Raises:
            InputError: it is neither.
        """
        value = self._take(key, default, "true or false")
        if not isinstance(value, bool):
            raise self.wrong(key, "true or false")
        return value

    def numbers(
        self, key: str, default: Default | Missing = MISSING, *, size: int | None = None, unit: str = ""
    ) -> tuple[float, ...] | Default:
        """A list of finite numbers, so many as `size` says.

        Raises:
            InputError: it is none, or not there and without a default.
        """
        expected = f"a list of {'' if size is None else f'{size} '}finite numbers" + (f" [{unit}]" if unit else "")
        value = self._take(key, default, expected)
        if key not in self._data:
            return value  # type: ignore[return-value]
        if not isinstance(value, list) or (size is not None and len(value) != size):
            raise self.wrong(key, expected)
        if not all(map(_is_number, value)):
            raise self.wrong(key, expected)
        return tuple(map(float, value))

    def table(self, key: str) -> Settings | None:
        """The table below a key, or None where there is none.

        Raises:
            InputError: it is no table.
        """
        value = self._take(key, None, "a table")
        if value is None:
            return None
        if not isinstance(value, dict):
            raise self.wrong(key, f"a table, [{key}]")
        return self._below(value, f"[{key}]")

    def tables(self, key: str) -> tuple[Settings, ...]:
        """The tables of a list, [[key]]; none where there is none.

        Raises:
            InputError: it is no list of tables.
        """
        value = self._take(key, [], f"tables, [[{key}]]")
        if not isinstance(value, list) or not all(isinstance(one, dict) for one in value):
            raise self.wrong(key, f"tables, [[{key}]]")
        return tuple(self._below(one, f"[[{key}]] {k}") for k, one in enumerate(value, start=1))

    def _below(self, data: Mapping[str, object], name: str) -> Settings:
        below = Settings(data, f"{self.where}, {name}")
        self._inner.append(below)
        return below

    def finish(self) -> None:
        """Look for keys that nobody has asked for, here and in all tables below.

        Raises:
            InputError: there is one; it names the nearest key that is known here.
        """
        for key in self._data:
            if key not in self._asked:
                near = nearest(key, self._asked)
                hint = f"did you mean {' or '.join(near)}?" if near else f"known here: {', '.join(sorted(self._asked))}"
                raise InputError(f"{self.where}: there is no key '{shown(key, 60)}'; {hint}")
        for one in self._inner:
            one.finish()


def read_settings(path: str | os.PathLike[str]) -> Settings:
    """The settings in a TOML file.

    Raises:
        FileError: there is none, or it cannot be read.
        InputError: it is no TOML; the message says where.
    """
    name = path_name(path)
    data = read_file(path, LARGEST)
    try:
        return Settings(tomllib.loads(data.decode("utf-8")), name)
    except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
        raise InputError(f"{name}: this is no TOML: {error}") from error


def _is_number(value: object) -> TypeGuard[float]:
    """Whether a value is a finite number, as a float has it."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond the floats
        return False
