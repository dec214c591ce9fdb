"""The file formats that describe a robot: a folder each, and a row each in the table `FORMATS`.

A new format is a folder with `read(path, findings) -> RobotDescription | None`, where it can be written a function that
gives the texts of its files, and a row.  A dialect stands before what it extends; otherwise the order does not matter.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from itertools import islice
from pathlib import Path

from cutjoint.description.formats.common.extras import Reading, RobotFindings
from cutjoint.description.formats.common.unsaid import MESHES
from cutjoint.description.formats.common.unsaid import left_out as undrawn
from cutjoint.description.formats.common.unsaid import unsaid as beyond
from cutjoint.description.model import RobotDescription
from cutjoint.errors import DescriptionError, FileError, UnknownNameError, shown
from cutjoint.files import is_file, read_file, write_files
from cutjoint.findings import LARGEST_FILE, MOST_NAMES, Findings, listing
from cutjoint.reprs import line

__all__ = ["FORMATS", "WRITERS", "Format", "Reading", "format_of", "left_out", "read", "unsaid", "write"]

Texts = Callable[[RobotDescription, Path], Mapping[Path, bytes]]
"""(description, path to write) -> the content of every file, the first being the one to read again."""


@dataclass(frozen=True)
class Format:
    """A file format or a dialect of one.

    Attributes:
        name: for messages.
        suffixes: of its files; the first is that of a file that is written.
        marks: texts, one of which its files contain.
        read: its reader, which notes everything that is wrong; None where nothing useful was left.
        write: its writer, None where there is none.
        key: what `cutjoint export --to` calls it.
        folder: whether what is written is a folder.
        says: what of `common.unsaid.WORDS` other programs find in what is written, of joints and links, and whether
            inertias are left as they are; None for all.
        draws: suffixes of the mesh files that it may name; None for all.
    """

    name: str
    suffixes: tuple[str, ...]
    marks: tuple[bytes, ...]
    read: Callable[[Path, Findings], RobotDescription | None]
    write: Texts | None = None
    key: str = ""
    folder: bool = False
    says: tuple[str, ...] | None = None
    draws: tuple[str, ...] | None = None

    __repr__ = line("name", "suffixes")

    def place(self, name: str) -> Path:
        """Where a robot called `name` is written unless one says where."""
        return Path(name if self.folder else name + self.suffixes[0])


def _reader(module: str) -> Callable[[Path, Findings], RobotDescription | None]:
    """`read` of a module of this package, imported only when a file of its format is met: most never are."""

    def read(path: Path, findings: Findings) -> RobotDescription | None:
        found: RobotDescription | None = import_module(f"{__name__}.{module}").read(path, findings)
        return found

    return read


def _writer(module: str) -> Texts:
    """`files` of a module of this package, imported only when a file of its format is written."""

    def files(description: RobotDescription, path: Path) -> Mapping[Path, bytes]:
        texts: Mapping[Path, bytes] = import_module(f"{__name__}.{module}").files(description, path)
        return texts

    return files


PLAIN = Format("URDF", (".urdf", ".xml", ".xacro"), (b"<robot",), _reader("urdf.reader"))
FORMATS: tuple[Format, ...] = (
    Format("loops.toml", (".toml",), (b"schema",), _reader("loops_toml"), _writer("loops_toml"), "loops", True),
    Format("Gepetto robot.yaml", (".yaml", ".yml"), (b"closed_loop", b"name_mot"), _reader("gepetto")),
    Format(
        "URDF+",
        (".urdf", ".xml", ".xacro"),
        (b"<loop ", b"<coupling", b"<predecessor", b"independent="),
        _reader("urdf.reader"),
    ),
    Format(
        "URDF with <constraint>",
        (".urdf", ".xml", ".xacro"),
        (b"<constraint", b"<cutjoint"),
        _reader("urdf.reader"),
        _writer("urdf.writer"),
        "urdf",
        says=("damping", "friction", "friction_speed", "inertias"),
    ),
    Format(
        "MJCF",
        (".xml", ".mjcf"),
        (b"<mujoco",),
        _reader("mjcf.reader"),
        _writer("mjcf.writer"),
        "mjcf",
        says=("damping", "friction", "springs", "rotors", "gravity compensation"),
        draws=MESHES,
    ),
    Format("USD", (".usda", ".usd", ".usdc", ".usdz"), (b"#usda", b"PXR-USDC", b"PK\x03\x04"), _reader("usd.reader")),
    Format("SDF", (".sdf", ".world", ".xml"), (b"<sdf",), _reader("sdf.reader")),
    PLAIN,
)
"""The first whose suffix and mark both fit is taken; where no mark fits, URDF if the suffix may be one."""

WRITERS: Mapping[str, Format] = {one.key: one for one in FORMATS if one.write is not None}
"""What can be written, by the name that `write` and `cutjoint export --to` know."""


def read(path: Path) -> Reading:
    """Read a robot out of a file, or out of a folder: its loops.toml or robot.yaml, or the only robot in it."""
    findings, description = RobotFindings(shown(str(path))), None
    file = _of_folder(path, findings) if os.path.isdir(path) else path
    if file is not None:
        findings.file = shown(str(file))
        try:
            description = format_of(file).read(file, findings)
        except DescriptionError as error:  # very many errors
            findings.problems[:] = dict.fromkeys((*findings.problems, *error.problems))
        except RecursionError:
            findings.error("parts that lead on to each other without end", "some hundred levels at most")
    return Reading(description, tuple(findings.problems), findings.closing)


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
    texts = WRITERS[to].write if to in WRITERS else None
    if texts is None:
        raise UnknownNameError("format", to, tuple(WRITERS))
    contents = texts(description, Path(path))
    for file in contents:
        file.parent.mkdir(parents=True, exist_ok=True)
    return write_files(contents)


def unsaid(description: RobotDescription, to: str) -> tuple[str, ...]:
    """What joints and cuts do by themselves that programs other than cutjoint will not find in a file of a format.

    Raises:
        UnknownNameError: there is no such format.
    """
    if to not in WRITERS:
        raise UnknownNameError("format", to, tuple(WRITERS))
    says = WRITERS[to].says
    return () if says is None else beyond(description, says)


def left_out(description: RobotDescription, to: str) -> tuple[str, ...]:
    """The shapes that a file of a format leaves out, since its programs cannot draw them.

    Raises:
        UnknownNameError: there is no such format.
    """
    if to not in WRITERS:
        raise UnknownNameError("format", to, tuple(WRITERS))
    draws = WRITERS[to].draws
    return () if draws is None else undrawn(description, draws)


def format_of(path: Path) -> Format:
    """The format of a file by suffix and content.  A file that cannot be read counts by its suffix alone."""
    try:
        head = read_file(path, LARGEST_FILE)
    except FileError:
        head = b""
    suffix = path.suffix.lower()
    fitting = [one for one in FORMATS if suffix in one.suffixes] or list(FORMATS)
    plain_first = [one for one in fitting if one is PLAIN]
    return [*_marked(head, fitting), *plain_first, *fitting][0]


def _marked(head: bytes, fitting: Sequence[Format]) -> list[Format]:
    return [one for one in fitting if any(mark in head for mark in one.marks)]


NAMED = ("loops.toml", "robot.yaml")
"""What stands for a folder, whatever else is in it."""


def _of_folder(folder: Path, findings: Findings) -> Path | None:
    """The file that a folder means, or None after noting why there is none."""
    try:
        files = sorted(one for one in islice(folder.iterdir(), MOST_NAMES) if is_file(one))
    except OSError as error:
        findings.error(f"the directory cannot be read: {error}", "a readable directory")
        return None
    for name in NAMED:
        if is_file(folder / name):
            return folder / name
    robots = [one for one in files if _describes(one)]
    if len(robots) == 1:
        return robots[0]
    found = f"a directory with {len(robots)} robots" if robots else "a directory without a robot"
    mend = f"name one of its files: {listing(one.name for one in robots)}" if robots else ""
    findings.error(found, f"one with {' or '.join(NAMED)}, or with one file that describes a robot", mend)
    return None


def _describes(file: Path) -> bool:
    """Whether suffix and content are those of a format."""
    fitting = [one for one in FORMATS if file.suffix.lower() in one.suffixes]
    if not fitting:
        return False
    try:
        return bool(_marked(read_file(file, LARGEST_FILE), fitting))
    except FileError:
        return False
