"""Files are written whole or not at all: to a neighbour first, which then takes the asked name."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Self

from cutjoint import interrupts
from cutjoint.errors import InputError


class Draft:
    """A file that is being written: without a name where the system has such files (Linux), so that nothing of it
    stays if the program is killed; else a neighbour of what it will be.  A context: what has got no name is gone.

    Args:
        target: what it will be called.
        private: only the owner can read it.

    Attributes:
        path: under which it can be written and read meanwhile.

    Raises:
        OSError: there is no such folder, or it cannot be written.
    """

    def __init__(self, target: Path, *, private: bool = False) -> None:
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
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"the folder {str(target.parent)!r} does not exist; make it first")
    if target.is_dir():
        raise InputError(f"{str(target)!r} is a folder; give a file name")
    return target


def _short(name: str) -> str:
    """The beginning of a name, so that more can be put behind it: a name has at most 255 bytes."""
    return os.fsdecode(os.fsencode(name)[:200])


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
