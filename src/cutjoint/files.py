"""Files are read only where they are files, and written whole or not at all.

Whatever path somebody gives, or a file names, goes through `read_file`: pipes, devices, sockets and folders are refused
before a byte is read, and no more is read than the kind of file can need.
"""

from __future__ import annotations

import errno
import os
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from cutjoint.errors import FileError, InputError

_KINDS = (
    (stat.S_ISDIR, "a directory"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISSOCK, "a socket"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
)
LONGEST_NAME = 255
"""Bytes of one name in a path, on every file system in use."""
_CHUNK = 2**20


def read_file(path: str | os.PathLike[str], largest: int) -> bytes:
    """The bytes of an ordinary file of at most `largest` bytes.

    Nothing that is not an ordinary file is opened for long or read: opening a pipe would wait for somebody to write,
    reading a device may never end, and what a path means is asked again of what was opened.

    Raises:
        FileError: there is no such file, it is none, it is larger, or it cannot be read.
    """
    name = path_name(path)
    try:
        size = check_file(name, largest)
        handle = os.open(
            name, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_NOCTTY", 0) | getattr(os, "O_BINARY", 0)
        )
        try:
            size = _ordinary(name, os.fstat(handle), largest)
            content = bytearray()
            # A file of size 0 that has something in it is none on a disk; those of /proc may be without end.
            while size and len(content) <= largest and (part := os.read(handle, _CHUNK)):
                content += part
        finally:
            os.close(handle)
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise _unreadable(name, error) from error
    if len(content) > largest:
        raise FileError(name, _too_large(len(content), largest))
    return bytes(content)


def check_file(path: str | os.PathLike[str], largest: int) -> int:
    """The size of an ordinary file of at most `largest` bytes, which is not opened: for what others read by its path.

    Raises:
        FileError: there is no such file, it is none, or it is larger.
    """
    name = path_name(path)
    try:
        return _ordinary(name, os.stat(name), largest)
    except (OSError, ValueError) as error:
        if isinstance(error, FileError):
            raise
        raise _unreadable(name, error) from error


def is_file(path: str | os.PathLike[str]) -> bool:
    """Whether an ordinary file is there; False too where the path is none that could be asked about."""
    try:
        return stat.S_ISREG(os.stat(path).st_mode)
    except (OSError, ValueError):
        return False


def path_name(path: str | os.PathLike[str]) -> str:
    """`path` as text.

    Raises:
        FileError: it is empty, or no path of this system.
    """
    name = os.fsdecode(path)
    if not name:
        raise FileError(name, "an empty name", "give the path of a file")
    if "\0" in name:
        raise FileError(name, "a name with a zero byte in it, which no file has")
    try:
        encoded = os.fsencode(name)
    except UnicodeError as error:
        raise FileError(name, "a name with characters that no file name of this system has") from error
    longest = max(map(len, encoded.split(os.fsencode(os.sep))))
    if longest > LONGEST_NAME:
        raise FileError(name, f"a name of {longest} bytes, at most {LONGEST_NAME} are possible")
    return name


def _ordinary(name: str, state: os.stat_result, largest: int) -> int:
    """The size of what `state` tells of, which is an ordinary file that is not too large."""
    for is_kind, kind in _KINDS:
        if is_kind(state.st_mode):
            mend = "name a file inside it" if is_kind is stat.S_ISDIR else "copy what comes out of it to a file first"
            raise FileError(name, f"{kind}, expected a file", mend)
    if state.st_size > largest:
        raise FileError(name, _too_large(state.st_size, largest))
    return state.st_size


def _too_large(size: int, largest: int) -> str:
    return f"{size / 1e6:.6g} MB, at most {largest / 1e6:.6g} MB are read"


def _unreadable(name: str, error: OSError | ValueError) -> FileError:
    number = getattr(error, "errno", None)
    if number in (errno.ENOENT, errno.ENOTDIR):
        return FileError(name, "no such file", missing=True)
    if number == errno.ELOOP:
        return FileError(name, "symbolic links that lead to each other, so there is no file")
    if number == errno.ENAMETOOLONG:
        return FileError(name, f"a path of {len(os.fsencode(name))} bytes, which is too long")
    return FileError(name, f"it cannot be read: {getattr(error, 'strerror', None) or error}")


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
    try:
        target = Path(path_name(path))
    except FileError as error:
        raise InputError(f"cannot write {error}") from error
    if not target.parent.is_dir():
        raise InputError(f"the folder {str(target.parent)!r} does not exist; make it first")
    if target.is_dir():
        raise InputError(f"{str(target)!r} is a folder; give a file name")
    if target.exists() and not target.is_file():
        raise InputError(f"{str(target)!r} is a pipe, device or socket; give a file name")
    return target


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
