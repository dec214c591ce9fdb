"""The words about a run out of a file: plain JSON of bounded depth and size, and every known word of its own type."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import NoReturn, cast

from cutjoint.simulation.result import About

DEEPEST = 12
LARGEST = 10**300
"""Of whole numbers, so that each is a float too."""


def json_words(text: str) -> dict[str, object]:
    """A JSON object, in which all numbers are finite.

    Raises:
        ValueError: it is none; or nested deeper than `DEEPEST`.
    """
    found = json.loads(text, parse_constant=_no_number, object_pairs_hook=_once)
    if not isinstance(found, dict):
        raise ValueError(f"what is said about the run is no JSON object, but {type(found).__name__}")
    _check_plain(found, DEEPEST)
    return found


def about_of(words: Mapping[str, object]) -> About:
    """`words` as what is said about a run; words that this version does not know stay as they are.

    Raises:
        ValueError: a known word is of another type.
    """
    for word, (fits, expected) in _KINDS.items():
        if word in words and not fits(words[word]):
            raise ValueError(f"about['{word}'] is {_short(words[word])}, expected {expected}")
    names = [one[0] for one in cast("list[list[str]]", words.get("actuators", []))]
    if len(set(names)) < len(names):
        raise ValueError(f"about['actuators'] names one twice: {', '.join(names)}")
    return cast(About, dict(words))


def _no_number(word: str) -> NoReturn:
    raise ValueError(f"what is said about the run has {word}, expected finite numbers")


def _once(pairs: list[tuple[str, object]]) -> dict[str, object]:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("what is said about the run says a word twice")
    return found


def _check_plain(value: object, depth: int) -> None:
    if depth == 0:
        raise ValueError(f"what is said about the run is nested more than {DEEPEST} levels deep")
    if isinstance(value, dict | list):
        parts = [*value, *value.values()] if isinstance(value, dict) else value
        for part in parts:
            _check_plain(part, depth - 1)
    elif isinstance(value, str):
        value.encode()  # halves of characters cannot be shown
    elif isinstance(value, int) and abs(value) > LARGEST:
        raise ValueError("what is said about the run has a whole number of more than 300 digits")
    elif isinstance(value, float) and not math.isfinite(value):
        raise ValueError("what is said about the run has a number that is not finite")


def _is_text(value: object) -> bool:
    return isinstance(value, str)


def _is_count(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _is_list(of: Callable[[object], bool]) -> Callable[[object], bool]:
    return lambda value: isinstance(value, list) and all(map(of, value))


def _is_actuator(value: object) -> bool:
    return _is_list(_is_text)(value) and len(cast("list[str]", value)) == 2


def _is_limits(value: object) -> bool:
    return value is None or _is_number(value) or _is_list(_is_number)(value)


def _is_object(value: object) -> bool:
    return isinstance(value, dict)


def _is_options(value: object) -> bool:
    """As `cutjoint simulate` was given them: variant, ideal, lenient, payload."""
    kinds = {"variant": _is_text, "ideal": _is_flag, "lenient": _is_flag, "payload": _is_number}
    return isinstance(value, dict) and all(name in kinds and kinds[name](one) for name, one in value.items())


def _is_flag(value: object) -> bool:
    return isinstance(value, bool)


_TEXT = (_is_text, "a text")
_COUNT = (_is_count, "a count")
_KINDS: Mapping[str, tuple[Callable[[object], bool], str]] = {
    **dict.fromkeys(("robot", "plant", "not_compiled", "law", "trajectory", "reference", "integrator"), _TEXT),
    **dict.fromkeys(("stopped", "fingerprint", "file"), _TEXT),
    **dict.fromkeys(("run_number", "steps", "evaluations"), _COUNT),
    "gains": (_is_object, "gains by name"),
    "rate": (lambda value: value is None or _is_number(value), "a number or null"),
    "strayed": (_is_number, "a number"),
    "limits": (_is_limits, "a number, one an actuator, or null"),
    "actuators": (_is_list(_is_actuator), "a name and a kind an actuator"),
    "joints": (_is_list(_is_actuator), "a name and a type a joint"),
    "locked": (_is_list(_is_text), "names of actuators"),
    "options": (_is_options, "options of a robot"),
    "hardware": (_is_object, "the parts of the hardware"),
    "loads": (lambda value: isinstance(value, str | list), "loads"),
}


def _short(value: object) -> str:
    text = ascii(value)
    return text if len(text) <= 60 else f"{text[:57]}..."
