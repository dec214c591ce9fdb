"""TOML tables that are read key by key: each key has a type, unknown keys are noted with the nearest known one.

More kinds of values are in `cutjoint.toml.taking`.  `tomllib` keeps no line numbers; `line_index` finds them again by
the headers and keys of the text.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping

from cutjoint.findings import LARGEST_LENGTH, Findings, Place, check_range, clip

Keys = tuple[str | int, ...]

_HEADER = re.compile(r"^\s*(\[\[?)\s*(.+?)\s*(\]\]?)\s*(#.*)?$")
_KEY = re.compile(r"""^\s*((?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|"[^"]*"|'[^']*'))*)\s*=""")
_PART = re.compile(r"""[A-Za-z0-9_-]+|"[^"]*"|'[^']*'""")


def parse(data: bytes, findings: Findings) -> dict[str, object] | None:
    """TOML in memory as plain values, or None after noting why it does not parse."""
    try:
        return tomllib.loads(data.decode("utf-8"))
    except tomllib.TOMLDecodeError as error:
        text = str(error)
        line = re.search(r"at line (\d+)", text)
        number = int(line.group(1)) if line else None
        wrong = data.decode("utf-8").splitlines()[number - 1] if number else ""
        mend = "write decimal points, not commas" if re.search(r"\d,\d", wrong) else ""
        findings.error(f"the TOML does not parse: {text}", "TOML 1.0", mend, number)
    except UnicodeDecodeError as error:
        findings.error(f"not UTF-8 text: {error.reason} at byte {error.start}", "TOML in UTF-8")
    except (ValueError, RecursionError) as error:
        findings.error(f"the TOML does not parse: {clip(str(error), 120)}", "TOML 1.0")
    return None


def line_index(text: str) -> dict[Keys, int]:
    """Line number (from 1) of each header and key; entries of arrays of tables count from 0."""
    index: dict[Keys, int] = {}
    counts: dict[Keys, int] = {}
    header: Keys = ()
    for number, line in enumerate(text.splitlines(), 1):
        found = _HEADER.match(line)
        if found and "=" not in found.group(2):
            header = _parts(found.group(2))
            if found.group(1) == "[[":
                counts[header] = counts.get(header, -1) + 1
                header = (*header, counts[header])
            for size in range(1, len(header) + 1):
                index.setdefault(header[:size], number)
            continue
        key = _KEY.match(line)
        if key:
            index.setdefault((*header, *_parts(key.group(1))), number)
    return index


def _parts(text: str) -> Keys:
    return tuple(part.strip("\"'") for part in _PART.findall(text))


class TomlTable:
    """One TOML table.  Every getter notes what is wrong and returns a harmless value."""

    def __init__(self, data: Mapping[str, object], path: Keys, lines: Mapping[Keys, int], findings: Findings) -> None:
        self.data, self.path, self.lines, self.findings = data, path, lines, findings
        self._known: list[str] = []

    @property
    def name(self) -> str:
        """The table as it is written, such as `[[cut]] 2` or `[home.default]`."""
        if self.path and isinstance(self.path[-1], int):
            return f"[[{'.'.join(map(str, self.path[:-1]))}]] {self.path[-1] + 1}"
        return f"[{'.'.join(map(str, self.path))}]" if self.path else "the file"

    def place(self, key: str | None = None) -> Place:
        """Where `key` (or the table) stands."""
        path = self.path if key is None else (*self.path, key)
        while path and path not in self.lines:
            path = path[:-1]
        return Place(self.findings.file, self.lines.get(path))

    def take(self, key: str, required: bool = False, expected: str = "") -> object:
        """The raw value of `key`, or None.  Counts as known from now on."""
        self._known.append(key)
        if required and key not in self.data:
            self.findings.error(f"{self.name} without '{key}'", expected, f"add {key} = ...", self.place())
        return self.data.get(key)

    def string(self, key: str, default: str = "", required: bool = False) -> str:
        """A string."""
        value = self.take(key, required, "a string")
        if value is None:
            return default
        if not isinstance(value, str):
            self.wrong(key, value, 'a string, as in key = "text"')
            return default
        return value

    def strings(self, key: str, required: bool = False) -> tuple[str, ...] | None:
        """A list of strings, or None where it is missing or wrong."""
        value = self.take(key, required, "a list of strings")
        if value is None:
            return None
        if not isinstance(value, list) or not all(isinstance(item, str) for item in value):
            self.wrong(key, value, 'a list of strings, as in ["a", "b"]')
            return None
        return tuple(value)

    def number(
        self, key: str, default: float | None = 0.0, required: bool = False, largest: float = LARGEST_LENGTH
    ) -> float | None:
        """A finite number; the default where it is missing, None where it is wrong."""
        value = self.take(key, required, "a number")
        if value is None:
            return None if required else default
        numbers = self.numbers(key, value, largest)
        if numbers is not None and len(numbers) == 1 and not isinstance(value, list):
            return numbers[0]
        if numbers is not None:
            self.wrong(key, value, "a number")
        return None

    def vector(
        self, key: str, count: int, default: tuple[float, ...] | None = None, required: bool = False,
        largest: float = LARGEST_LENGTH,
    ) -> tuple[float, ...] | None:  # fmt: skip
        """`count` finite numbers; the default where they are missing, None where they are wrong."""
        value = self.take(key, required, f"{count} numbers")
        if value is None:
            return None if required else default
        if not isinstance(value, list) or len(value) != count:
            self.wrong(key, value, f"{count} numbers, as in [{', '.join(['0.0'] * count)}]")
            return None
        return self.numbers(key, value, largest)

    def values(self, key: str) -> tuple[float, ...] | float | None:
        """A finite number or a list of them; None where it is wrong or missing."""
        value = self.take(key)
        numbers = self.numbers(key, value, LARGEST_LENGTH)
        return numbers if isinstance(value, list) or numbers is None else numbers[0]

    def table(self, key: str) -> TomlTable | None:
        """A table, or None."""
        value = self.take(key)
        if value is None:
            return None
        if not isinstance(value, dict):
            self.wrong(key, value, f"a table, as in [{'.'.join(map(str, (*self.path, key)))}]")
            return None
        return TomlTable(value, (*self.path, key), self.lines, self.findings)

    def tables(self, key: str) -> Iterator[TomlTable]:
        """The entries of an array of tables."""
        value = self.take(key)
        if value is None:
            return
        if not isinstance(value, list) or not all(isinstance(item, dict) for item in value):
            self.wrong(key, value, f"tables headed [[{key}]]")
            return
        for number, item in enumerate(value):
            yield TomlTable(item, (*self.path, key, number), self.lines, self.findings)

    def named_tables(self, key: str) -> Iterator[tuple[str, TomlTable]]:
        """The named tables under `key`, as in [key.NAME]."""
        parent = self.table(key)
        if parent is not None:
            for name in parent.data:
                table = parent.table(name)
                if table is not None:
                    yield name, table

    def finish(self) -> None:
        """Note every key that nobody asked for."""
        for key in self.data:
            if key not in self._known:
                self.findings.unknown(
                    f"unknown key '{clip(key)}' in {self.name}", key, sorted(self._known), self.place(key)
                )

    def wrong(self, key: str, value: object, expected: str) -> None:
        """Note that the value of `key` is not what was expected."""
        self.findings.error(f"{key} of {self.name} is {clip(repr(value))}", expected, "", self.place(key))

    def numbers(self, key: str, value: object, largest: float) -> tuple[float, ...] | None:
        """A number or a list of numbers that stands in the value of `key`, or None after noting what is wrong."""
        items = value if isinstance(value, list) else [value]
        given = [item for item in items if isinstance(item, (int, float)) and not isinstance(item, bool)]
        if len(given) < len(items):
            self.wrong(key, value, "numbers without quotes" if isinstance(value, (str, list)) else "a number")
            return None
        try:
            numbers = tuple(map(float, given))
        except OverflowError:
            self.wrong(key, "a whole number beyond 1e308", "a number that fits a double")
            return None
        what = f"{key} of {self.name}"
        return numbers if check_range(numbers, what, self.findings, self.place(key), largest) else None
