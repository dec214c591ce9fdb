"""Programs kept in the user's cache folder, so that tracing a robot is paid once.

What is stored is data: instructions as numbers (`Program.to_bytes`).  Machine code is made from them anew in every
process and never stored, so nothing in the folder is ever executed.  A stored program is used only if all of this
holds:

- its name is the digest of the model, the options, and the source text of the compiler and of the papers' equations, so
  a changed model or version looks for another name; and the file repeats that digest inside;
- it is a regular file (no link) that belongs to the user and that nobody else can write, in such a folder;
- its own digest matches its content, and the content is straight-line code with the arguments and results asked for;
- the numbers it gives agree with the model it claims to be (`cutjoint.compile.functions.verify` compares it with
  Pinocchio, or with the published model, before it is handed out).

Anything else is ignored and written anew.  Files appear whole or not at all (`cutjoint.files`), so
processes that compile the same robot at once do the work twice and otherwise do not notice each other.
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

from cutjoint.compile.expressions.program import Program, ProgramError
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


def key(content: str, what: str, options: str) -> str:
    """Name of a program: 64 hexadecimal digits."""
    return sha256("\0".join((code_version(), content, what, options)).encode()).hexdigest()


def read(name: str) -> Program | None:
    """The stored program, or None where there is none that may be used."""
    place = folder() / "programs"
    try:
        if not _ours(os.lstat(place)):
            return None
        handle = os.open(
            place / f"{name}.program", os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
        )
    except OSError:
        return None
    with os.fdopen(handle, "rb") as file:
        status = os.fstat(file.fileno())
        if not stat.S_ISREG(status.st_mode) or not _ours(status) or status.st_size > LARGEST_FILE:
            return None
        data = file.read()
    if not data.startswith(name.encode() + b"\n"):
        return None
    try:
        return Program.from_bytes(data[len(name) + 1 :])
    except ProgramError:
        return None


def write(name: str, program: Program) -> None:
    """Store a program.  A folder that cannot be written is no error: the program is simply traced again next time."""
    place = folder() / "programs"
    with contextlib.suppress(OSError):
        place.mkdir(parents=True, exist_ok=True, mode=0o700)
        if not _ours(os.lstat(place)):
            return
        write_files({place / f"{name}.program": name.encode() + b"\n" + program.to_bytes()}, private=True)


def drop(name: str) -> None:
    """Forget a program."""
    with contextlib.suppress(OSError):
        os.unlink(folder() / "programs" / f"{name}.program")


def _ours(status: os.stat_result) -> bool:
    """Whether a file or folder belongs to this user and can be written by nobody else."""
    if not hasattr(os, "getuid"):
        return True
    return status.st_uid == os.getuid() and not status.st_mode & _PRIVATE
