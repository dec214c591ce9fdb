"""The native format, loops.toml beside a URDF (schema 1): cuts, actuators, tool, homes, variants; read and written.

All keys are described in docs/description.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cutjoint.description.formats.common.exact import serialised
from cutjoint.description.formats.common.extras import described
from cutjoint.description.formats.common.toml.keys import take_extras
from cutjoint.description.formats.common.toml.text import toml_text
from cutjoint.description.formats.urdf import plain
from cutjoint.description.formats.urdf.writer import couplings_without_mimic, foreign_joints, robot_element
from cutjoint.description.model import RobotDescription
from cutjoint.findings import Findings
from cutjoint.toml.reading import read_toml

SCHEMA = 1


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A loops.toml and the URDF that it names."""
    top = read_toml(path, findings, "loops.toml")
    if top is None:
        return None
    schema = top.take("schema", required=True, expected=f"schema = {SCHEMA}")
    if schema is not None and (schema != SCHEMA or isinstance(schema, bool)):
        top.wrong("schema", schema, f"schema = {SCHEMA}, the one that this version reads")
    name = top.string("urdf", required=True)
    tree = plain.read_tree_of(path.parent / name, findings) if name else None
    extras = take_extras(top, actuators_required=True)
    top.finish()
    if tree is None:
        return None
    return described(tree, extras.cuts, extras, path, findings)


def files(robot: RobotDescription, path: Path) -> Mapping[Path, bytes]:
    """loops.toml and the URDF of its tree; `path` is the folder, or the .toml file."""
    loops = path if path.suffix == ".toml" else path / "loops.toml"
    tree = loops.with_name("robot.urdf")
    element = serialised(robot_element(robot, tree))
    keys = toml_text(
        robot,
        urdf=tree.name,
        cuts=robot.cuts,
        couplings=couplings_without_mimic(robot),
        joints=foreign_joints(robot),
        links=robot.links,
    )
    return {loops: keys.encode("utf-8"), tree: element}
