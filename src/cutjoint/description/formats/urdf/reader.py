"""A URDF in any of its dialects, alone: told apart element by element, so that they may stand beside each other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from cutjoint.description.formats.common.extras import Extras, described
from cutjoint.description.formats.urdf.constraint import read_constraints
from cutjoint.description.formats.urdf.plain import LOOP_TAGS, read_robot, read_tree
from cutjoint.description.formats.urdf.plus import read_plus
from cutjoint.description.model import RobotDescription
from cutjoint.findings import Findings


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A URDF.  Without loops every free joint with one coordinate is an actuator; with URDF+ the independent ones are,
    with other loops those that a `<transmission>` drives; a `<cutjoint>` element may name them."""
    root = read_robot(path, findings)
    if root is None:
        return None
    tree = read_tree(root, path, findings, LOOP_TAGS)
    independent = read_plus(root, tree, findings)
    extras = read_constraints(root, tree, findings)
    if independent is not None:
        extras = extras or Extras()
        extras = extras if extras.actuators is not None else replace(extras, actuators=independent)
    return described(tree, extras.cuts if extras else (), extras, path, findings)
