"""Gepetto's robot.yaml beside a URDF, as in example-parallel-robots (https://github.com/Gepetto/example-parallel-robots).

`closed_loop` lists pairs of frames (names of links, or of joints, which mean the frame that the joint moves); `type`
gives 3d (spherical) or 6d (fixed) for each, 6d where it is missing; `name_mot` the actuated joints; `joint_name` and
`joint_type` joints of the URDF that another joint replaces: SPHERICAL, FIXED or UJOINT_XY, a universal joint about two
axes of the joint's frame.  Of YAML only names, texts and nested lists are read, with line numbers: nothing is
constructed (no tags, no objects), and anchors and aliases are refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import permutations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.common.physics import with_rest
from cutjoint.description.formats.urdf import plain
from cutjoint.description.model import CutJoint, CutType, Frame, Joint, JointType, Limits, Place, RobotDescription
from cutjoint.extras import how_to_get
from cutjoint.files import is_file
from cutjoint.findings import Findings, clip, listing, nearest, read_text_file

if TYPE_CHECKING:
    import yaml


DEEPEST = 20
MOST_VALUES = 10_000
KEYS = ("closed_loop", "type", "name_mot", "joint_name", "joint_type")
CUTS = {"3d": CutType.SPHERICAL, "6d": CutType.FIXED}
_AXES = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}
JOINTS = {"SPHERICAL": JointType.SPHERICAL, "FIXED": JointType.FIXED} | {
    f"UJOINT_{a}{b}": JointType.UNIVERSAL for a, b in permutations("XYZ", 2)
}


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """A robot.yaml and the URDF beside it (of the same stem, or the only one there)."""
    keys = read_yaml(path, findings)
    tree = None if keys is None else _tree(path, findings)
    if keys is None or tree is None:
        return None
    for key, entry in keys.items():
        if key not in KEYS:
            findings.unknown(f"unknown key '{key}'", key, KEYS, entry.line)
    _replace_joints(tree, keys, findings)
    motors = _strings(keys, "name_mot", findings)
    if "name_mot" not in keys:
        findings.error("no key 'name_mot'", "the actuated joints", "add name_mot: [...]")
    return RobotDescription(
        name=tree.name,
        links=tuple(tree.links),
        joints=tuple(with_rest(joint, (), findings) for joint in tree.joints),
        cuts=tree.closed_by(_cuts(tree, keys, findings), findings),
        couplings=tuple(tree.couplings),
        actuators=tuple(entry.text for entry in motors),
        path=path,
        places={"actuators": Place(str(path), keys["name_mot"].line)} if "name_mot" in keys else {},
    )


def _tree(path: Path, findings: Findings) -> OpenTree | None:
    beside = path.with_suffix(".urdf")
    if not is_file(beside):
        others = sorted(path.parent.glob("*.urdf"))
        if len(others) != 1:
            found = f"{len(others)} URDF files beside robot.yaml, none called {beside.name}"
            findings.error(found, "one URDF", f"rename it to {beside.name}")
            return None
        beside = others[0]
    return plain.read_tree_of(beside, findings)


def _strings(keys: Mapping[str, YamlItem], key: str, findings: Findings) -> tuple[YamlItem, ...]:
    entry = keys.get(key)
    if entry is None:
        return ()
    if entry.items is None or any(item.items is not None for item in entry.items):
        findings.error(f"{key} is not a list of names", f"{key}: [a, b]", "", entry.line)
        return ()
    return entry.items


def _cuts(tree: OpenTree, keys: Mapping[str, YamlItem], findings: Findings) -> tuple[CutJoint, ...]:
    loops = keys.get("closed_loop")
    pairs = () if loops is None or loops.items is None else loops.items
    if loops is not None and loops.items is None:
        findings.error("closed_loop is not a list of pairs", "closed_loop: [[a, b], [c, d]]", "", loops.line)
    types = _strings(keys, "type", findings)
    if types and len(types) != len(pairs):
        found = f"{len(types)} types for {len(pairs)} closed loops"
        findings.error(found, "a type for each loop, or no key 'type' (then 6d)", "", keys["type"].line)
    cuts = []
    for number, pair in enumerate(pairs):
        kind = types[number] if number < len(types) else None
        if kind is not None and kind.text.lower() not in CUTS:
            found = f"type '{kind.text}' of closed loop {number + 1}"
            findings.error(found, "3d (spherical) or 6d (fixed)", nearest(kind.text, CUTS), kind.line)
            continue
        if pair.items is None or len(pair.items) != 2 or any(item.items is not None for item in pair.items):
            findings.error(f"closed loop {number + 1} is not a pair of names", "[frame_a, frame_b]", "", pair.line)
            continue
        a, b = (item.text for item in pair.items)
        cut_type = CutType.FIXED if kind is None else CUTS[kind.text.lower()]
        place = Place(findings.file, pair.line)
        cuts.append(CutJoint(f"{a}_{b}", cut_type, _frame(a, tree), _frame(b, tree), place))
    return tuple(cuts)


def _frame(name: str, tree: OpenTree) -> Frame:
    """The frame of a link, or of the link that the joint of that name moves."""
    moved = {joint.name: joint.child for joint in tree.joints}
    links = {link.name for link in tree.links}
    return Frame(name if name in links else moved.get(name, name))


def _replace_joints(tree: OpenTree, keys: Mapping[str, YamlItem], findings: Findings) -> None:
    names, types = _strings(keys, "joint_name", findings), _strings(keys, "joint_type", findings)
    if len(names) != len(types):
        line = keys["joint_name" if "joint_name" in keys else "joint_type"].line
        findings.error(f"{len(names)} names in joint_name for {len(types)} in joint_type", "as many", "", line)
    known = {joint.name: index for index, joint in enumerate(tree.joints)}
    for name, kind in zip(names, types, strict=False):
        if name.text not in known:
            expected = f"a joint of the URDF ({listing(known, 6)})"
            findings.error(f"unknown joint '{name.text}' in joint_name", expected, nearest(name.text, known), name.line)
        elif kind.text not in JOINTS:
            findings.unknown(f"type '{kind.text}' of joint '{name.text}'", kind.text, JOINTS, kind.line)
        else:
            index = known[name.text]
            tree.joints[index] = _other_type(tree.joints[index], kind.text)


def _other_type(joint: Joint, kind: str) -> Joint:
    """The same joint with another type; limits of one axis mean nothing there."""
    changed = replace(joint, type=JOINTS[kind], limits=Limits())
    if changed.type.axes < 2:
        return changed
    axis, axis2 = (np.array(_AXES[letter]) for letter in kind[-2:])
    return replace(changed, axis=axis, axis2=axis2)


@dataclass(frozen=True)
class YamlItem:
    """A text, or a list (then `items` is not None)."""

    text: str
    line: int
    items: tuple[YamlItem, ...] | None = None


def read_yaml(path: Path, findings: Findings) -> dict[str, YamlItem] | None:
    """The top-level mapping of a YAML file, or None after noting why not."""
    data = read_text_file(path, findings, "YAML")
    if data is None:
        return None
    try:
        import yaml
    except ImportError:
        findings.error("PyYAML is not installed", "PyYAML, to read robot.yaml", how_to_get("yaml"))
        return None
    try:
        deep = 0
        for number, event in enumerate(yaml.parse(data, Loader=yaml.SafeLoader)):
            line = event.start_mark.line + 1
            if isinstance(event, yaml.AliasEvent):
                findings.error("a YAML alias", "plain values", "write it out", line)
                return None
            deep += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if deep > DEEPEST or number > MOST_VALUES:
                found = "lists in lists without end" if deep > DEEPEST else f"more than {MOST_VALUES} values"
                findings.error(found, f"a {' or '.join(KEYS[:2])} of a robot", "", line)
                return None
        root = yaml.compose(data, Loader=yaml.SafeLoader)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        text = clip(str(error.problem or error.context or error))
        findings.error(f"the YAML does not parse: {text}", "YAML 1.1", "", mark.line + 1 if mark else None)
        return None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        findings.error(f"the YAML does not parse: {clip(str(error), 120)}", "YAML 1.1")
        return None
    if not isinstance(root, yaml.MappingNode):
        findings.error("the YAML is not a mapping", "key: value lines", "", 1)
        return None
    return {str(key.value): _entry(value) for key, value in root.value}


def _entry(node: yaml.Node) -> YamlItem:
    line = node.start_mark.line + 1
    if isinstance(node.value, list):
        items = [child[1] if isinstance(child, tuple) else child for child in node.value]
        return YamlItem("", line, tuple(_entry(child) for child in items))
    return YamlItem(str(node.value), line)
