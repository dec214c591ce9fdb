"""A description as loops.toml with robot.urdf beside it."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cutjoint.description.formats.common.exact import serialised
from cutjoint.description.formats.common.toml.text import toml_text
from cutjoint.description.formats.urdf.writer import couplings_without_mimic, foreign_joints, robot_element
from cutjoint.description.model import RobotDescription


def native_files(robot: RobotDescription, path: Path) -> Mapping[Path, bytes]:
    """loops.toml and the URDF of its tree; `path` is the folder, or the .toml file."""
    loops = path if path.suffix == ".toml" else path / "loops.toml"
    tree = loops.with_name("robot.urdf")
    keys = toml_text(
        robot,
        urdf=tree.name,
        cuts=robot.cuts,
        couplings=couplings_without_mimic(robot),
        joints=foreign_joints(robot),
    )
    return {loops: keys.encode("utf-8"), tree: serialised(robot_element(robot, tree))}
