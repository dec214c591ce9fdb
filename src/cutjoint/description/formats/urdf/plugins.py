"""Plugins in the `<gazebo>` of a URDF: those that couple joints or join links are read, or quoted in an error.

Read are mimic plugins with `joint`, `mimicJoint`, `multiplier` and `offset`, as that of roboticsgroup
(https://github.com/roboticsgroup/roboticsgroup_gazebo_plugins) and its relatives, and detachable joints of Gazebo Sim
(gz::sim::systems::DetachableJoint) between two links of the robot, which hold until someone detaches them.  Sensors,
controllers and drives do not change the mechanism.
"""

from __future__ import annotations

import re

from cutjoint.arrays import readonly
from cutjoint.description.findings import Findings, clip
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.formats.urdf.zero import placements
from cutjoint.description.model import IDENTITY, Coupling, CutJoint, CutType, Frame, Place
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element, children

_ACTS = re.compile(
    r"mimic|detach|attach|loop|clos(ed|ing|ure)|parallel|constraint|coupl(ed|er|ing)|gear_?box|tendon|spring|cable|weld"
    r"|linkage|disable_?link",
    re.IGNORECASE,
)
"""Names of plugins that may close loops, couple joints or act on them."""


def read_plugin(element: Element, tree: OpenTree, findings: Findings) -> None:
    """Add to `tree` the coupling or cut of a `<plugin>`; one that acts and cannot be read is a doubt."""
    values = {str(one.tag): text_of(one) for one in children(element)}
    names = f"{element.get('filename') or ''} {element.get('name') or ''}"
    if values.get("joint") and values.get("mimicJoint"):
        _mimic(element, values, tree, findings)
    elif "DetachableJoint" in names and _attached(element, values, tree, findings.file):
        return
    elif _ACTS.search(names):
        said = ", ".join(f"<{tag}>{text}" for tag, text in values.items())
        found = f"plugin '{clip(names.strip(), 120)}' ({clip(said, 120)}) may join or couple parts, and is not read"
        mend = "say what it does as <mimic>, as a joint in <gazebo> or in a loops.toml, and remove it"
        findings.doubt(found, "a mimic plugin, or a detachable joint between two links", mend, element.sourceline)


def _mimic(element: Element, values: dict[str, str], tree: OpenTree, findings: Findings) -> None:
    offset = values.get("offset") or "0"
    said = (values["mimicJoint"], values["joint"], values.get("multiplier") or "1", offset)
    couple(said, "a mimic plugin", tree, element.sourceline, findings)


def couple(said: tuple[str, str, str, str], what: str, tree: OpenTree, line: int | None, findings: Findings) -> None:
    """Add the coupling of a follower, its driver, multiplier and offset (as texts) that something beside the tree
    says; one that repeats a `<mimic>` is passed, one that contradicts it is a doubt: the `<mimic>` stands."""
    joint, driver = said[:2]
    numbers = []
    for key, text in zip(("multiplier", "offset"), said[2:], strict=True):
        numbers.append(read_numbers(text, 1, f"{key} of {what} of joint '{joint}'", findings, line))
    ratio, offset = numbers
    if ratio is None or offset is None:
        return
    if any(one.name == joint and not one.type.moves for one in tree.joints):
        findings.warn(f"{what} of joint '{joint}', which is fixed, is not used", "a joint that moves", "", line)
        return
    coupling = Coupling.geared(f"{joint}_mimic", joint, driver, ratio[0], offset[0], Place(findings.file, line))
    same = [one for one in tree.couplings if one.joint == joint]
    if not same:
        tree.couplings.append(coupling)
    elif any(one.drives != coupling.drives or one.offset != coupling.offset for one in same):
        found = f"{what} says {coupling.formula}, and <mimic> says {same[0].formula}"
        findings.doubt(found, "the same in both", "keep one; a lenient reader keeps the <mimic>", line)


def _attached(element: Element, values: dict[str, str], tree: OpenTree, file: str) -> bool:
    """A detachable joint between two links of the robot, as a fixed cut where they are at zero."""
    world = placements(tree)
    parent, child = values.get("parent_link", ""), values.get("child_link", "")
    if values.get("child_model", "") not in (tree.name, "__model__") or parent not in world or child not in world:
        return False
    at = readonly(inverse(world[parent]) @ world[child])
    name = str(element.get("name") or "").rsplit("::", 1)[-1] or "detachable"
    place = Place(file, element.sourceline)
    tree.cuts.append(
        CutJoint(f"{parent}_{child}_{name}", CutType.FIXED, Frame(parent, at), Frame(child, IDENTITY), place)
    )
    return True
