"""The file formats that describe a robot: one module each, chosen by the name and the content of the file.

A new format is a module with `read(path) -> Reading` and a row in `FORMATS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cutjoint.description.files import LARGEST_FILE
from cutjoint.description.findings import Findings
from cutjoint.description.formats import gepetto, loops_toml, mjcf, sdf, urdf, urdf_constraint, urdf_plus
from cutjoint.description.formats.reading import Reading

__all__ = ["FORMATS", "Format", "Reading", "format_of", "read"]


@dataclass(frozen=True)
class Format:
    """A dialect: its name for messages, the suffixes of its files, text its files contain, and its reader."""

    name: str
    suffixes: tuple[str, ...]
    marks: tuple[bytes, ...]
    read: Callable[[Path], Reading]


FORMATS: tuple[Format, ...] = (
    Format("loops.toml", (".toml",), (b"schema",), loops_toml.read),
    Format("Gepetto robot.yaml", (".yaml", ".yml"), (b"closed_loop", b"name_mot"), gepetto.read),
    Format("URDF+", (".urdf", ".xml"), (b"<loop", b"<coupling", b"<predecessor", b"independent="), urdf_plus.read),
    Format("URDF with <constraint>", (".urdf", ".xml"), (b"<constraint", b"<cutjoint"), urdf_constraint.read),
    Format("MJCF", (".xml", ".mjcf"), (b"<mujoco",), mjcf.read),
    Format("SDF", (".sdf", ".world", ".xml"), (b"<sdf",), sdf.read),
    Format("URDF", (".urdf", ".xml"), (b"<robot",), urdf.read),
)
"""The first whose suffix and mark both fit is taken, then the last whose suffix fits."""


def read(path: Path) -> Reading:
    """Read a robot out of a file, or out of a folder that holds a loops.toml."""
    if path.is_dir() and (path / "loops.toml").is_file():
        path = path / "loops.toml"
    if path.is_dir():
        findings = Findings(str(path))
        findings.error("a directory without loops.toml", "a folder with a loops.toml, or a file", _inside(path))
        return Reading(None, tuple(findings.problems))
    return format_of(path).read(path)


def format_of(path: Path) -> Format:
    """The format of a file by suffix and content.  A file that cannot be read counts by its suffix alone."""
    try:
        with path.open("rb") as file:
            head = file.read(LARGEST_FILE)
    except (OSError, ValueError):
        head = b""
    suffix = path.suffix.lower()
    fitting = [one for one in FORMATS if suffix in one.suffixes]
    for one in fitting or FORMATS:
        if any(mark in head for mark in one.marks):
            return one
    return fitting[-1] if fitting else FORMATS[-1]


def _inside(path: Path) -> str:
    found = sorted(one.name for one in path.iterdir() if one.suffix.lower() in {".urdf", ".xml", ".sdf", ".yaml"})
    return f"name one of its files: {', '.join(found[:5])}" if found else ""
