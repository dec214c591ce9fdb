"""Writing a description: loops.toml with its URDF, a URDF with `<constraint>`, or MJCF.  Reading it back loses nothing.

A new format is a function that gives the texts of its files, and a row in `WRITERS`.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from pathlib import Path

from cutjoint.description.model import RobotDescription
from cutjoint.description.writers.files import write_files
from cutjoint.description.writers.mjcf import mjcf_files
from cutjoint.description.writers.native import native_files
from cutjoint.description.writers.urdf import constraint_files
from cutjoint.errors import UnknownNameError

__all__ = ["WRITERS", "write"]

Texts = Callable[[RobotDescription, Path], Mapping[Path, bytes]]
"""(description, path to write) -> the content of every file, the first being the one to read again."""

WRITERS: Mapping[str, Texts] = {"loops": native_files, "urdf": constraint_files, "mjcf": mjcf_files}


def write(description: RobotDescription, path: str | os.PathLike[str], to: str = "loops") -> tuple[Path, ...]:
    """Write a description to a file, or for `loops` to a folder or its loops.toml.

    Args:
        description: what to write; a variant that was chosen is written as the tree's own inertias.
        path: where to; files there are replaced, each as a whole.
        to: `loops` (loops.toml and robot.urdf), `urdf` (with `<constraint>`) or `mjcf`.

    Returns:
        The files, the one to read again first.

    Raises:
        UnknownNameError: there is no such format.
        OSError: the place cannot be written to.
    """
    if to not in WRITERS:
        raise UnknownNameError("format", to, tuple(WRITERS))
    return write_files(WRITERS[to](description, Path(path)))
