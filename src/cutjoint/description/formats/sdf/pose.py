"""Poses in SDF, `<pose relative_to="...">x y z roll pitch yaw</pose>`, of links, joints and frames in their model."""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.model import IDENTITY
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import from_rotation, placement, rotation_from_quaternion
from cutjoint.description.xml import Element, children, only_child


def text_of(element: Element | None) -> str:
    """The text inside an element, without blanks around it; empty where there is none."""
    return "" if element is None else str(element.text or "").strip()


def read_pose(element: Element, what: str, findings: Findings) -> Array:
    """The `<pose>` inside `element` (4, 4), in whatever frame it is relative to."""
    pose = only_child(element, "pose", findings)
    if pose is None or not text_of(pose):
        return IDENTITY
    line = pose.sourceline
    if str(pose.get("rotation_format") or "") == "quat_xyzw":
        values = read_numbers(pose.text, 7, f"pose of {what}", findings, line)
        if values is None:
            return IDENTITY
        quaternion = (values[6], *values[3:6])
        if np.linalg.norm(quaternion) < 1e-9:
            findings.error(f"pose of {what}: a quaternion of zeros", "a rotation", "", line)
            return IDENTITY
        return from_rotation(rotation_from_quaternion(quaternion), values[:3])
    values = read_numbers(pose.text, 6, f"pose of {what}", findings, line)
    if values is None:
        return IDENTITY
    angles = np.deg2rad(values[3:]) if str(pose.get("degrees") or "") in ("1", "true") else values[3:]
    return placement(values[:3], angles)


class Poses:
    """The placements of everything named in a model, each worked out once."""

    def __init__(self, model: Element, findings: Findings) -> None:
        self.findings = findings
        self._elements: dict[tuple[str, str], Element] = {}
        for kind in ("link", "joint", "frame"):
            for element in children(model, kind):
                self._elements.setdefault((kind, str(element.get("name") or "").strip()), element)
        self._known: dict[tuple[str, str], Array] = {}
        self._open: set[tuple[str, str]] = set()

    def world(self, name: str, kind: str | None, line: int | None) -> Array:
        """The placement (4, 4) of a link, joint or frame in the model; None as kind takes whichever has the name."""
        if name in ("__model__", "world", ""):
            return IDENTITY
        kinds = (kind,) if kind else ("link", "joint", "frame")
        key = next(((one, name) for one in kinds if (one, name) in self._elements), None)
        if key is None:
            names = [each for _, each in self._elements]
            self.findings.error(f"unknown frame '{name}'", "a link, joint or frame", nearest(name, names), line)
            return IDENTITY
        if key in self._open:
            self.findings.error(f"the pose of '{name}' is relative to itself", "poses without a ring", "", line)
            return IDENTITY
        if key not in self._known:
            self._open.add(key)
            self._known[key] = self._place(*key)
            self._open.discard(key)
        return self._known[key]

    def _place(self, kind: str, name: str) -> Array:
        element = self._elements[kind, name]
        pose = only_child(element, "pose", self.findings)
        relative = "" if pose is None else str(pose.get("relative_to") or pose.get("frame") or "").strip()
        own = read_pose(element, f"{kind} '{name}'", self.findings)
        base, base_kind = relative, None
        if not relative and kind == "joint":
            base, base_kind = text_of(only_child(element, "child", self.findings)), "link"
        elif not relative and kind == "frame":
            base = str(element.get("attached_to") or "")
        if not base:
            return own
        above = self.world(base, base_kind, element.sourceline)
        return above if np.array_equal(own, IDENTITY) else readonly(above @ own)
