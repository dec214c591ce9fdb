"""What tree and cuts do not say of a robot, as the keys of a loops.toml: in a file of its own, or inside another.

Actuators, tool, gravity, couplings, homes, variants, title, source, and joints whose type the tree's format lacks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.defaults import actuated_by_default, tool_by_default
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.common.reading import Tree
from cutjoint.description.formats.common.toml.table import Table, parse
from cutjoint.description.formats.urdf.joint import unit_axis
from cutjoint.description.formats.urdf.link import LARGEST_INERTIA, LARGEST_MASS
from cutjoint.description.model import (
    Coupling,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Limits,
    Place,
    RobotDescription,
    Variant,
)
from cutjoint.description.transforms import placement

EARTH = readonly([0.0, 0.0, -9.81])
"""m/s2."""


@dataclass(frozen=True, eq=False)
class Change:
    """What [joint.NAME] changes of a joint, because the tree's format cannot say it; None leaves it."""

    name: str
    type: JointType | None
    axis: Array | None
    axis2: Array | None
    velocity: float | None
    effort: float | None
    place: Place

    def of(self, joint: Joint) -> Joint:
        """The changed joint.  Limits of one coordinate go where there is another number of coordinates."""
        kind = self.type or joint.type
        lower, upper = joint.limits.lower, joint.limits.upper
        if not kind.single:
            lower = upper = None
        velocity = joint.limits.velocity if self.velocity is None else self.velocity
        effort = joint.limits.effort if self.effort is None else self.effort
        axis = joint.axis if self.axis is None else self.axis
        axis2 = joint.axis2 if self.axis2 is None else self.axis2
        return replace(joint, type=kind, axis=axis, axis2=axis2, limits=Limits(lower, upper, velocity, effort))


@dataclass(frozen=True, eq=False)
class Extras:
    """What was read, with None and () where the file is silent.  `fixed`: link -> name of the fixed joint above it."""

    actuators: tuple[str, ...] | None = None
    tool: Frame | None = None
    gravity: Array = field(default_factory=lambda: EARTH)
    cuts: tuple[CutJoint, ...] = ()
    couplings: tuple[Coupling, ...] = ()
    homes: tuple[Home, ...] = ()
    variants: tuple[Variant, ...] = ()
    joints: tuple[Change, ...] = ()
    fixed: dict[str, str] = field(default_factory=dict)
    name: str = ""
    title: str = ""
    source: str = ""
    places: dict[str, Place] = field(default_factory=dict)


def read_extras(text: str, findings: Findings, line: int | None = None) -> Extras | None:
    """The keys in a piece of TOML inside another file, or None where it does not parse."""
    own = Findings(findings.file)
    values = parse(text.encode("utf-8"), own)
    if values is not None:
        top = Table(values, (), {(): line} if line else {}, own)
        extras = take_extras(top, actuators_required=False)
        fixed = top.table("fixed")
        if fixed is not None:
            extras = replace(extras, fixed={link: fixed.string(link) for link in fixed.data})
        top.finish()
    findings.problems.extend(replace(problem, line=line) for problem in own.problems)
    return None if values is None else extras


def take_extras(top: Table, actuators_required: bool) -> Extras:
    """Take the keys out of the top table of a loops.toml.  Keys that it does not have stay unknown."""
    cuts = tuple(_cut(table) for table in top.tables("cut"))
    couplings = tuple(_coupling(table) for table in top.tables("coupling"))
    homes = tuple(_home(name, table) for name, table in top.named_tables("home"))
    variants = tuple(_variant(name, table) for name, table in top.named_tables("variant"))
    joints = tuple(_joint(name, table) for name, table in top.named_tables("joint"))
    gravity = top.vector("gravity", 3, tuple(EARTH))
    return Extras(
        actuators=top.strings("actuators", required=actuators_required),
        tool=_tool(top),
        gravity=EARTH if gravity is None else readonly(gravity),
        cuts=tuple(one for one in cuts if one is not None),
        couplings=tuple(one for one in couplings if one is not None),
        homes=homes,
        variants=variants,
        joints=tuple(one for one in joints if one is not None),
        name=top.string("name"),
        title=top.string("title"),
        source=top.string("source"),
        places=_places(top, homes, variants),
    )


def described(
    tree: Tree, cuts: Sequence[CutJoint], extras: Extras | None, path: Path, findings: Findings
) -> RobotDescription:
    """Tree, cuts and the rest as one description.

    Where a file has no extras, a chain without cuts gets the defaults of a plain URDF, and a robot with cuts the
    actuators that the reader put into the tree, or none.
    """
    extras = extras or Extras()
    joints = _changed(tree.joints, extras, findings)
    couplings = (*tree.couplings, *extras.couplings)
    actuators, tool = extras.actuators, extras.tool
    if actuators is None:
        actuators = tree.actuators if cuts else actuated_by_default(joints, couplings)
    if tool is None and not cuts:
        tool = tool_by_default(tree.links, joints)
    return RobotDescription(
        name=extras.name or tree.name,
        links=tuple(tree.links),
        joints=tuple(joints),
        cuts=tuple(cuts),
        couplings=couplings,
        actuators=actuators,
        tool=tool,
        gravity=extras.gravity,
        homes=extras.homes,
        variants=extras.variants,
        title=extras.title,
        source=extras.source,
        path=path,
        places=extras.places,
    )


def _changed(joints: Sequence[Joint], extras: Extras, findings: Findings) -> list[Joint]:
    """The joints with what [joint.NAME] changes of them."""
    changes = {change.name: change for change in extras.joints}
    known = {joint.name for joint in joints}
    for name, change in changes.items():
        if name not in known:
            found = f"[joint.{name}] is for a joint that the tree does not have"
            findings.error(found, "a joint of the tree", nearest(name, known), change.place)
    return [changes[joint.name].of(joint) if joint.name in changes else joint for joint in joints]


def _places(top: Table, homes: Sequence[Home], variants: Sequence[Variant]) -> dict[str, Place]:
    places = {key: top.place(key) for key in ("actuators", "tool", "gravity")}
    for kind, names in (("home", [one.name for one in homes]), ("variant", [one.name for one in variants])):
        for name in names:
            places[f"{kind}.{name}"] = Table({}, (kind, name), top.lines, top.findings).place()
    return places


def take_frame(table: Table, key: str, value: object) -> Frame | None:
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
        ends = [take_frame(table, "frames", value) for value in frames]
    elif frames is not None:
        table.wrong("frames", frames, "a list of two frames")
    if not name or text not in kinds or len(ends) != 2 or ends[0] is None or ends[1] is None:
        return None
    return CutJoint(name, CutType(text), ends[0], ends[1], table.place())


def _tool(top: Table) -> Frame | None:
    table = top.table("tool")
    if table is None:
        return None
    value = table.take("frame", required=True, expected="a link")
    table.finish()
    return None if value is None else take_frame(table, "frame", value)


def _joint(name: str, table: Table) -> Change | None:
    kinds = [kind.value for kind in JointType]
    place = table.place()
    text = table.string("type")
    axes = [table.vector(key, 3) for key in ("axis", "axis2")]
    velocity, effort = (table.number(key) if key in table.data else table.take(key) for key in ("velocity", "effort"))
    table.finish()
    if text and text not in kinds:
        found, expected = f"type '{text}' of {table.name}", f"one of {', '.join(kinds)}"
        table.findings.error(found, expected, nearest(text, kinds), table.place("type"))
        return None
    first, second = (None if one is None else unit_axis(one, name, table.findings, place) for one in axes)
    return Change(name, JointType(text) if text else None, first, second, velocity, effort, place)


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
