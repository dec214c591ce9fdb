"""The native format, loops.toml beside a URDF (schema 1): cuts, actuators, tool, homes, variants.

All keys are described in docs/description.md.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cutjoint.arrays import readonly
from cutjoint.description.files import read_text_file
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats import urdf
from cutjoint.description.formats.reading import Reading, Tree
from cutjoint.description.formats.toml_table import Table, line_index, parse
from cutjoint.description.formats.urdf_link import LARGEST_INERTIA, LARGEST_MASS
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Place,
    RobotDescription,
    Variant,
)
from cutjoint.description.transforms import placement

SCHEMA = 1
EARTH = (0.0, 0.0, -9.81)


def read(path: Path) -> Reading:
    """A loops.toml and the URDF that it names."""
    findings = Findings(str(path))
    data = read_text_file(path, findings, "loops.toml")
    values = None if data is None else parse(data, findings)
    if data is None or values is None:
        return Reading(None, tuple(findings.problems))
    top = Table(values, (), line_index(data.decode("utf-8")), findings)
    schema = top.take("schema", required=True, expected=f"schema = {SCHEMA}")
    if schema is not None and (schema != SCHEMA or isinstance(schema, bool)):
        top.wrong("schema", schema, f"schema = {SCHEMA}, the one that this version reads")
    tree = _tree(top, path, findings)
    cuts = tuple(_cut(table) for table in top.tables("cut"))
    couplings = tuple(_coupling(table) for table in top.tables("coupling"))
    homes = tuple(_home(name, table) for name, table in top.named_tables("home"))
    variants = tuple(_variant(name, table) for name, table in top.named_tables("variant"))
    description = RobotDescription(
        name=top.string("name", default=tree.name if tree else path.parent.name),
        links=tuple(tree.links) if tree else (),
        joints=tuple(tree.joints) if tree else (),
        cuts=tuple(cut for cut in cuts if cut is not None),
        couplings=(*(tree.couplings if tree else ()), *(one for one in couplings if one is not None)),
        actuators=top.strings("actuators", required=True) or (),
        tool=_tool(top),
        gravity=readonly(top.vector("gravity", 3, EARTH) or EARTH),
        homes=homes,
        variants=variants,
        title=top.string("title"),
        source=top.string("source"),
        path=path,
        places=_places(top, homes, variants),
    )
    top.finish()
    return Reading(description if tree else None, tuple(findings.problems))


def _tree(top: Table, path: Path, findings: Findings) -> Tree | None:
    name = top.string("urdf", required=True)
    if not name:
        return None
    file = path.parent / name
    own = Findings(str(file))
    root = urdf.read_robot(file, own)
    tree = None if root is None else urdf.read_tree(root, file, own)
    findings.problems.extend(own.problems)
    return tree


def _places(top: Table, homes: tuple[Home, ...], variants: tuple[Variant, ...]) -> dict[str, Place]:
    places = {key: top.place(key) for key in ("actuators", "tool", "gravity")}
    for kind, named in (("home", homes), ("variant", variants)):
        for one in named:
            places[f"{kind}.{one.name}"] = Table({}, (kind, one.name), top.lines, top.findings).place()
    return places


def _frame(table: Table, key: str, value: object) -> Frame | None:
    """A frame: the name of a link, or a table with link, xyz and rpy."""
    if isinstance(value, str):
        return Frame(value)
    if not isinstance(value, dict):
        table.wrong(key, value, 'a link, as in "tool", or { link = "...", xyz = [..], rpy = [..] }')
        return None
    inner = Table(value, (*table.path, key), table.lines, table.findings)
    link = inner.string("link", required=True)
    xyz = inner.vector("xyz", 3, (0.0, 0.0, 0.0))
    rpy = inner.vector("rpy", 3, (0.0, 0.0, 0.0))
    inner.finish()
    return Frame(link, placement(xyz, rpy)) if link and xyz is not None and rpy is not None else None


def _tool(top: Table) -> Frame | None:
    table = top.table("tool")
    if table is None:
        return None
    value = table.take("frame", required=True, expected="a link")
    table.finish()
    return None if value is None else _frame(table, "frame", value)


def _cut(table: Table) -> CutJoint | None:
    name = table.string("name", required=True)
    text = table.string("type", required=True)
    frames = table.take("frames", required=True, expected="the two frames that the cut joins")
    table.finish()
    kinds = [kind.value for kind in CutType]
    if text and text not in kinds:
        found, expected = f"type '{text}' of {table.name}", f"one of {', '.join(kinds)}"
        table.findings.error(found, expected, nearest(text, kinds), table.place("type"))
    ends: list[Frame | None] = []
    if isinstance(frames, list) and len(frames) == 2:
        ends = [_frame(table, "frames", value) for value in frames]
    elif frames is not None:
        table.wrong("frames", frames, "a list of two frames")
    if not name or text not in kinds or len(ends) != 2 or ends[0] is None or ends[1] is None:
        return None
    return CutJoint(name, CutType(text), ends[0], ends[1], table.place())


def _coupling(table: Table) -> Coupling | None:
    name = table.string("name", required=True)
    joint, driver = table.string("joint", required=True), table.string("driver", required=True)
    ratio, offset = table.number("ratio", 1.0), table.number("offset", 0.0)
    table.finish()
    if not (name and joint and driver) or ratio is None or offset is None:
        return None
    return Coupling(name, joint, driver, ratio, offset, table.place())


def _home(name: str, table: Table) -> Home:
    about = table.string("about")
    actuated: dict[str, float] = {}
    passive: dict[str, float | tuple[float, ...]] = {}
    given = table.table("actuated")
    for joint in given.data if given else ():
        number = given.number(joint) if given else None
        if number is not None:
            actuated[joint] = number
    rough = table.table("passive")
    for joint in rough.data if rough else ():
        values = rough.values(joint) if rough else None
        if values is not None:
            passive[joint] = values
    table.finish()
    return Home(name, actuated, passive, about)


def _variant(name: str, table: Table) -> Variant:
    about = table.string("about")
    inertials = {link: _inertial(one) for link, one in table.named_tables("inertial")}
    table.finish()
    return Variant(name, about, {link: one for link, one in inertials.items() if one is not None})


def _inertial(table: Table) -> Inertial | None:
    mass = table.number("mass", required=True, largest=LARGEST_MASS)
    com = table.vector("com", 3, (0.0, 0.0, 0.0))
    entries = table.vector("inertia", 6, required=True, largest=LARGEST_INERTIA)
    table.finish()
    if mass is None or com is None or entries is None:
        return None
    ixx, iyy, izz, ixy, ixz, iyz = entries
    return Inertial(mass, readonly(com), np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]))
