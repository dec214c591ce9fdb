"""Strings, keys and numbers as TOML."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence

from cutjoint.arrays import Array
from cutjoint.description.formats.common.exact import number as number

_ESCAPED = re.compile("[\x7f-\x9f\ufffe\uffff]")
"""What TOML does not allow as it is, nor XML, into which it may go."""
_BARE = re.compile(r"^[A-Za-z0-9_-]+$")


def text(value: str) -> str:
    """A TOML basic string."""
    plain = json.dumps(value, ensure_ascii=False)
    return _ESCAPED.sub(lambda found: f"\\u{ord(found[0]):04x}", plain)


def key(name: str) -> str:
    """A TOML key, quoted where it must be."""
    return name if _BARE.match(name) else text(name)


def numbers(values: Sequence[float] | Array) -> str:
    """A list of numbers."""
    return f"[{', '.join(number(value) for value in values)}]"
