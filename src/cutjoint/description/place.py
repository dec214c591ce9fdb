"""Where in a file something stands."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Place:
    """Where in a file something stands, for messages."""

    file: str = ""
    line: int | None = None

    __repr__ = line()


NOWHERE = Place()
"""Of what no file has."""
