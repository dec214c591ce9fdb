"""The `<link>` of a URDF: inertia, visual and collision shapes, materials."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path

from cutjoint.arrays import Array
from cutjoint.description.files import read_mesh
from cutjoint.description.model import IDENTITY, Inertial, Link, Place, Shape
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, read_numbers
from cutjoint.description.transforms import from_rotation, placement, rotation_from_quaternion
from cutjoint.description.xml import Element, check_known, children, name_of, only_child, short
from cutjoint.findings import Findings, Harmless, listing, nearest

Colour = tuple[float, float, float, float]
Colours = Mapping[str, Colour | None]

_NONE: frozenset[str] = frozenset()
_LINK_TAGS = frozenset({"inertial", "visual", "collision"})
_LINK_IGNORED = frozenset({"sensor", "contact", "self_collision_checking", "collision_checking", "verbose", "gazebo"})
_SHAPES: Mapping[str, frozenset[str]] = {
    "box": frozenset({"size"}),
    "cylinder": frozenset({"radius", "length"}),
    "capsule": frozenset({"radius", "length"}),
    "sphere": frozenset({"radius"}),
    "mesh": frozenset({"filename", "scale"}),
}
_DRAKE_SHAPES = frozenset({"drake:capsule", "drake:ellipsoid"})
_DRAKE = frozenset(
    {"drake:proximity_properties", "drake:accepting_renderer", "drake:illustration_properties"}
    | {"drake:perception_properties"}
)
"""What Drake adds to shapes, for contact and looks."""
_CONTACT = frozenset(
    {"drake:compliant_hydroelastic", "drake:rigid_hydroelastic", "drake:soft_hydroelastic", "drake:mu_dynamic"}
    | {"drake:hunt_crossley_dissipation", "drake:hydroelastic_modulus", "drake:hydroelastic_margin", "drake:mu_static"}
    | {"drake:mesh_resolution_hint", "drake:point_contact_stiffness", "drake:relaxation_time"}
)
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")


def read_origin(element: Element | None, findings: Findings, tag: str = "origin") -> Array:
    """The placement (4, 4) of the `<origin>` in `element`; the identity where there is none."""
    origin = None if element is None else only_child(element, tag, findings)
    if element is None or origin is None:
        return IDENTITY
    check_known(origin, frozenset({"xyz", "rpy", "quat_xyzw"}), _NONE, _NONE, findings)
    return origin_of(origin, f"<{tag}> of <{element.tag}>", findings)


def origin_of(origin: Element, what: str, findings: Findings) -> Array:
    """The placement (4, 4) of the attributes `xyz` and `rpy` (or `quat_xyzw`, of URDF 1.1) of an element."""
    line = origin.sourceline
    xyz = read_numbers(origin.get("xyz", "0 0 0"), 3, f"{what}: xyz", findings, line) or (0.0, 0.0, 0.0)
    if origin.get("quat_xyzw") is None:
        rpy = read_numbers(origin.get("rpy", "0 0 0"), 3, f"{what}: rpy", findings, line)
        return placement(xyz, rpy or (0.0, 0.0, 0.0))
    if origin.get("rpy") is not None:
        findings.error(f"{what}: rpy and quat_xyzw", "one of them", "keep one", line)
    x, y, z, w = read_numbers(origin.get("quat_xyzw"), 4, f"{what}: quat_xyzw", findings, line) or (0.0, 0.0, 0.0, 1.0)
    length = math.hypot(x, y, z, w)
    if not length > 1e-9:
        findings.error(f"{what}: quat_xyzw is 0", "a unit quaternion", "", line)
        return placement(xyz)
    if abs(length - 1.0) > 1e-3:
        findings.warn(f"{what}: quat_xyzw has length {length:.6g}", "1", "it was normalised", line)
    return from_rotation(rotation_from_quaternion((w, x, y, z)), xyz)


def read_colours(root: Element, findings: Findings) -> dict[str, Colour | None]:
    """The named materials of a robot, those defined inside visuals included."""
    colours: dict[str, Colour | None] = {}
    for element in children(root, "material"):
        _material(element, findings)
    for element in root.iter("material"):
        colour = _colour(element, Findings())
        name = str(element.get("name") or "")
        defined = element.getparent() is root or len(element) > 0
        if name and defined and (colour is not None or name not in colours):
            colours[name] = colour
    return colours


def _material(element: Element, findings: Findings) -> None:
    check_known(element, frozenset({"name"}), frozenset({"color", "texture"}), _NONE, findings)
    for texture in children(element, "texture"):
        check_known(texture, frozenset({"filename"}), _NONE, _NONE, findings)
    _colour(element, findings)


def _colour(element: Element, findings: Findings) -> Colour | None:
    color = only_child(element, "color", findings)
    if color is None:
        return None
    check_known(color, frozenset({"rgba"}), _NONE, _NONE, findings)
    values = read_numbers(color.get("rgba"), 4, "<color>: rgba", findings, color.sourceline)
    if values is None:
        return None
    if not all(0.0 <= value <= 1.0 for value in values):
        findings.error(f"<color>: rgba is {values}", "four numbers from 0 to 1", "", color.sourceline)
        return None
    return values[0], values[1], values[2], values[3]


def read_link(element: Element, path: Path, colours: Colours, findings: Findings) -> Link | None:
    """One `<link>`, or None where it has no name."""
    check_known(element, frozenset({"name", "type"}), _LINK_TAGS, _LINK_IGNORED, findings)
    name = name_of(element, findings)
    if name is None:
        return None
    harmless = Harmless(findings)
    visuals = [_shape(one, name, path, colours, harmless) for one in children(element, "visual")]
    collisions = [_shape(one, name, path, colours, harmless) for one in children(element, "collision")]
    return Link(
        name=name,
        inertial=_inertial(element, name, findings),
        visuals=tuple(shape for shape in visuals if shape is not None),
        collisions=tuple(shape for shape in collisions if shape is not None),
        place=Place(findings.file, element.sourceline),
    )


def _inertial(link: Element, name: str, findings: Findings) -> Inertial | None:
    element = only_child(link, "inertial", findings)
    if element is None:
        return None
    check_known(element, _NONE, frozenset({"origin", "mass", "inertia"}), _NONE, findings)
    origin = read_origin(element, findings)
    line = element.sourceline
    parts = {}
    for tag in ("mass", "inertia"):
        parts[tag] = only_child(element, tag, findings)
        if parts[tag] is None:
            findings.error(f"<inertial> of link '{name}' without <{tag}>", f"<{tag} .../>", "", line)
    mass = None
    if parts["mass"] is not None:
        check_known(parts["mass"], frozenset({"value"}), _NONE, _NONE, findings)
        at = parts["mass"].sourceline
        mass = read_numbers(parts["mass"].get("value"), 1, f"mass of link '{name}'", findings, at, LARGEST_MASS)
    entries: list[float] = []
    if parts["inertia"] is not None:
        check_known(parts["inertia"], frozenset(_INERTIA), _NONE, _NONE, findings)
        at = parts["inertia"].sourceline
        for key in _INERTIA:
            what = f"{key} of link '{name}'"
            entry = read_numbers(parts["inertia"].get(key), 1, what, findings, at, LARGEST_INERTIA)
            entries += entry or ()
    if mass is None or len(entries) != len(_INERTIA):
        return None
    return Inertial.of(mass[0], origin[:3, 3], entries, origin[:3, :3])


def _shape(element: Element, link: str, path: Path, colours: Colours, findings: Findings) -> Shape | None:
    tags, ignored = (
        frozenset({"origin", "geometry", "material"}),
        frozenset({"verbose", "convex", "surface", "max_contacts"}),
    )
    for own in (one for one in children(element) if short(str(one.tag)) in _DRAKE):
        check_known(own, frozenset({"name", "enabled"}), _CONTACT, _NONE, findings)
        for one in children(own):
            check_known(one, frozenset({"value"}), _NONE, _NONE, findings)
    check_known(element, frozenset({"name", "group"}), tags, ignored | _DRAKE, findings)
    origin = read_origin(element, findings)
    geometry = only_child(element, "geometry", findings)
    what = f"<{element.tag}> of link '{link}'"
    if geometry is None:
        findings.error(f"{what} without <geometry>", "<geometry> with one shape", "", element.sourceline)
        return None
    check_known(geometry, frozenset({"name"}), frozenset(_SHAPES), _DRAKE_SHAPES, findings)
    shapes = [one for one in children(geometry) if one.tag in _SHAPES or short(str(one.tag)) in _DRAKE_SHAPES]
    if len(shapes) != 1:
        expected = f"exactly one of {', '.join(sorted(_SHAPES))}"
        findings.error(f"{what} with {len(shapes)} shapes", expected, "", geometry.sourceline)
        return None
    kind = short(str(shapes[0].tag)).removeprefix("drake:")
    if kind not in _SHAPES:
        findings.warn(f"{kind} in {what} is not shown", f"one of {', '.join(_SHAPES)}", "", shapes[0].sourceline)
        return None
    check_known(shapes[0], _SHAPES[kind], _NONE, frozenset({"drake:declare_convex", "verbose"}), findings)
    size = _size(shapes[0], kind, what, findings)
    mesh = _mesh(shapes[0], what, path, findings) if kind == "mesh" else None
    if size is None or (kind == "mesh" and mesh is None):
        return None
    colour = _shape_colour(element, colours, what, findings)
    return Shape(kind, size, origin, colour, mesh, str(element.get("name") or ""))


def _size(shape: Element, kind: str, what: str, findings: Findings) -> tuple[float, ...] | None:
    line = shape.sourceline
    if kind == "box":
        size = read_numbers(shape.get("size"), 3, f"box in {what}: size", findings, line)
    elif kind == "mesh":
        size = read_numbers(shape.get("scale", "1 1 1"), 3, f"mesh in {what}: scale", findings, line)
        if size is not None and 0.0 in size:
            findings.error(f"mesh in {what}: scale {size}", "three numbers other than 0", "", line)
        return size
    else:
        keys = ("radius",) if kind == "sphere" else ("radius", "length")
        values = [read_numbers(shape.get(key), 1, f"{kind} in {what}: {key}", findings, line) for key in keys]
        size = tuple(value[0] for value in values if value is not None)
        size = size if len(size) == len(keys) else None
    if size is not None and min(size) < 0.0:
        findings.error(f"{kind} in {what}: size {size}", "no negative length [m]", "", line)
        return None
    return size


def _mesh(shape: Element, what: str, path: Path, findings: Findings) -> Path | None:
    name = str(shape.get("filename") or "").strip()
    if not name:
        findings.error(f"mesh in {what} without filename", '<mesh filename="..."/>', "", shape.sourceline)
        return None
    remedy = "put the file there, or remove the shape"
    if "://" in name and not name.startswith("file://"):
        package = name.split("://", 1)[1].split("/", 1)[0]
        remedy = f"add the folder that holds '{package}' to ROS_PACKAGE_PATH"
    return read_mesh(name, f"mesh '{name}' in {what}", remedy, path, findings, shape.sourceline)


def _shape_colour(element: Element, colours: Colours, what: str, findings: Findings) -> Colour | None:
    material = only_child(element, "material", findings)
    if material is None:
        return None
    _material(material, findings)
    colour = _colour(material, Findings())
    name = str(material.get("name") or "")
    if colour is None and name:
        if name not in colours:
            found = f"{what} names the unknown material '{name}'"
            findings.warn(found, listing(colours), nearest(name, colours), material.sourceline)
        colour = colours.get(name)
    return colour
