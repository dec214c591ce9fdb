"""What couples joints in an SDF: `<mimic>` of an axis, and joints of the type gearbox."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint.description.formats.sdf.frames import Carriers, Frames
from cutjoint.description.formats.sdf.joint import TYPES, gearbox_axis, half
from cutjoint.description.formats.sdf.scope import Item
from cutjoint.description.formats.sdf.values import text_of
from cutjoint.description.model import Coupling, Joint, Place
from cutjoint.description.numbers import LARGEST_PHYSICS, read_numbers
from cutjoint.description.xml import Element, only_child
from cutjoint.findings import clip

_AXES = ("axis", "axis2")


@dataclass(frozen=True, eq=False)
class Mimic:
    """An axis of a joint follows one of another: multiplier * (leader - reference) + offset."""

    follower: Item
    axis: str
    leader: Item
    leader_axis: str
    multiplier: float
    offset: float
    place: Place

    @property
    def coupling(self) -> Coupling:
        """It as a coupling of the joints that the axes become."""
        joint, driver = half(self.follower.full, self.axis), half(self.leader.full, self.leader_axis)
        return Coupling.geared(f"{joint}_mimic", joint, driver, self.multiplier, self.offset, self.place)


def _axes_of(item: Item) -> int:
    kind = TYPES.get(str(item.element.get("type") or "").strip())
    return 0 if kind is None else kind.axes


def read_mimics(items: Sequence[Item]) -> Iterator[Mimic]:
    """Every `<mimic>` that can be read."""
    for item in items:
        for tag in _AXES[: _axes_of(item)]:
            axis = only_child(item.element, tag, item.scope.findings)
            mimic = None if axis is None else only_child(axis, "mimic", item.scope.findings)
            one = None if mimic is None else _mimic(mimic, item, tag)
            if one is not None:
                yield one


def _mimic(element: Element, item: Item, tag: str) -> Mimic | None:
    findings, line = item.scope.findings, element.sourceline
    what = f"the mimic of joint '{item.name}'"
    values = {}
    for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0")):
        part = only_child(element, key, findings)
        text = default if part is None else part.text
        number = read_numbers(text, 1, f"{key} of {what}", findings, line, LARGEST_PHYSICS)
        values[key] = number[0] if number else 0.0
    name, axis = str(element.get("joint") or "").strip(), str(element.get("axis") or "axis").strip()
    leader = item.scope.look(name, ("joint",), f"{what} follows the unknown joint", line)
    if leader is None:
        return None
    if axis not in _AXES:
        findings.unknown(f"{what} follows the '{clip(axis)}' of a joint", axis, _AXES, line)
        return None
    if _AXES.index(axis) >= _axes_of(leader):
        count = _axes_of(leader)
        findings.error(f"{what} follows <{axis}> of joint '{name}'", f"a joint with it: that has {count}", "", line)
        return None
    offset = values["offset"] - values["multiplier"] * values["reference"]
    return Mimic(item, tag, leader, axis, values["multiplier"], offset, Place(findings.file, line))


def read_gearbox(item: Item, joints: Sequence[Joint], frames: Frames, carriers: Carriers) -> Coupling | None:
    """A gearbox as a coupling of the two hinges between its reference body and its parent and child.

    With theta1 the angle from the reference body to the parent about <axis>, and theta2 that to the child about
    <axis2>: theta2 = -ratio theta1.
    """
    findings, element = item.scope.findings, item.element
    what = f"gearbox '{item.name}'"
    part = only_child(element, "gearbox_ratio", findings)
    ratio = read_numbers("1" if part is None else part.text, 1, f"ratio of {what}", findings, item.line)
    body = text_of(only_child(element, "gearbox_reference_body", findings))
    if not body:
        findings.error(f"{what} without <gearbox_reference_body>", "the link that carries its gears", "", item.line)
    names = [body, *(text_of(only_child(element, tag, findings)) for tag in ("parent", "child"))]
    if ratio is None or not all(names):
        if body and ratio is not None:
            findings.error(f"{what} without parent or child", "two gears", "", item.line)
        return None
    links = [carriers.named(item.scope, name, f"{what} at the unknown frame", item.line) for name in names]
    found = []
    for link, tag in ((links[1], "axis"), (links[2], "axis2")):
        axis = gearbox_axis(item, tag, frames)
        hinge = None if axis is None or None in links else _hinge(links[0] or "", link or "", axis, joints)
        if axis is not None and hinge is None and None not in links:
            told = f"{what} (ratio {ratio[0]:g}) without a hinge between '{links[0]}' and '{link}' along its <{tag}>"
            findings.error(told, "a revolute or continuous joint there", "", item.line)
        found += [] if hinge is None else [hinge]
    if len(found) != 2:
        return None
    (driver, first), (joint, second) = found
    place = Place(findings.file, item.line)
    return Coupling.geared(item.full, joint.name, driver.name, -ratio[0] * first * second, 0.0, place)


def _hinge(reference: str, link: str, axis: np.ndarray, joints: Sequence[Joint]) -> tuple[Joint, float] | None:
    """The hinge between two links along an axis in the world, and by what its coordinate is to be multiplied to get
    the angle from the first to the second about that axis."""
    for joint in joints:
        if {joint.parent, joint.child} == {reference, link} and joint.type.turns:
            along = float(joint.placement[:3, :3] @ joint.axis @ axis)
            if abs(abs(along) - 1.0) < 1e-9:
                return joint, float(np.sign(along)) * (1.0 if joint.child == link else -1.0)
    return None
