"""Arrays in a zip file, as `numpy.savez` writes them, that nobody has to trust.

What the zip's directory and each array's heading say is compared with each other and bounded before anything is
unpacked; checksums tell what was damaged.  No pickles.
"""

from __future__ import annotations

import io
import math
import struct
import zipfile
from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

T = TypeVar("T")

MOST = 100
"""Arrays in a file."""
LONGEST_HEADING = 10_000
"""Bytes of what stands before the numbers of an array."""
LONGEST_TEXT = 2**24
"""Characters."""
_SUFFIX = ".npy"
_END = struct.Struct("<4s4H2LH")
"""What closes a zip file: signature, numbers of disks, of members, size and place of the directory, of the comment."""
_LARGE = b"PK\x06\x07"
"""Stands before it in files of more than 65 535 members or 4 GiB."""


class ArchiveError(ValueError):
    """The file is damaged, or none that numpy writes."""


class _Heading(NamedTuple):
    """What stands before the numbers of an array, and where it is in the zip."""

    shape: tuple[int, ...]
    dtype: np.dtype[np.generic]
    member: zipfile.ZipInfo


class ArrayArchive:
    """The arrays in `data`, which take at most `largest` bytes unpacked.

    Raises:
        ArchiveError: it is no such file, damaged, or larger unpacked.
    """

    def __init__(self, data: bytes, largest: int) -> None:
        _check_end(data)
        self._zip = _undamaged(lambda: zipfile.ZipFile(io.BytesIO(data)))
        self._headings: dict[str, _Heading] = {}
        members = self._zip.infolist()
        if (size := sum(one.file_size for one in members)) > largest:
            raise ArchiveError(f"unpacked it has {size / 1e6:.0f} MB, at most {largest / 1e6:.0f} are read")
        for member in members:
            name = member.filename.removesuffix(_SUFFIX)
            if name == member.filename or not name:
                raise ArchiveError(f"it holds {member.filename[:60]!a}, which is no array")
            if name in self._headings:
                raise ArchiveError(f"it holds '{name}' twice")
            if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
                raise ArchiveError(f"'{name}' is packed by a method that numpy does not use")
            self._headings[name] = self._heading(name, member)

    def __enter__(self) -> ArrayArchive:
        return self

    def __exit__(self, *_: object) -> None:
        self._zip.close()

    @property
    def names(self) -> tuple[str, ...]:
        """Of the arrays."""
        return tuple(self._headings)

    def shape(self, name: str) -> tuple[int, ...]:
        """Of an array."""
        return self._headings[name].shape

    def kind(self, name: str) -> str:
        """The type of the entries of an array, such as `float64`."""
        return self._headings[name].dtype.name

    def array(self, name: str) -> npt.NDArray[np.generic]:
        """An array, unpacked.

        Raises:
            ArchiveError: it is damaged.
        """

        def unpacked() -> npt.NDArray[np.generic]:
            with self._zip.open(self._headings[name].member) as stream:
                # Whole, so that its checksum is compared.
                content = stream.read()
            return np.asarray(np.lib.format.read_array(io.BytesIO(content), allow_pickle=False))

        return _undamaged(unpacked, name)

    def number(self, name: str) -> int | str:
        """A whole number; what else is there, in words.

        Raises:
            ArchiveError: it is damaged.
        """
        if name not in self._headings:
            return "none"
        heading = self._headings[name]
        if heading.shape == () and heading.dtype.kind in "iu":
            return int(self.array(name))  # type: ignore[arg-type]
        if heading.shape == () and heading.dtype.kind == "U":
            return self.text(name)[:60]
        return f"of {heading.dtype} with shape {heading.shape}"

    def text(self, name: str) -> str:
        """A text.

        Raises:
            ValueError: there is none, or it is no text.
            ArchiveError: it is damaged.
        """
        if name not in self._headings:
            raise ValueError(f"it lacks {name}")
        heading = self._headings[name]
        if heading.shape != () or heading.dtype.kind != "U" or heading.dtype.itemsize > 4 * LONGEST_TEXT:
            raise ValueError(f"'{name}' is no text, but {heading.dtype} with shape {heading.shape}")
        return str(self.array(name))

    def _heading(self, name: str, member: zipfile.ZipInfo) -> _Heading:
        def read() -> _Heading:
            with self._zip.open(member) as stream:
                start = io.BytesIO(stream.read(LONGEST_HEADING))
            version = np.lib.format.read_magic(start)
            headings = {
                (1, 0): np.lib.format.read_array_header_1_0,
                (2, 0): np.lib.format.read_array_header_2_0,
            }
            if version not in headings:
                raise ArchiveError(f"'{name}' is an array of version {version}")
            shape, _, dtype = headings[version](start, max_header_size=LONGEST_HEADING)
            if dtype.hasobject:
                raise ArchiveError(f"'{name}' holds Python objects, which are not read")
            size = start.tell() + math.prod(shape) * dtype.itemsize
            if min(shape, default=0) < 0 or size != member.file_size:
                raise ArchiveError(f"'{name}' should have {size} bytes, and has {member.file_size}")
            return _Heading(shape, dtype, member)

        return _undamaged(read, name)


def _check_end(data: bytes) -> None:
    """That the zip's directory is a small one, before it is read: it could have millions of entries.

    Raises:
        ArchiveError: it is not, or this is no zip file.
    """
    tail = data[-_END.size :]
    if len(tail) < _END.size or tail[:4] != b"PK\x05\x06":
        raise ArchiveError("it is cut short, or no zip file" if data[:2] == b"PK" else "it is no zip file")
    _, disk, first, here, every, size, place, comment = _END.unpack(tail)
    large = data[-_END.size - 20 :][:4] == _LARGE
    if large or disk or first or comment or here != every or every > MOST or place + size + _END.size != len(data):
        raise ArchiveError(f"its directory is damaged, or of more than {MOST} arrays")


def _undamaged(read: Callable[[], T], name: str = "") -> T:
    """What `read` gives.

    Raises:
        ArchiveError: it raised: zlib, zipfile, struct and numpy have an error each for whatever is damaged.
    """
    try:
        return read()
    except ArchiveError:
        raise
    except Exception as error:
        words = " ".join(str(error).split())[:160]
        raise ArchiveError(f"{name and f'{name}: '}{words or type(error).__name__}") from error
