"""Files that plots and reports made before: only those are replaced where nobody named a file."""

from __future__ import annotations

from pathlib import Path

from cutjoint.errors import InputError, shown

PLOT, REPORT = "cutjoint plot", "cutjoint report"
"""What each writes into its files, and looks for."""
HEAD = 4096
"""Bytes in which that is found."""


def check_own(target: Path, mark: str) -> Path:
    """`target`, a name that nobody gave, as a place for a file of `mark`.

    Raises:
        InputError: another file is there.
    """
    if target.is_file():
        with target.open("rb") as file:
            head = file.read(HEAD)
        if mark.encode() not in head:
            raise InputError(
                f"{shown(str(target))} is there already, and `{mark}` did not make it; move it away, or name a file "
                "with -o"
            )
    return target
