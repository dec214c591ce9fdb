"""Texts of SDF elements: flags, poses `<pose>x y z roll pitch yaw</pose>`, and versions."""

from __future__ import annotations

import re

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.model import IDENTITY
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import from_rotation, placement, rotation_from_quaternion
from cutjoint.description.xml import Element, only_child
from cutjoint.findings import Findings, clip

WORLD = "world"
"""The link and frame that does not move."""
Version = tuple[int, int]
"""Major and minor: 1.10 is later than 1.9."""
USUAL: Version = (1, 6)
"""What a file without a version is read as."""
NEWEST: Version = (1, 12)
_ROTATIONS = ("euler_rpy", "quat_xyzw")


def text_of(element: Element | None) -> str:
    """The text inside an element, without blanks around it; empty where there is none."""
    return "" if element is None else str(element.text or "").strip()


def flag(text: str, what: str, findings: Findings, line: int | None) -> bool:
    """A truth value as SDF writes it, empty for false; notes anything else."""
    if text.lower() not in ("", "0", "1", "false", "true"):
        findings.error(f"{what} is '{clip(text)}'", "true or false", "", line)
    return text.lower() in ("1", "true")


def child_flag(element: Element, tag: str, findings: Findings) -> bool:
    """The truth value in the child `tag`, false where there is none."""
    part = only_child(element, tag, findings)
    return part is not None and flag(text_of(part), f"<{tag}> in <{element.tag}>", findings, part.sourceline)


def version_of(root: Element, findings: Findings) -> Version:
    """The version of an `<sdf>` element."""
    text = str(root.get("version") or "").strip()
    found = re.fullmatch(r"(\d{1,3})\.(\d{1,3})", text)
    if not found:
        told = f"version '{clip(text)}' of the SDF" if text else "an <sdf> without version"
        findings.error(told, 'such as <sdf version="1.9">', "", root.sourceline)
        return USUAL
    version = int(found[1]), int(found[2])
    if version > NEWEST:
        known = ".".join(map(str, NEWEST))
        findings.warn(f"version {text} of SDF is newer than this reader", f"at most {known}", "", root.sourceline)
    return version


def read_pose(element: Element, what: str, findings: Findings) -> Array:
    """The `<pose>` inside `element` (4, 4), in whatever frame it is relative to."""
    pose = only_child(element, "pose", findings)
    return IDENTITY if pose is None else pose_of(pose, what, findings)


def pose_of(pose: Element, what: str, findings: Findings) -> Array:
    """What a `<pose>` element says (4, 4)."""
    line = pose.sourceline
    form = str(pose.get("rotation_format") or "euler_rpy")
    degrees = flag(str(pose.get("degrees") or ""), f"degrees in the pose of {what}", findings, line)
    if form not in _ROTATIONS:
        findings.unknown(f"rotation_format '{clip(form)}' of the pose of {what}", form, _ROTATIONS, line)
    if not text_of(pose):
        return IDENTITY
    if form == "quat_xyzw":
        if degrees:
            found = f"pose of {what}: a quaternion in degrees"
            findings.error(found, "degrees with euler_rpy only", "remove degrees", line)
        return _quaternion_pose(pose, what, findings)
    values = read_numbers(pose.text, 6, f"pose of {what}", findings, line)
    if values is None:
        return IDENTITY
    return placement(values[:3], np.deg2rad(values[3:]) if degrees else values[3:])


def _quaternion_pose(pose: Element, what: str, findings: Findings) -> Array:
    values = read_numbers(pose.text, 7, f"pose of {what}", findings, pose.sourceline)
    if values is None:
        return IDENTITY
    quaternion = (values[6], *values[3:6])
    if np.linalg.norm(quaternion) < 1e-9:
        findings.error(f"pose of {what}: a quaternion of zeros", "a rotation", "", pose.sourceline)
        return IDENTITY
    return from_rotation(rotation_from_quaternion(quaternion), values[:3])
