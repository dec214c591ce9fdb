"""The robots that ship with cutjoint, and those of the optional package example-robot-data, by name."""

from __future__ import annotations

import os
from functools import cache
from pathlib import Path

from cutjoint.description.files import example_robot_data
from cutjoint.errors import UnknownNameError

_ALIASES = {
    "allegro_right": "allegro_right_hand",
    "allegro_left": "allegro_left_hand",
    "anymal_c": "anymal_c_simple_description/urdf/anymal",
    "borinot": "borinot_flying_arm_2",
    "cassie": "cassie_v2",
    "hector": "quadrotor_base",
    "hextilt": "hextilt_flying_arm_5",
    "hyq": "hyq_no_sensors",
    "solo8": "solo",
    "talos": "talos_reduced",
    "ur3": "ur3_robot",
    "ur5": "ur5_robot",
    "ur10": "ur10_robot",
}
"""Names in use that are not the name of a file of example-robot-data."""


def folder() -> Path:
    """The folder `urdf` with the shipped robots: inside the installed package, or at the root of the repository."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "urdf"
    return inside if inside.is_dir() else package.parents[1] / "urdf"


def names() -> tuple[str, ...]:
    """The shipped robots, sorted."""
    return tuple(sorted(path.parent.name for path in folder().glob("*/loops.toml")))


def path(name: str) -> Path:
    """The loops.toml of a shipped robot.

    Raises:
        UnknownNameError: no robot of that name ships with cutjoint.
    """
    if name not in names():
        raise UnknownNameError("robot", name, names())
    return folder() / name / "loops.toml"


@cache
def _example_files() -> dict[str, Path]:
    share = example_robot_data()
    if share is None:
        return {}
    robots = share / "robots"
    files = sorted([*robots.rglob("*.urdf"), *robots.rglob("*.sdf")])
    found: dict[str, Path] = {}
    for file in files:
        found.setdefault(file.stem, file)
    for alias, target in _ALIASES.items():
        for file in files:
            if str(file.with_suffix("")).replace(os.sep, "/").endswith("/" + target):
                found[alias] = file
    return found


def example_names() -> tuple[str, ...]:
    """The robots of example-robot-data, sorted; empty where the package is not installed."""
    return tuple(sorted(_example_files()))


def is_example(file: Path) -> bool:
    """Whether a file is one of example-robot-data."""
    return file in _example_files().values()


def resolve(name_or_path: str | os.PathLike[str]) -> Path:
    """The file that a name or a path means: an existing path first, a shipped robot, one of example-robot-data.

    What looks like a path (it has a separator or a suffix) is returned even where nothing is there: reading it then
    says so.

    Raises:
        UnknownNameError: a name that nothing has.
    """
    name = os.fspath(name_or_path)
    if isinstance(name_or_path, Path) or os.sep in name or "/" in name or Path(name).suffix:
        return Path(name)
    if name in names():
        return path(name)
    if os.path.exists(name):
        return Path(name)
    examples = _example_files()
    if name in examples:
        return examples[name]
    hint = "`cutjoint list --examples` shows all, and the path of a robot's file or folder is taken too"
    raise UnknownNameError("robot", name, (*names(), *example_names()), hint)
