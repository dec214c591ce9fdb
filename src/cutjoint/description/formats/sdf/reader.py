"""SDF models (http://sdformat.org/spec), whose links may have several parents: the joints left over close loops.

One model, at the top or in a world.  Without `<static>` and without a joint to `world` the base floats.  Joint types:
fixed, revolute, continuous, prismatic, ball, universal.  `<include>`, nested models, screws and gearboxes are not
supported and are reported.
"""

from __future__ import annotations

from pathlib import Path

from cutjoint.arrays import Array, readonly
from cutjoint.description.findings import Findings, listing, nearest
from cutjoint.description.formats.common.extras import Extras, described
from cutjoint.description.formats.common.graph import PlacedLink, span
from cutjoint.description.formats.sdf.dynamics import read_limits, read_physics
from cutjoint.description.formats.sdf.link import Poses, read_body, text_of
from cutjoint.description.model import (
    IDENTITY,
    Coupling,
    Joint,
    JointType,
    Limits,
    Link,
    Place,
    RobotDescription,
)
from cutjoint.description.numbers import parse_number, read_numbers, unit_axis
from cutjoint.description.xml import Element, check_known, children, name_of, only_child, read_xml

WORLD = "world"
TYPES = {kind.sdf: kind for kind in JointType if kind.sdf}

_NONE: frozenset[str] = frozenset()
_MODEL_TAGS = frozenset({"link", "joint", "frame", "pose", "static", "include", "model"})
_MODEL_IGNORED = frozenset({"plugin", "self_collide", "allow_auto_disable", "enable_wind", "gripper", "sensor"})
_JOINT_TAGS = frozenset({"parent", "child", "pose", "axis", "axis2"})
_JOINT_IGNORED = frozenset({"physics", "sensor", "plugin", "initial_position", "gripper"})


def read(path: Path, findings: Findings) -> RobotDescription | None:
    """An SDF file with one model."""
    root = read_xml(path, findings, "SDF")
    model = None if root is None else _model(root, findings)
    if root is None or model is None:
        return None
    version = parse_number(str(root.get("version") or "1.6")) or 1.6
    check_known(model, frozenset({"name", "canonical_link", "placement_frame"}), _MODEL_TAGS, _MODEL_IGNORED, findings)
    for tag in ("include", "model"):
        for element in children(model, tag):
            found = f"<{tag}> inside a model"
            findings.error(found, "one flat model", "flatten it first: gz sdf -p model.sdf", element.sourceline)
    poses = Poses(model, findings)
    bodies = [body for element in children(model, "link") if (body := read_body(element, path, poses, findings))]
    edges, couplings = _joints(model, {body.link.name for body in bodies}, poses, version, findings)
    if not bodies:
        findings.error("a model without links", "at least one <link>", "", model.sourceline)
        return None
    static = text_of(only_child(model, "static", findings)).lower() in ("1", "true")
    root_link = bodies[0].link.name
    if not static:
        bodies.insert(0, PlacedLink(Link(WORLD), IDENTITY))
        edges = [*edges, *_floating(bodies[1:], edges)]
        root_link = WORLD
    name = str(model.get("name") or path.stem)
    tree, cuts = span(name, bodies, edges, root_link, findings)
    tree.couplings.extend(couplings)
    gravity = _gravity(root, findings)
    return described(tree, cuts, Extras(gravity=readonly(gravity)), path, findings)


def _model(root: Element, findings: Findings) -> Element | None:
    if root.tag != "sdf":
        findings.error(f"the root element is <{root.tag}>", "<sdf>", "is this another format?", root.sourceline)
        return None
    models = [*children(root, "model")]
    for world in children(root, "world"):
        models += children(world, "model")
    if len(models) != 1:
        found = f"{len(models)} models: {listing(str(one.get('name')) for one in models)}"
        findings.error(found, "one model", "keep the robot only", root.sourceline)
        return None
    return models[0]


def _gravity(root: Element, findings: Findings) -> tuple[float, ...]:
    for world in children(root, "world"):
        element = only_child(world, "gravity", findings)
        if element is not None:
            values = read_numbers(element.text, 3, "<gravity>", findings, element.sourceline)
            return values or (0.0, 0.0, -9.81)
    return 0.0, 0.0, -9.81


def _floating(bodies: list[PlacedLink], edges: list[Joint]) -> list[Joint]:
    """A floating joint from the world for the first link of each part that no joint ties to the world."""
    near: dict[str, set[str]] = {}
    for edge in edges:
        near.setdefault(edge.parent, set()).add(edge.child)
        near.setdefault(edge.child, set()).add(edge.parent)
    reached: set[str] = set()

    def reach(start: str) -> None:
        stack = [start]
        while stack:
            name = stack.pop()
            if name not in reached:
                reached.add(name)
                stack += near.get(name, set())

    reach(WORLD)
    children_of_joints = {edge.child for edge in edges}
    first = sorted(bodies, key=lambda body: body.link.name in children_of_joints)
    extra: list[Joint] = []
    for body in first:
        name = body.link.name
        if name not in reached:
            reach(name)
            joint = "root_joint" if not extra else f"{name}_root_joint"
            extra.append(Joint(joint, JointType.FLOATING, WORLD, name, body.world, place=body.link.place))
    return extra


def _joints(
    model: Element, links: set[str], poses: Poses, version: float, findings: Findings
) -> tuple[list[Joint], list[Coupling]]:
    edges, couplings = [], []
    for element in children(model, "joint"):
        check_known(element, frozenset({"name", "type"}), _JOINT_TAGS, _JOINT_IGNORED, findings)
        name = name_of(element, findings)
        kind = str(element.get("type") or "").strip()
        if kind not in TYPES:
            findings.unknown(f"type '{kind}' of joint '{name}'", kind, TYPES, element.sourceline)
        ends = [_end(element, tag, name or "?", links, findings) for tag in ("parent", "child")]
        if name is None or kind not in TYPES or ends[0] is None or ends[1] is None:
            continue
        edge = _edge(element, name, TYPES[kind], (ends[0], ends[1]), poses, version, findings)
        edges.append(edge)
        coupling = _mimic(element, name, findings)
        if coupling is not None:
            couplings.append(coupling)
    return edges, couplings


def _end(element: Element, tag: str, name: str, links: set[str], findings: Findings) -> str | None:
    end = only_child(element, tag, findings)
    link = text_of(end)
    if link == WORLD and tag == "parent":
        return link
    if link not in links:
        found = f"{tag} '{link}' of joint '{name}' is not a link" if link else f"joint '{name}' without {tag}"
        line = element.sourceline if end is None else end.sourceline
        findings.error(found, "the name of a link", nearest(link, links), line)
        return None
    return link


def _edge(
    element: Element,
    name: str,
    kind: JointType,
    ends: tuple[str, str],
    poses: Poses,
    version: float,
    findings: Findings,
) -> Joint:
    world = poses.world(name, "joint", element.sourceline)
    axis = only_child(element, "axis", findings)
    axis2 = only_child(element, "axis2", findings)
    first = readonly([1.0, 0.0, 0.0])
    second = readonly([0.0, 1.0, 0.0])
    limits = Limits()
    if axis is not None:
        first = _axis(axis, name, world, poses, version, findings)
        if kind.single:
            limits = read_limits(axis, name, kind, findings)
    elif kind.axes:
        findings.error(f"joint '{name}' without <axis>", "<axis><xyz>...</xyz></axis>", "", element.sourceline)
    if axis2 is not None:
        second = _axis(axis2, name, world, poses, version, findings)
    elif kind.axes == 2:
        findings.error(f"{kind.value} joint '{name}' without <axis2>", "two axes", "", element.sourceline)
    place = Place(findings.file, element.sourceline)
    physics = read_physics(element, name, kind, findings)
    return Joint(name, kind, ends[0], ends[1], world, first, second, limits, physics, place)


def _axis(axis: Element, name: str, world: Array, poses: Poses, version: float, findings: Findings) -> Array:
    xyz = only_child(axis, "xyz", findings)
    line = axis.sourceline if xyz is None else xyz.sourceline
    values = read_numbers("0 0 1" if xyz is None else xyz.text, 3, f"axis of joint '{name}'", findings, line)
    unit = unit_axis(values or (0.0, 0.0, 1.0), name, findings, line)
    in_model = text_of(only_child(axis, "use_parent_model_frame", findings)).lower() in ("1", "true")
    frame = "" if xyz is None else str(xyz.get("expressed_in") or "")
    if frame:
        return readonly(world[:3, :3].T @ poses.world(frame, None, line)[:3, :3] @ unit)
    return readonly(world[:3, :3].T @ unit) if in_model or version < 1.5 else unit


def _mimic(element: Element, name: str, findings: Findings) -> Coupling | None:
    axis = only_child(element, "axis", findings)
    mimic = None if axis is None else only_child(axis, "mimic", findings)
    if mimic is None:
        return None
    values = {}
    for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0")):
        part = only_child(mimic, key, findings)
        text = default if part is None else part.text
        number = read_numbers(text, 1, f"{key} of the mimic of joint '{name}'", findings, mimic.sourceline)
        values[key] = number[0] if number else 0.0
    offset = values["offset"] - values["multiplier"] * values["reference"]
    driver = str(mimic.get("joint") or "")
    return Coupling.geared(
        f"{name}_mimic", name, driver, values["multiplier"], offset, Place(findings.file, mimic.sourceline)
    )
