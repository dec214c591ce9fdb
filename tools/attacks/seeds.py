"""The sound files that are spoiled: a sample of every format with everything in it, and robots that are written."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from cutjoint.description import load_description
from cutjoint.description.formats import WRITERS, write

ROBOTS = ("fourbar", "cpm", "stewart", "fivebar")
SAMPLES = Path(__file__).resolve().parents[2] / "tests" / "description" / "samples"
NEEDS = {".usda": "pxr", ".xml": "mujoco", ".xacro": "xacro"}
"""The package without which a format is not read."""
FIRST = ("loops.toml", "robot.yaml")
"""What is loaded of a sample that is a folder."""


@cache
def samples() -> Mapping[str, Mapping[str, str]]:
    """Name of a sample that can be read here -> its files, the one to load first."""
    found = {}
    for one in sorted(SAMPLES.iterdir()):
        if one.suffix in NEEDS and find_spec(NEEDS[one.suffix]) is None:
            continue
        files = sorted(one.iterdir(), key=lambda file: (file.name not in FIRST, file.name)) if one.is_dir() else [one]
        found[one.name] = {file.name: file.read_text(encoding="utf-8") for file in files}
    return found


@cache
def seeds() -> Mapping[str, Mapping[str, str]]:
    """The samples, and `ROBOT as FORMAT`."""
    return {**{f"{robot} as {form}": written(robot, form) for robot in ROBOTS for form in WRITERS}, **samples()}


@cache
def written(robot: str, form: str) -> Mapping[str, str]:
    """The files of a robot in a format."""
    with TemporaryDirectory() as folder:
        kind = WRITERS[form]
        path = Path(folder) if kind.folder else Path(folder) / kind.place(robot).name
        files = write(load_description(robot), path, form)
        return {one.name: one.read_text(encoding="utf-8") for one in files}


def laid(files: Mapping[str, str], folder: Path) -> Path:
    """Write files into a folder; the path of the one to load."""
    folder.mkdir(exist_ok=True)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8", errors="replace")
    return folder / next(iter(files))
