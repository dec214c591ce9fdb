"""The `<link>` of an SDF (inertia, visual and collision shapes), and poses, `<pose relative_to="...">x y z roll pitch
yaw</pose>`, of links, joints and frames in their model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.files import read_mesh
from cutjoint.description.findings import Findings, nearest
from cutjoint.description.formats.common.graph import PlacedLink
from cutjoint.description.model import IDENTITY, Inertial, Link, Place, Shape
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, read_numbers
from cutjoint.description.transforms import from_rotation, placement, rotation_from_quaternion
from cutjoint.description.xml import Element, check_known, children, name_of, only_child


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


_NONE: frozenset[str] = frozenset()
_LINK_TAGS = frozenset({"pose", "inertial", "visual", "collision"})
_LINK_IGNORED = frozenset(
    {"sensor", "gravity", "kinematic", "self_collide", "velocity_decay", "light", "must_be_base_link", "audio_sink"}
    | {"audio_source", "battery", "enable_wind", "particle_emitter", "projector", "plugin"}
)
_SHAPES = {"box": ("size", 3), "sphere": ("radius", 1), "cylinder": ("radius", 1), "capsule": ("radius", 1)}


def read_body(element: Element, path: Path, poses: Poses, findings: Findings) -> PlacedLink | None:
    """One `<link>`, or None where it has no name."""
    check_known(element, frozenset({"name"}), _LINK_TAGS, _LINK_IGNORED, findings)
    name = name_of(element, findings)
    if name is None:
        return None
    link = Link(
        name=name,
        inertial=_inertial(element, name, findings),
        visuals=tuple(_shapes(element, "visual", name, path, findings)),
        collisions=tuple(_shapes(element, "collision", name, path, findings)),
        place=Place(findings.file, element.sourceline),
    )
    return PlacedLink(link, poses.world(name, "link", element.sourceline))


def _inertial(link: Element, name: str, findings: Findings) -> Inertial | None:
    element = only_child(link, "inertial", findings)
    if element is None:
        return Inertial(1.0, inertia=np.eye(3))  # the default of SDF
    tags = frozenset({"pose", "mass", "inertia"})
    check_known(element, frozenset({"auto"}), tags, frozenset({"fluid_added_mass", "density"}), findings)
    pose = read_pose(element, f"the inertia of link '{name}'", findings)
    part = only_child(element, "mass", findings)
    text = "1" if part is None else part.text
    line = element.sourceline if part is None else part.sourceline
    mass = read_numbers(text, 1, f"mass of link '{name}'", findings, line, LARGEST_MASS)
    inertia = only_child(element, "inertia", findings)
    entries: list[float] = []
    for key in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"):
        entry = None if inertia is None else only_child(inertia, key, findings)
        text = ("1" if key[1] == key[2] else "0") if entry is None else entry.text
        line = element.sourceline if entry is None else entry.sourceline
        entries += read_numbers(text, 1, f"{key} of link '{name}'", findings, line, LARGEST_INERTIA) or ()
    if mass is None or len(entries) != 6:
        return None
    return Inertial.of(mass[0], pose[:3, 3], entries, pose[:3, :3])


def _shapes(link: Element, tag: str, name: str, path: Path, findings: Findings) -> list[Shape]:
    shapes = [_shape(element, tag, name, path, findings) for element in children(link, tag)]
    return [shape for shape in shapes if shape is not None]


def _shape(element: Element, tag: str, link: str, path: Path, findings: Findings) -> Shape | None:
    what = f"<{tag}> of link '{link}'"
    geometry = only_child(element, "geometry", findings)
    kinds = [] if geometry is None else list(children(geometry))
    if len(kinds) != 1:
        findings.error(f"{what} with {len(kinds)} shapes", "one shape in <geometry>", "", element.sourceline)
        return None
    kind, line = str(kinds[0].tag), kinds[0].sourceline
    pose = read_pose(element, what, findings)
    mesh = None
    if kind == "mesh":
        scale = only_child(kinds[0], "scale", findings)
        size = read_numbers(
            "1 1 1" if scale is None else scale.text, 3, f"scale of {what}", findings, kinds[0].sourceline
        )
        mesh = _mesh(kinds[0], what, path, findings)
        if mesh is None:
            return None
    elif kind in _SHAPES:
        key, count = _SHAPES[kind]
        size = read_numbers(
            text_of(only_child(kinds[0], key, findings)), count, f"{key} of {what}", findings, kinds[0].sourceline
        )
        if size is not None and kind in ("cylinder", "capsule"):
            length = text_of(only_child(kinds[0], "length", findings))
            along = read_numbers(length, 1, f"length of {what}", findings, line)
            size = None if along is None else (size[0], along[0])
    else:
        findings.warn(f"{kind} in {what} is not drawn", f"mesh, {', '.join(_SHAPES)}", "", line)
        return None
    if size is None:
        return None
    return Shape(kind, size, pose, _colour(element, findings), mesh, str(element.get("name") or ""))


def _mesh(element: Element, what: str, path: Path, findings: Findings) -> Path | None:
    name = text_of(only_child(element, "uri", findings))
    remedy = "add the folder that holds it to GAZEBO_MODEL_PATH"
    return read_mesh(name, f"mesh '{name}' in {what}", remedy, path, findings, element.sourceline)


def _colour(element: Element, findings: Findings) -> tuple[float, float, float, float] | None:
    material = only_child(element, "material", findings)
    if material is None:
        return None
    for tag in ("diffuse", "ambient"):
        part = only_child(material, tag, findings)
        if part is not None:
            values = [float(word) for word in text_of(part).split() if word.replace(".", "", 1).isdigit()]
            if len(values) in (3, 4) and all(0.0 <= value <= 1.0 for value in values):
                return values[0], values[1], values[2], values[3] if len(values) == 4 else 1.0
    return None
