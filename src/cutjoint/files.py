"""Files are written whole or not at all: to a neighbour first, which then takes the asked name."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path

from cutjoint.errors import InputError


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write `content` (text as UTF-8) to `path`, replacing what is there only when all of it is on disk.

    Raises:
        InputError: the folder does not exist, or the file cannot be written.
    """
    target = check_place(path)
    data = content.encode() if isinstance(content, str) else content
    temporary: str | None = None
    try:
        handle, temporary = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(temporary, 0o666 & ~_umask())  # mkstemp makes private files; these are ordinary ones
        os.replace(temporary, target)
    except OSError as error:
        raise InputError(f"cannot write {target}: {error.strerror or error}") from error
    finally:
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
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
