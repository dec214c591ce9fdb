"""The `<joint>`s of an SDF as joints between links, placed in the world at zero.

A joint with two axes is one universal joint where its axes are perpendicular and alike, and nothing else names one of
them; otherwise it is two revolute joints X and X/2 with a massless link between them.  A screw is two joints as well.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.graph import PlacedLink
from cutjoint.description.formats.common.screw import SCREW, Screw, read_lead
from cutjoint.description.formats.sdf.dynamics import read_limits, read_physics, unused_axis, with_rotor
from cutjoint.description.formats.sdf.frames import Carriers, Frames
from cutjoint.description.formats.sdf.scope import Item
from cutjoint.description.formats.sdf.values import WORLD, child_flag, text_of
from cutjoint.description.model import Coupling, Joint, JointPhysics, JointType, Limits, Link, Place
from cutjoint.description.numbers import read_numbers, unit_axis
from cutjoint.description.xml import Element, only_child

GEARBOX = "gearbox"
TYPES = {kind.sdf: kind for kind in JointType if kind.sdf} | {
    "revolute2": JointType.UNIVERSAL,
    SCREW: JointType.REVOLUTE,
}
_ALL = (*TYPES, GEARBOX)
_REFUSED = {"piston": "a revolute and a prismatic joint"}
_SECOND = "/2"
_SKEW = 1e-12


@dataclass
class Edges:
    """Joints with two ends, links between the halves of those that are two, their couplings, and which joints should
    close loops."""

    joints: list[Joint] = field(default_factory=list)
    links: list[PlacedLink] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    gearboxes: list[Item] = field(default_factory=list)
    last: list[str] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Axis:
    """An axis of a joint: its direction (3,) in the joint's frame, its range, and what it does by itself."""

    direction: Array
    limits: Limits
    physics: JointPhysics


def half(name: str, axis: str) -> str:
    """What the revolute joint along `axis` or `axis2` of a joint with two axes is called."""
    return name + _SECOND if axis == "axis2" else name


def read_joints(items: list[Item], split: Collection[Item], frames: Frames, carriers: Carriers) -> Edges:
    """All joints, read; those in `split` never as universal joints."""
    edges = Edges()
    for item in items:
        element, findings = item.element, item.scope.findings
        text = str(element.get("type") or "").strip()
        ends = _ends(item, carriers)
        if text in _REFUSED:
            found = f"type '{text}' of joint '{item.name}' is not supported"
            findings.error(found, f"one of {', '.join(_ALL)}", f"write it as {_REFUSED[text]}", item.line)
        elif text not in _ALL:
            findings.unknown(f"type '{text}' of joint '{item.name}'", text, _ALL, item.line)
        elif text == GEARBOX:
            edges.gearboxes.append(item)
        elif ends is not None:
            _read(item, TYPES[text], ends, item in split, frames, edges)
    return edges


def _ends(item: Item, carriers: Carriers) -> tuple[str, str] | None:
    """The links that a joint joins, or None after noting why not."""
    ends = []
    for tag in ("parent", "child"):
        end = only_child(item.element, tag, item.scope.findings)
        line = item.line if end is None else end.sourceline
        if not text_of(end):
            found = f"joint '{item.name}' without {tag}"
            item.scope.findings.error(found, "the name of a link or frame", "", line)
            continue
        body = carriers.named(item.scope, text_of(end), f"{tag} of joint '{item.name}' is the unknown frame", line)
        ends += [] if body is None else [body]
    if len(ends) == 2 and ends[0] == ends[1]:
        found = f"both ends of joint '{item.name}' are on '{ends[0]}'"
        item.scope.findings.error(found, "two links", "a joint joins two links", item.line)
    return (ends[0], ends[1]) if len(ends) == 2 and ends[0] != ends[1] else None


def _read(item: Item, kind: JointType, ends: tuple[str, str], split: bool, frames: Frames, edges: Edges) -> None:
    element, findings = item.element, item.scope.findings
    at = frames.of(item)
    axes = _axes(item, kind, at, frames)
    place, name = Place(findings.file, item.line), item.full
    if kind.axes == 2 and len(axes) == 2 and (split or not _alike(axes)):
        middle = f"{name}_middle"
        edges.links.append(PlacedLink(Link(middle, place=place), at))
        for one, tag, (parent, child) in zip(
            axes, ("axis", "axis2"), ((ends[0], middle), (middle, ends[1])), strict=True
        ):
            joint = Joint(half(name, tag), JointType.REVOLUTE, parent, child, at, one.direction)
            edges.joints.append(_with(joint, one, place))
        names = [name, half(name, "axis2")]
    else:
        first = axes[0] if axes else Axis(readonly([1.0, 0.0, 0.0]), Limits(), JointPhysics())
        second = axes[1].direction if len(axes) == 2 else readonly([0.0, 1.0, 0.0])
        joint = _with(Joint(name, kind, *ends, at, first.direction, second), first, place)
        edges.joints += _screw(joint, item, edges) if item.element.get("type") == SCREW else [joint]
        names = [name]
    physics = only_child(element, "physics", findings)
    simbody = None if physics is None else only_child(physics, "simbody", findings)
    if simbody is not None and child_flag(simbody, "must_be_loop_joint", findings):
        edges.last += names


def _screw(joint: Joint, item: Item, edges: Edges) -> list[Joint]:
    lead = read_lead(item.element, item.name, item.scope.findings)
    if lead is None:
        return [joint]
    screw = Screw.of(joint, lead, joint.placement)
    edges.links.append(PlacedLink(screw.nut, joint.placement))
    edges.couplings.append(screw.coupling)
    return [screw.turn, screw.slide]


def _with(joint: Joint, axis: Axis, place: Place) -> Joint:
    values = (joint.name, joint.type, joint.parent, joint.child, joint.placement, joint.axis, joint.axis2)
    return Joint(*values, axis.limits, axis.physics, place)


def _alike(axes: list[Axis]) -> bool:
    """Whether one universal joint does what two axes say."""
    first, second = axes
    square = abs(float(first.direction @ second.direction)) < _SKEW
    return square and first.physics == second.physics and first.limits == second.limits == Limits()


def _axes(item: Item, kind: JointType, at: Array, frames: Frames) -> list[Axis]:
    """What the axes of a joint say, as many as its type has; those it has besides are noted."""
    element, findings = item.element, item.scope.findings
    axes = []
    for number, tag in enumerate(("axis", "axis2")):
        axis = only_child(element, tag, findings)
        if number >= kind.axes:
            unused_axis(axis, item.name, kind, findings)
        elif axis is None:
            found = f"{kind.value} joint '{item.name}' without <{tag}>"
            findings.error(found, f"<{tag}><xyz>...</xyz></{tag}>", f"it has {kind.axes}", item.line)
        else:
            one = JointType.REVOLUTE if kind.axes == 2 else kind
            direction = _direction(axis, item, at, frames)
            limits, physics = read_limits(axis, item.name, one, findings), read_physics(axis, item.name, one, findings)
            physics = with_rotor(physics, element, item.name, kind, findings)
            axes.append(Axis(direction, limits, physics))
    return axes


def _direction(axis: Element, item: Item, at: Array, frames: Frames) -> Array:
    """The unit vector of an axis in the frame of its joint."""
    findings, scope, name = item.scope.findings, item.scope, item.name
    xyz = only_child(axis, "xyz", findings)
    line = axis.sourceline if xyz is None else xyz.sourceline
    if xyz is None:
        findings.doubt(f"<{axis.tag}> of joint '{name}' without <xyz>", "a direction", "it was read as 0 0 1", line)
    values = read_numbers("0 0 1" if xyz is None else xyz.text, 3, f"axis of joint '{name}'", findings, line)
    unit = unit_axis(values or (0.0, 0.0, 1.0), name, findings, line)
    frame = "" if xyz is None else str(xyz.get("expressed_in") or "").strip()
    old = scope.version < (1, 7) and child_flag(axis, "use_parent_model_frame", findings)
    if frame:
        other = frames.named(scope, frame, f"axis of joint '{name}' in the unknown frame", line)
    elif old or scope.version < (1, 5):
        other = frames.origin(scope)
    else:
        return unit
    return readonly(at[:3, :3].T @ other[:3, :3] @ unit)


def gearbox_axis(item: Item, tag: str, frames: Frames) -> Array | None:
    """The direction (3,) in the world of an axis of a gearbox, or None after noting that it is missing."""
    axis = only_child(item.element, tag, item.scope.findings)
    if axis is None:
        item.scope.findings.error(f"gearbox '{item.name}' without <{tag}>", "two axes", "", item.line)
        return None
    at = frames.of(item)
    return np.asarray(at[:3, :3] @ _direction(axis, item, at, frames))


def world_end(joint: Joint) -> bool:
    """Whether a joint hangs on the world."""
    return WORLD in (joint.parent, joint.child)
