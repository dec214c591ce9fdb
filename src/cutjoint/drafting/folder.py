"""A new robot as a folder: its files drafted, tried in full, and written all of them or none."""

from __future__ import annotations

import math
import os
import re
import shutil
import tempfile
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cutjoint import interrupts
from cutjoint.description import catalogue
from cutjoint.drafting.readme import readme_text
from cutjoint.drafting.templates import DEFAULT, TEMPLATES, Template
from cutjoint.drafting.text import loops_text, urdf_text
from cutjoint.errors import InputError, UnknownNameError, shown
from cutjoint.files import path_name, write_files
from cutjoint.reprs import line

if TYPE_CHECKING:
    from cutjoint.chain.mobility_report import MobilityReport
    from cutjoint.description import RobotDescription

SMALLEST, LARGEST = 1e-3, 100.0
"""Lengths that a robot of a template may have [m]."""
ALUMINIUM = 2700.0
"""kg/m3, the density of the solids where none is given."""
LIGHTEST, HEAVIEST = 1.0, 25000.0
"""Densities that solids may have [kg/m3]."""
_DEVICE = re.compile(r"con|prn|aux|nul|com[0-9]|lpt[0-9]", re.IGNORECASE)
"""What no folder of Windows can be called."""
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,62}")


@dataclass(frozen=True)
class NewRobot:
    """A robot that is not written yet, but has been closed and checked.

    Attributes:
        name: of the robot.
        template: what it is made from.
        title: what it is.
        sizes: all lengths of the template [m].
        density: of its solids [kg/m3].
        files: name in the folder -> text.
        report: its mobility at home.
        told: what is odd about it, a sentence each; empty as a rule.
    """

    name: str
    template: str
    title: str
    sizes: Mapping[str, float]
    density: float
    files: Mapping[str, str]
    report: MobilityReport
    told: tuple[str, ...]

    __repr__ = line("name", "template", "sizes", "density", sizes="m", density="kg/m3")


def draft(
    name: str, template: str = DEFAULT, sizes: Mapping[str, float] | None = None, density: float = ALUMINIUM
) -> NewRobot:
    """A robot of a template, drawn, closed and checked; nothing is written.

    Args:
        name: letters, digits, `_` and `-`, a letter first; not that of a robot that ships with cutjoint.
        template: a row of `TEMPLATES`.
        sizes: lengths [m] by name, some of those that the template asks for; the others as the template has them.
        density: of the solids that its links are made of [kg/m3].

    Raises:
        InputError: the name cannot be used, a length or the density is not possible, or the loops cannot close.
        UnknownNameError: no such template, or the template has no such size.
    """
    check_name(name)
    if template not in TEMPLATES:
        raise UnknownNameError("template", template, tuple(TEMPLATES))
    row = TEMPLATES[template]
    lengths = _lengths(template, row, sizes or {})
    _check_range("the density", density, LIGHTEST, HEAVIEST, "kg/m3")
    sketch = row.sketch(lengths)
    files = {
        "loops.toml": loops_text(name, sketch),
        "robot.urdf": urdf_text(name, sketch, density),
        "README.md": readme_text(name, template, row, sketch, lengths, density),
    }
    report, told = _tried(template, files, sketch.mobility)
    return NewRobot(name, template, sketch.title, lengths, density, files, report, told)


def check_name(name: str) -> None:
    """Refuse what cannot be the name of a robot and of its folder.

    Raises:
        InputError: it cannot, with why.
    """
    if not _NAME.fullmatch(name):
        raise InputError(
            f"'{shown(name)}' cannot be the name of a robot: expected letters, digits, _ and -, a letter first, at "
            "most 63 of them (another place for the folder: -o FOLDER)"
        )
    if _DEVICE.fullmatch(name):
        raise InputError(f"'{name}' cannot be the name of a robot: Windows has a device of that name; choose another")
    if name in catalogue.names():
        raise InputError(
            f"'{name}' is a robot that ships with cutjoint, and commands would take that one; choose another name, "
            f"such as my_{name}"
        )


def write_draft(made: NewRobot, folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    """Write a drafted robot into a folder that is new or empty; all files or none.  Returns their paths.

    Raises:
        InputError: something is there already, or it cannot be written.
    """
    return _write({name: text.encode() for name, text in made.files.items()}, folder)


def write_description(robot: RobotDescription, folder: str | os.PathLike[str], head: str = "") -> tuple[Path, ...]:
    """Write a robot as loops.toml and robot.urdf into a folder that is new or empty; both or none.

    `head` is what the loops.toml begins with: lines of comments.

    Raises:
        InputError: something is there already, or it cannot be written.
    """
    from cutjoint.description.formats.loops_toml import files

    target = Path(path_name(folder))
    contents = {file.name: content for file, content in files(robot, target / "loops.toml").items()}
    return _write(contents | {"loops.toml": head.encode() + contents["loops.toml"]}, target)


def _write(contents: Mapping[str, bytes], folder: str | os.PathLike[str]) -> tuple[Path, ...]:
    target = Path(path_name(folder))
    if target.exists() or target.is_symlink():
        if not target.is_dir():
            raise InputError(f"{shown(str(target))} is there already, and is no folder; choose another name or -o")
        if any(target.iterdir()):
            raise InputError(f"{shown(str(target))} is there already and not empty; choose another name or -o")
    try:
        with interrupts.held():
            target.parent.mkdir(parents=True, exist_ok=True)
            _place(contents, target)
    except OSError as error:
        raise InputError(f"cannot write {shown(str(target))}: {error.strerror or error}") from error
    return tuple(target / one for one in contents)


def _place(contents: Mapping[str, bytes], target: Path) -> None:
    """Write the files into a neighbour of the folder, which then takes its place."""
    beside = Path(tempfile.mkdtemp(prefix=".new-", dir=target.absolute().parent))
    try:
        write_files({beside / name: content for name, content in contents.items()})
        umask = os.umask(0)
        os.umask(umask)
        beside.chmod(0o777 & ~umask)
        with suppress(FileNotFoundError):
            target.rmdir()  # it is empty, or this fails
        beside.rename(target)
    except BaseException:
        shutil.rmtree(beside, ignore_errors=True)
        raise


def _lengths(template: str, row: Template, given: Mapping[str, float]) -> dict[str, float]:
    unknown = next((one for one in given if one not in row.sizes), None)
    if unknown is not None:
        if not row.sizes:
            raise InputError(f"template {template} has no sizes, found {unknown}; change its files by hand")
        raise UnknownNameError(f"size of template {template}", unknown, tuple(row.sizes))
    lengths = {name: float(given.get(name, size.default)) for name, size in row.sizes.items()}
    for name, value in lengths.items():
        _check_range(name, value, SMALLEST, LARGEST, "m")
    return lengths


def _check_range(name: str, value: float, least: float, most: float, unit: str) -> None:
    if not (math.isfinite(value) and least <= value <= most):
        raise InputError(f"{name} must be from {least:g} to {most:g} {unit}, found {value:g}")


def _tried(template: str, files: Mapping[str, str], mobility: int) -> tuple[MobilityReport, tuple[str, ...]]:
    """The mobility of what the files describe, and warnings about it.

    Raises:
        InputError: it does not load, does not close, or does not move as it should.
    """
    from cutjoint.chain.findings import NEAR_SINGULAR, kinematic_problems
    from cutjoint.description import read_checked

    with tempfile.TemporaryDirectory() as folder:
        try:
            write_files({Path(folder, name): text.encode() for name, text in files.items()}, private=True)
        except OSError as error:
            raise InputError(f"cannot try the robot in {folder}: {error.strerror or error}") from error
        reading = read_checked(Path(folder))
        problems, chain = list(reading.problems), None
        if reading.description is not None:
            found, chain = kinematic_problems(reading.description)
            problems += found
    wrong = [one.found for one in problems if one.severity == "error"]
    if wrong or chain is None:
        raise InputError(f"template {template} with these sizes: {'; '.join(wrong)}; take other sizes")
    report = chain.mobility()
    if report.mobility != mobility:
        raise InputError(
            f"template {template} with these sizes can move in {report.mobility} ways rather than {mobility}: its home "
            "is singular; take other sizes"
        )
    if not report.determined:
        raise InputError(
            f"template {template} with these sizes is singular at home: with its motors locked it would still move; "
            "take sizes that differ less from each other"
        )
    told = [one.found for one in problems]
    if report.type1 < NEAR_SINGULAR:
        told.append(f"home is near a type-1 singularity: distance {report.type1:.2g}, 0 is singular")
    return report, tuple(told)
