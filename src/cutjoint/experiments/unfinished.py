"""The runs of a reproduction that was interrupted, kept in the user's cache folder for the next one.

They are found again by the same code only: the name is the digest of everything that decides them, the package's text,
the robots' files and the versions of what computes.  What is kept are pickles, so they are read only where nobody but
the user can have written them (`cutjoint.compile.kept`).
"""

from __future__ import annotations

import pickle
import zlib
from collections.abc import Mapping
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from cutjoint import interrupts
from cutjoint.compile import kept
from cutjoint.description import catalogue
from cutjoint.pool import Key, Outcome

KIND = "reproduction/runs"
DECISIVE = ("numpy", "scipy", "pin")
"""Packages whose version decides digits."""


def keep(robot: str, found: Mapping[Key, Outcome]) -> bool:
    """Keep what was done for a robot; whether that worked."""
    data = zlib.compress(pickle.dumps(dict(found)), 1)
    with interrupts.keeping():
        kept.write(KIND, _name(robot), data)
        return kept.read(KIND, _name(robot)) == data


def take(robot: str) -> dict[Key, Outcome]:
    """What was done for a robot before an interrupt; nothing where there was none."""
    data = kept.read(KIND, _name(robot))
    if data is None:
        return {}
    found: dict[Key, Outcome] = pickle.loads(zlib.decompress(data))
    return found


def drop(robot: str) -> None:
    """Forget it."""
    kept.drop(KIND, _name(robot))


def _name(robot: str) -> str:
    """Digest of all that decides the runs of a robot."""
    digest = sha256(robot.encode())
    for name in DECISIVE:
        try:
            digest.update(f"{name} {version(name)}\0".encode())
        except PackageNotFoundError:
            digest.update(f"{name}\0".encode())
    package = Path(__file__).parents[1]
    for folder, kind in ((package, "*.py"), (catalogue.path(robot).parent, "*")):
        for file in sorted(folder.rglob(kind)):
            if file.is_file():
                digest.update(file.relative_to(folder).as_posix().encode() + b"\0" + file.read_bytes() + b"\0")
    return digest.hexdigest()
