"""The keys of a loops.toml, in a file of its own or inside another.

Actuators, tool and its task, gravity, couplings, homes, variants, title, source, and what the tree's format lacks: of
joints types, limits, physics, of links the compensation of their weight.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace

from cutjoint.arrays import readonly
from cutjoint.description.formats.common.extras import EARTH, Change, Compensated, Extras
from cutjoint.description.formats.common.physics import CUT_KEYS, KEYS
from cutjoint.description.formats.common.toml.couplings import take_coupling
from cutjoint.description.formats.common.toml.physics import take_bushing, take_physics
from cutjoint.description.model import (
    TASK_AXES,
    TASK_NAMES,
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    JointPhysics,
    JointType,
    Place,
    TaskAxes,
    Variant,
)
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, unit_axis
from cutjoint.description.transforms import placement
from cutjoint.findings import Findings, clip
from cutjoint.toml.table import TomlTable, parse


def read_extras(text: str, findings: Findings, line: int | None = None) -> Extras | None:
    """The keys in a piece of TOML inside another file, or None where it does not parse."""
    own = Findings(findings.file)
    values = parse(text.encode("utf-8"), own)
    if values is not None:
        top = TomlTable(values, (), {(): line} if line else {}, own)
        extras = take_extras(top, actuators_required=False)
        fixed = top.table("fixed")
        if fixed is not None:
            extras = replace(extras, fixed={link: fixed.string(link) for link in fixed.data})
        top.finish()
    findings.problems.extend(replace(problem, line=line) for problem in own.problems)
    return None if values is None else extras


def take_extras(top: TomlTable, actuators_required: bool) -> Extras:
    """Take the keys out of the top table of a loops.toml.  Keys that it does not have stay unknown."""
    cuts = tuple(_cut(table) for table in top.tables("cut"))
    couplings = tuple(take_coupling(table) for table in top.tables("coupling"))
    homes = tuple(_home(name, table) for name, table in top.named_tables("home"))
    variants = tuple(_variant(name, table) for name, table in top.named_tables("variant"))
    joints = tuple(_joint(name, table) for name, table in top.named_tables("joint"))
    links = {name: _link(table) for name, table in top.named_tables("link")}
    gravity = top.vector("gravity", 3, tuple(EARTH))
    tool, task, axes = _tool(top)
    return Extras(
        actuators=top.strings("actuators", required=actuators_required),
        tool=tool,
        task=task,
        task_axes=axes,
        gravity=EARTH if gravity is None else readonly(gravity),
        cuts=tuple(one for one in cuts if one is not None),
        couplings=tuple(one for one in couplings if one is not None),
        homes=homes,
        variants=variants,
        joints=tuple(one for one in joints if one is not None),
        links={name: one for name, one in links.items() if one is not None},
        name=top.string("name"),
        title=top.string("title"),
        source=top.string("source"),
        places=_places(top, homes, variants),
    )


def _places(top: TomlTable, homes: Sequence[Home], variants: Sequence[Variant]) -> dict[str, Place]:
    places = {key: top.place(key) for key in ("actuators", "tool", "gravity")}
    places["task"] = TomlTable({}, ("tool",), top.lines, top.findings).place("task")
    for kind, names in (("home", [one.name for one in homes]), ("variant", [one.name for one in variants])):
        for name in names:
            places[f"{kind}.{name}"] = TomlTable({}, (kind, name), top.lines, top.findings).place()
    return places


def take_frame(table: TomlTable, key: str, value: object) -> Frame | None:
    """A frame: the name of a link, or a table with link, xyz and rpy."""
    if isinstance(value, str):
        return Frame(value)
    if not isinstance(value, dict):
        table.wrong(key, value, 'a link, as in "tool", or { link = "...", xyz = [..], rpy = [..] }')
        return None
    inner = TomlTable(value, (*table.path, key), table.lines, table.findings)
    link = inner.string("link", required=True)
    xyz = inner.vector("xyz", 3, (0.0, 0.0, 0.0))
    rpy = inner.vector("rpy", 3, (0.0, 0.0, 0.0))
    inner.finish()
    return Frame(link, placement(xyz, rpy)) if link and xyz is not None and rpy is not None else None


def _cut(table: TomlTable) -> CutJoint | None:
    name = table.string("name", required=True)
    text = table.string("type", required=True)
    frames = table.take("frames", required=True, expected="the two frames that the cut joins")
    physics, bushing = JointPhysics(**take_physics(table, CUT_KEYS)), take_bushing(table)
    length = table.number("length", required=text == CutType.DISTANCE)
    if "length" in table.data and text != CutType.DISTANCE:
        table.wrong("length", table.data["length"], "a length of cuts of type distance only")
    table.finish()
    kinds = [kind.value for kind in CutType]
    if text and text not in kinds:
        table.findings.unknown(f"type '{text}' of {table.name}", text, kinds, table.place("type"))
    ends: list[Frame | None] = []
    if isinstance(frames, list) and len(frames) == 2:
        ends = [take_frame(table, "frames", value) for value in frames]
    elif frames is not None:
        table.wrong("frames", frames, "a list of two frames")
    if not name or text not in kinds or len(ends) != 2 or ends[0] is None or ends[1] is None:
        return None
    return CutJoint(name, CutType(text), ends[0], ends[1], table.place(), physics, bushing, length or 0.0)


def _tool(top: TomlTable) -> tuple[Frame | None, tuple[str, ...], TaskAxes]:
    """Frame of the tool, names of its task, which `description.checks` looks at, and its axes."""
    table = top.table("tool")
    if table is None:
        return None, (), "world"
    value = table.take("frame", required=True, expected="a link")
    task, axes = table.strings("task"), table.string("axes", "world")
    if task == ():
        table.wrong("task", [], f"some of {', '.join(TASK_NAMES)}; or no such key, and it is found at home")
    if axes not in TASK_AXES:
        table.findings.unknown(f"the task has the axes '{clip(axes)}'", axes, TASK_AXES, table.place("axes"))
    table.finish()
    if value is None:
        return None, (), "world"
    return take_frame(table, "frame", value), task or (), "tool" if axes == "tool" else "world"


def _joint(name: str, table: TomlTable) -> Change | None:
    kinds = [kind.value for kind in JointType]
    place = table.place()
    text = table.string("type")
    axes = [table.vector(key, 3) for key in ("axis", "axis2")]
    # bounds of what is driven may be anything, as in URDF
    velocity, effort = (table.number(one, None, largest=sys.float_info.max) for one in ("velocity", "effort"))
    physics = take_physics(table, KEYS)
    table.finish()
    if text and text not in kinds:
        table.findings.unknown(f"type '{text}' of {table.name}", text, kinds, table.place("type"))
        return None
    first, second = (None if one is None else unit_axis(one, name, table.findings, place) for one in axes)
    return Change(name, JointType(text) if text else None, first, second, velocity, effort, physics, place)


def _link(table: TomlTable) -> Compensated | None:
    share = table.number("gravity_compensation", required=True)
    table.finish()
    return None if share is None else Compensated(share, table.place())


def _home(name: str, table: TomlTable) -> Home:
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


def _variant(name: str, table: TomlTable) -> Variant:
    about = table.string("about")
    inertials = {link: _inertial(one) for link, one in table.named_tables("inertial")}
    table.finish()
    return Variant(name, about, {link: one for link, one in inertials.items() if one is not None})


def _inertial(table: TomlTable) -> Inertial | None:
    mass = table.number("mass", required=True, largest=LARGEST_MASS)
    com = table.vector("com", 3, (0.0, 0.0, 0.0))
    entries = table.vector("inertia", 6, required=True, largest=LARGEST_INERTIA)
    table.finish()
    if mass is None or com is None or entries is None:
        return None
    return Inertial.of(mass, com, entries)
