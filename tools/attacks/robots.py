"""Spoiled robot files of every format: read as what they say, or refused by problems; nothing else.

What "as they say" means is asked of each file that is accepted: all its numbers are finite and of plausible size; it
reads the same twice; a number that was changed in the text changed the robot, or made a warning, unless it stands where
another value means the same.  The last is counted ("silent"), and told with `--show`, as a person has to judge it.
"""

from __future__ import annotations

import dataclasses
import re
import shutil
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path

import numpy as np

from attacks.judging import Attack, Wrong
from attacks.seeds import laid, seeds
from cutjoint.description import RobotDescription, load_description, read_checked

Random = np.random.Generator
NUMBER = re.compile(r"(?<![\w.#])-?\d+(\.\d+)?(e[+-]?\d+)?(?![\w.])")
TOKEN = re.compile(r"[\w.+-]+|[^\w\s]")
WORDS = (
    *(
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-1e308",
        "1e-320",
        "1e400",
        "-0",
        "-1",
        "1e9",
        "0x10",
        "1_000",
        "1,5",
        "9" * 400,
        "",
    ),
    *(" ", "½", "\ud7ff", "&amp;", "&#0;", "<", ">", '"', "'", "[", "]", "{", "}", "=", "\n", "#", "a/b", "${x}"),
    *("<!--", "]]>", "<!DOCTYPE x>", "<?x?>", "/dev/zero", "../../etc/passwd", "file:///dev/zero", "x" * 300),
)


def attacks(seed: int, count: int, folder: Path) -> Iterator[Attack]:
    """`count` files, of all seeds in turn."""
    sources = list(seeds())
    for number in range(count):
        source = sources[number % len(sources)]
        yield Attack(f"robots {source} {seed}:{number}", partial(_act, source, seed, number, folder))


def _act(source: str, seed: int, number: int, folder: Path) -> str:
    rng = np.random.default_rng([seed, number])
    files = seeds()[source]
    which = list(files)[int(rng.integers(len(files)))]
    kind = list(KINDS)[int(rng.integers(len(KINDS)))]
    spoiled = files[which]
    for _ in range(1 if kind in ("number", "typo") else int(rng.integers(1, 4))):
        spoiled = KINDS[kind](rng, spoiled)
    place = folder / "spoiled"
    shutil.rmtree(place, ignore_errors=True)
    reading = read_checked(laid({**files, which: spoiled}, place))
    if reading.description is None:
        if not any(one.severity == "error" for one in reading.problems):
            raise Wrong("refused without an error")
        if long := [one for one in map(str, reading.problems) if len(one) > 5000 or "\n" in one]:
            raise Wrong(f"a problem that is no short line: {long[0][:300]}")
        return "refused"
    found = _numbers(reading.description)
    if not all(np.isfinite(value) and abs(value) <= 1e15 for value in found):
        raise Wrong(
            f"accepted with numbers that are not plausible: {[one for one in found if not abs(one) <= 1e15][:5]}"
        )
    if spoiled == files[which]:
        return "unchanged"
    if kind in ("number", "typo") and found == _numbers(_original(source, folder)) and not reading.problems:
        return f"silent {kind}"
    return "accepted"


@cache
def _original(source: str, folder: Path) -> RobotDescription:
    return load_description(laid(seeds()[source], folder / "original"), lenient=True)


def _numbers(value: object) -> list[float]:
    """All finite-or-not numbers of a description, in order; limits that are none are left out."""
    if isinstance(value, np.ndarray):
        return [float(one) for one in value.ravel()]
    if isinstance(value, bool) or value is None:
        return []
    if isinstance(value, int | float):
        return [float(value)]
    if dataclasses.is_dataclass(value):
        if type(value).__name__ == "Place":  # the number of a line
            return []
        return [x for one in dataclasses.fields(value) for x in _numbers(getattr(value, one.name))]
    if isinstance(value, Mapping):
        return [x for one in value.values() for x in _numbers(one)]
    if isinstance(value, tuple | list):
        return [x for one in value for x in _numbers(one)]
    return []


def _number(rng: Random, text: str) -> str:
    found = list(NUMBER.finditer(text))
    if not found:
        return text
    at = found[int(rng.integers(len(found)))]
    value = float(at.group()) * float(rng.choice([-1.0, 0.5, 2.0, 1e3, 1e8, 1.001])) + float(rng.choice([0.0, 0.1]))
    return f"{text[: at.start()]}{value!r}{text[at.end() :]}"


def _word(rng: Random, text: str) -> str:
    found = list(TOKEN.finditer(text))
    if not found:
        return text
    at = found[int(rng.integers(len(found)))]
    return text[: at.start()] + WORDS[int(rng.integers(len(WORDS)))] + text[at.end() :]


def _typo(rng: Random, text: str) -> str:
    """Two letters of a word exchanged."""
    found = [one for one in re.finditer(r"[A-Za-z_]{3,}", text) if len(set(one.group())) > 1]
    if not found:
        return text
    at = found[int(rng.integers(len(found)))]
    word = list(at.group())
    places = [k for k in range(len(word) - 1) if word[k] != word[k + 1]]
    k = places[int(rng.integers(len(places)))]
    word[k], word[k + 1] = word[k + 1], word[k]
    return text[: at.start()] + "".join(word) + text[at.end() :]


def _line(rng: Random, text: str) -> str:
    lines = text.split("\n")
    at = int(rng.integers(len(lines)))
    what = int(rng.integers(3))
    if what == 0:
        del lines[at]
    elif what == 1:
        lines.insert(int(rng.integers(len(lines))), lines[at])
    else:
        lines.insert(int(rng.integers(len(lines))), lines.pop(at))
    return "\n".join(lines)


def _cut(rng: Random, text: str) -> str:
    return text[: int(rng.integers(len(text) + 1))]


def _letters(rng: Random, text: str) -> str:
    at = int(rng.integers(len(text) + 1))
    made = "".join(chr(int(rng.integers(1, 0xD000))) for _ in range(int(rng.integers(5))))
    return text[:at] + made + text[at + int(rng.integers(5)) :]


def _deep(rng: Random, text: str) -> str:
    """Something nested without end, in the middle."""
    at = int(rng.integers(len(text) + 1))
    count = int(rng.choice([50, 200, 20_000]))
    return text[:at] + str(rng.choice(["<a>", "[", "{", '{"a":', "("])) * count + text[at:]


KINDS: Mapping[str, Callable[[Random, str], str]] = {
    "number": _number,
    "word": _word,
    "typo": _typo,
    "line": _line,
    "cut": _cut,
    "letters": _letters,
    "deep": _deep,
}
"""Ways to spoil a text."""
