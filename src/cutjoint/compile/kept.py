"""Files in the user's cache folder that nobody else can have written.

A file is used only if it is a regular file (no link) that belongs to the user and that nobody else can write, in such a
folder, and repeats its own name inside.  Anything else is as if it were not there.  Files appear whole or not at all
(`cutjoint.files`), so processes that write the same one at once do not notice each other.
"""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from collections.abc import Iterator
from functools import cache
from hashlib import sha256
from importlib import resources
from pathlib import Path

from cutjoint.files import write_files

DECISIVE = ("compile", "papers", "description/cuts.py")
"""What decides what a program is: the compiler, the papers, the equations of cut joints."""
LARGEST_FILE = 256 * 1024 * 1024
_PRIVATE = stat.S_IWGRP | stat.S_IWOTH


def folder() -> Path:
    """`$CUTJOINT_CACHE`, or `cutjoint` in the user's cache folder (XDG_CACHE_HOME, ~/.cache, or their like)."""
    given = os.environ.get("CUTJOINT_CACHE")
    if given:
        return Path(given)
    if sys.platform == "win32":
        root = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        root = str(Path.home() / "Library" / "Caches")
    else:
        root = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(root) / "cutjoint"


@cache
def code_version() -> str:
    """Digest of the source text that decides what a program is, and of the version."""
    from importlib.metadata import PackageNotFoundError, version

    digest = sha256()
    try:
        digest.update(version("cutjoint").encode())
    except PackageNotFoundError:
        digest.update(b"unknown")
    for place in DECISIVE:
        for name, text in sources(place):
            digest.update(name.encode() + b"\0" + text + b"\0")
    return digest.hexdigest()


def sources(path: str) -> Iterator[tuple[str, bytes]]:
    """Path and text of a Python file of the package, or of every one in a folder, in a fixed order."""
    place = resources.files("cutjoint").joinpath(path)
    if place.is_dir():
        for name in sorted(entry.name for entry in place.iterdir()):
            yield from sources(f"{path}/{name}")
    elif path.endswith(".py"):
        yield path, place.read_bytes()


def read(kind: str, name: str) -> bytes | None:
    """What is kept under a name, or None where there is nothing that may be used.

    Args:
        kind: folder and ending, such as `programs/program`.
        name: 64 hexadecimal digits.
    """
    place, ending = _place(kind)
    try:
        if not _ours(os.lstat(place)):
            return None
        handle = os.open(
            place / f"{name}.{ending}", os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
        )
    except OSError:
        return None
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or not _ours(status) or status.st_size > LARGEST_FILE:
            return None
        data = file.read()
    return data[len(name) + 1 :] if data.startswith(name.encode() + b"\n") else None


def write(kind: str, name: str, data: bytes) -> None:
    """Keep data under a name.  A folder that cannot be written is no error: it is simply made again next time."""
    place, ending = _place(kind)
    with contextlib.suppress(OSError):
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        if _ours(os.lstat(place)):
            write_files({place / f"{name}.{ending}": name.encode() + b"\n" + data}, private=True)


def drop(kind: str, name: str) -> None:
    """Forget what is kept under a name."""
    place, ending = _place(kind)
    with contextlib.suppress(OSError):
        os.unlink(place / f"{name}.{ending}")


def _place(kind: str) -> tuple[Path, str]:
    inside, _, ending = kind.partition("/")
    return folder() / inside, ending


def _ours(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user and can be written by nobody else."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & _PRIVATE
