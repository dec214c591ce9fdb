"""The `<visual>` and `<collision>` shapes of an SDF link.  None of their faults prevents computing."""

from __future__ import annotations

from collections.abc import Iterator

from cutjoint.arrays import Array, readonly
from cutjoint.description.files import read_mesh
from cutjoint.description.formats.sdf.frames import Frames
from cutjoint.description.formats.sdf.scope import Item
from cutjoint.description.formats.sdf.values import pose_of, text_of
from cutjoint.description.model import IDENTITY, Shape
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element, children, only_child
from cutjoint.findings import Findings, Harmless

_SIZES = {
    "box": (("size", 3),),
    "sphere": (("radius", 1),),
    "cylinder": (("radius", 1), ("length", 1)),
    "capsule": (("radius", 1), ("length", 1)),
}
"""Shape -> the elements that give its size, and how many numbers each has."""


def read_shapes(item: Item, tag: str, frames: Frames) -> Iterator[Shape]:
    """The shapes of a link that can be drawn; all that is wrong with them is a doubt."""
    findings = Harmless(item.scope.findings)
    for element in children(item.element, tag):
        shape = _shape(element, f"<{tag}> of link '{item.name}'", item, frames, findings)
        if shape is not None:
            yield shape


def _shape(element: Element, what: str, item: Item, frames: Frames, findings: Findings) -> Shape | None:
    geometry = only_child(element, "geometry", findings)
    kinds = [] if geometry is None else list(children(geometry))
    if len(kinds) != 1:
        findings.error(f"{what} with {len(kinds)} shapes", "one shape in <geometry>", "", element.sourceline)
        return None
    kind, line = str(kinds[0].tag), kinds[0].sourceline
    at = _placement(element, what, item, frames, findings)
    name, colour = str(element.get("name") or ""), _colour(element, what, findings)
    if kind == "mesh":
        scale = only_child(kinds[0], "scale", findings)
        size = read_numbers("1 1 1" if scale is None else scale.text, 3, f"scale of {what}", findings, line)
        uri = text_of(only_child(kinds[0], "uri", findings))
        remedy = "add the folder that holds it to GAZEBO_MODEL_PATH"
        mesh = read_mesh(uri, f"mesh '{uri}' in {what}", remedy, item.scope.file, findings, line)
        return None if size is None or mesh is None else Shape(kind, size, at, colour, mesh, name)
    if kind not in _SIZES:
        if kind != "empty":
            findings.warn(f"{kind} in {what} is not drawn", f"mesh, {', '.join(_SIZES)}", "", line)
        return None
    sizes = [
        read_numbers(text_of(only_child(kinds[0], tag, findings)), count, f"{tag} of {what}", findings, line)
        for tag, count in _SIZES[kind]
    ]
    kept = [size for size in sizes if size is not None]
    return Shape(kind, sum(kept, ()), at, colour, None, name) if len(kept) == len(sizes) else None


def _placement(element: Element, what: str, item: Item, frames: Frames, findings: Findings) -> Array:
    """In the frame of the link."""
    pose = only_child(element, "pose", findings)
    if pose is None:
        return IDENTITY
    own = pose_of(pose, what, findings)
    other = str(pose.get("relative_to") or pose.get("frame") or "").strip()
    if not other:
        return own
    base = frames.named(item.scope, other, f"{what} in the unknown frame", pose.sourceline)
    return readonly(inverse(frames.of(item)) @ base @ own)


def _colour(element: Element, what: str, findings: Findings) -> tuple[float, float, float, float] | None:
    material = only_child(element, "material", findings)
    for tag in () if material is None else ("diffuse", "ambient"):
        part = only_child(material, tag, findings)
        if part is not None:
            count = 3 if len(text_of(part).split()) == 3 else 4
            values = read_numbers(part.text, count, f"{tag} of {what}", findings, part.sourceline)
            if values is not None and not all(0.0 <= value <= 1.0 for value in values):
                findings.error(f"{tag} of {what} is {text_of(part)}", "numbers from 0 to 1", "", part.sourceline)
                return None
            return None if values is None else (values[0], values[1], values[2], values[3] if count == 4 else 1.0)
    return None
