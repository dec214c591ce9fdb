"""Files are written whole or not at all: to a neighbour first, which then takes the asked name."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from cutjoint.errors import InputError


def write_files(contents: Mapping[Path, bytes], *, private: bool = False) -> tuple[Path, ...]:
    """Write each content to its path; the old files stay until all new ones are there.  Returns the paths.

    `private` makes files that only their owner can read and that need not outlive a power cut, as in a cache.

    Raises:
        OSError: a folder does not exist, or a file cannot be written.
    """
    waiting: list[tuple[str, Path]] = []
    try:
        for path, content in contents.items():
            handle, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
            waiting.append((name, path))
            with os.fdopen(handle, "wb") as file:
                file.write(content)
                if not private:
                    file.flush()
                    os.fsync(file.fileno())
            if not private:
                os.chmod(name, 0o666 & ~_umask())  # mkstemp makes private files; these are ordinary ones
        while waiting:
            os.replace(*waiting[0])
            waiting.pop(0)
    finally:
        for name, _ in waiting:
            Path(name).unlink(missing_ok=True)
    return tuple(contents)


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` (text as UTF-8) to `path`, replacing what is there only when all of it is on disk.

    Raises:
        InputError: the folder does not exist, or the file cannot be written.
    """
    target = check_place(path)
    try:
        write_files({target: content.encode() if isinstance(content, str) else content})
    except OSError as error:
        raise InputError(f"cannot write {target}: {error.strerror or error}") from error
    return target


def check_place(path: str | os.PathLike[str]) -> Path:
    """`path` as a place where a file can be written; worth asking before a long run.

    Raises:
        InputError: the folder does not exist, or there is a folder of that name.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"the folder {str(target.parent)!r} does not exist; make it first")
    if target.is_dir():
        raise InputError(f"{str(target)!r} is a folder; give a file name")
    return target


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
