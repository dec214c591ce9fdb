"""Files are read only where they are files, and written whole or not at all.

Whatever path somebody gives, or a file names, goes through `read_file`: pipes, devices, sockets and folders are refused
before a byte is read, and no more is read than the kind of file can need.
"""

from __future__ import annotations

import errno
import os
import shutil
import stat
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from cutjoint import interrupts
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


class Draft:
    """A file that is being written: without a name where the system has such files (Linux), so that nothing of it
    stays if the program is killed; else a neighbour of what it will be.  A context: what has got no name is gone.

    Args:
        target: what it will be called.
        private: only the owner can read it.

    Attributes:
        path: under which it can be written and read meanwhile.

    Raises:
        OSError: there is no such folder, it cannot be written, or a pipe, device or socket has that name, whose place
            no file may take.
    """

    def __init__(self, target: Path, *, private: bool = False) -> None:
        if target.exists() and not (target.is_file() or target.is_dir()):
            raise OSError(errno.EEXIST, "a pipe, device or socket is there; give a file name")
        self._target = target
        self._name: str | None = None
        folder = target.parent
        try:
            self.handle = os.open(folder, os.O_TMPFILE | os.O_RDWR, 0o600)
            self.path = f"/proc/self/fd/{self.handle}"
            if not os.path.exists(self.path):
                os.close(self.handle)
                raise OSError("there is no /proc")
        except (AttributeError, OSError):
            self.handle, self.path = tempfile.mkstemp(prefix=f".{_short(target.name)}.", dir=folder)
            self._name = self.path
        if not private:
            os.chmod(self.path, 0o666 & ~_umask())

    def write(self, content: bytes) -> None:
        """Append `content`."""
        with os.fdopen(os.dup(self.handle), "wb") as file:
            file.write(content)

    def finish(self, *, lasting: bool = True) -> None:
        """All is written; it has a name of its own from now on, and where it is `lasting` it is on the disk."""
        if lasting:
            os.fsync(self.handle)
        if self._name is None:
            name = str(self._target.parent / f".{_short(self._target.name)}.{os.urandom(6).hex()}")
            try:
                # a folder that is not needed, the path being absolute: without one Python links the link in /proc
                os.link(self.path, name, src_dir_fd=self.handle, follow_symlinks=True)
            except OSError:  # a file system that gives no names later
                shutil.copy(self.path, name)
            self._name = name

    def take_place(self, target: Path | None = None) -> None:
        """Take the name that it was made for, or another one in its folder."""
        self.finish(lasting=False)
        assert self._name is not None
        os.replace(self._name, self._target if target is None else target)
        self._name = None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self.handle)
        if self._name is not None:
            Path(self._name).unlink(missing_ok=True)


def write_files(contents: Mapping[Path, bytes], *, private: bool = False) -> tuple[Path, ...]:
    """Write each content to its path; the old files stay until all new ones are there.  Returns the paths.

    `private` makes files that only their owner can read and that need not outlive a power cut, as in a cache.  An
    interrupt of the command line waits until all is written.

    Raises:
        OSError: a folder does not exist, or a file cannot be written.
    """
    with interrupts.held(), ExitStack() as stack:
        drafts = []
        for path, content in contents.items():
            drafts.append(stack.enter_context(Draft(path, private=private)))
            drafts[-1].write(content)
            drafts[-1].finish(lasting=not private)
        for draft in drafts:
            draft.take_place()
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


def _short(name: str) -> str:
    """The beginning of a name, so that more can be put behind it: a name has at most 255 bytes."""
    return os.fsdecode(os.fsencode(name)[:200])


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
