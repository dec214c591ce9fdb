"""Where in a file something stands."""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.reprs import told


@dataclass(frozen=True)
class Place:
    """Where in a file something stands, for messages."""

    file: str = ""
    line: int | None = None

    def __repr__(self) -> str:
        return told(self)


NOWHERE = Place()
"""Of what no file has."""
