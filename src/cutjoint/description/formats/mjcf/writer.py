"""A description as MJCF for MuJoCo.

Cut joints become equalities between sites, so the file needs no closed posture: fixed a `weld`, spherical a `connect`,
revolute two `connect`s along the axis, a distance a held tendon.  MuJoCo has no equality for others (universal,
prismatic): they get a body with next to no mass that has the joint, welded to the other link.  What MJCF cannot say
(homes as given, variants, names of fixed joints, such cuts, stops, what cuts do by themselves) goes into a custom text
that the reader understands.  A cut with a bushing is in that text alone: to MuJoCo it is open.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.cuts import Kind
from cutjoint.description.formats.common.exact import number, relative, serialised, words
from cutjoint.description.formats.common.physics import leftover
from cutjoint.description.formats.common.toml.text import JointKeys, toml_text
from cutjoint.description.formats.mjcf.body import OWN, WORLD
from cutjoint.description.formats.mjcf.geom import plain_name
from cutjoint.description.formats.mjcf.ties import at_zero, plain_couplings, write_couplings, write_distance
from cutjoint.description.formats.mjcf.types import EQUALITIES, carrier_parts, parts
from cutjoint.description.model import CutJoint, Inertial, Joint, JointPhysics, JointType, Link, RobotDescription, Shape
from cutjoint.description.transforms import quaternion_from_rotation
from cutjoint.description.xml import Element
from cutjoint.errors import InputError
from cutjoint.mechanism.physics import NO_PHYSICS

FLOOR = 1e-12
"""kg and kg m2 below which MuJoCo is told to lift a moving body's mass and moments: it refuses zeros."""
APART = 0.1
"""m between the two points that hold the axis of a revolute cut."""
MESHES = (".stl", ".obj", ".msh")

Meshes = Mapping[tuple[Path, tuple[float, ...]], str]
"""(file, scale) -> name of the asset."""

_SAID = {kind: tag for tag, kind in EQUALITIES.items()}


def files(robot: RobotDescription, path: Path) -> Mapping[Path, bytes]:
    """One MJCF file."""
    root = etree.Element("mujoco", model=robot.name)
    etree.SubElement(
        root, "compiler", angle="radian", inertiafromgeom="false", autolimits="true", balanceinertia="true",
        boundmass=number(FLOOR), boundinertia=number(FLOOR),
    )  # fmt: skip
    etree.SubElement(root, "option", gravity=words(robot.gravity))
    custom = etree.SubElement(root, "custom")
    etree.SubElement(custom, "text", name="cutjoint", data=_extras(robot))
    meshes = _assets(root, robot, path)
    worldbody = etree.SubElement(root, "worldbody")
    bodies = _bodies(worldbody, robot, meshes)
    equality = etree.SubElement(root, "equality")
    for cut in robot.cuts:
        _cut(cut, bodies, equality)
    tendon = etree.SubElement(root, "tendon")
    write_couplings(robot, equality, tendon)
    for cut in robot.cuts:
        if cut.type.has_length and cut.bushing is None:
            write_distance(cut, at_zero(robot), equality, tendon)
    if not len(tendon):
        root.remove(tendon)
    actuator = etree.SubElement(root, "actuator")
    for name in robot.actuators:
        motor = etree.SubElement(actuator, "motor", name=name, joint=name)
        if _bounded(robot.joint(name), robot):
            bound = robot.joint(name).limits.effort or 0.0
            motor.set("forcerange", words((-bound, bound)))
    if robot.tool is not None:
        _site(bodies[robot.tool.link], f"{OWN}tool", robot.tool.placement)
    return {path: serialised(root)}


def _is_equality(cut: CutJoint) -> bool:
    """Whether one `<equality>` says all of a cut."""
    return cut.type in _SAID and cut.bushing is None and cut.physics == NO_PHYSICS


def _extras(robot: RobotDescription) -> str:
    cuts = [cut for cut in robot.cuts if not _is_equality(cut)]
    fixed = {joint.child: joint.name for joint in robot.joints if not joint.type.moves}
    couplings = () if plain_couplings(robot) else robot.couplings
    return toml_text(robot, urdf=None, cuts=cuts, couplings=couplings, joints=_joint_keys(robot), fixed=fixed)


def _bounded(joint: Joint, robot: RobotDescription) -> bool:
    """Whether its `<motor>` says how hard a joint is driven at most; a range from 0 to 0 is none."""
    return joint.name in robot.actuators and bool(joint.limits.effort)


def _joint_keys(robot: RobotDescription) -> JointKeys:
    """[joint.NAME]: limits and physics that MJCF lacks, hinges without range."""
    tables: dict[str, dict[str, object]] = {}
    for joint in robot.joints:
        keys: dict[str, object] = {}
        ranged = joint.limits.lower is not None or joint.limits.upper is not None
        if joint.type.turns and joint.type.limited != ranged:
            keys["type"] = joint.type.value
        if joint.limits.velocity is not None:
            keys["velocity"] = joint.limits.velocity
        if joint.limits.effort is not None and not _bounded(joint, robot):
            keys["effort"] = joint.limits.effort
        keys |= leftover(joint.physics, said(joint.physics))
        if keys:
            tables[joint.name] = keys
    return tables


def _assets(root: Element, robot: RobotDescription, path: Path) -> dict[tuple[Path, tuple[float, ...]], str]:
    """A `<mesh>` for each file and scale that is used, of the kinds that MuJoCo reads."""
    names: dict[tuple[Path, tuple[float, ...]], str] = {}
    asset = etree.SubElement(root, "asset")
    for link in robot.links:
        for shape in (*link.visuals, *link.collisions):
            if shape.mesh is None or shape.mesh.suffix.lower() not in MESHES or (shape.mesh, shape.size) in names:
                continue
            name = f"mesh_{len(names) + 1}"
            names[shape.mesh, shape.size] = name
            etree.SubElement(asset, "mesh", name=name, file=relative(shape.mesh, path), scale=words(shape.size))
    if not names:
        root.remove(asset)
    return names


def _bodies(worldbody: Element, robot: RobotDescription, meshes: Meshes) -> dict[str, Element]:
    """A `<body>` for each link, nested as the tree is.  A massless root called world is the world itself."""
    below: dict[str, list[Joint]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint)
    base = robot.link(robot.root)
    if any(link.name == WORLD and (link is not base or link.inertial is not None) for link in robot.links):
        raise InputError(f"MJCF calls the ground '{WORLD}', so no body of a robot may have that name; rename the link")
    if base.name == WORLD and base.inertial is None:
        root = worldbody
    else:
        root = etree.SubElement(worldbody, "body", name=base.name)
    bodies = {base.name: root}
    _fill(root, base, meshes)
    stack = [base.name]
    while stack:
        parent = stack.pop()
        for joint in below.get(parent, []):
            body = etree.SubElement(bodies[parent], "body", name=joint.child)
            _place(body, joint.placement)
            _joints(body, joint)
            _fill(body, robot.link(joint.child), meshes)
            bodies[joint.child] = body
            stack.append(joint.child)
    return bodies


def _place(element: Element, placement: Array) -> None:
    if placement[:3, 3].any():
        element.set("pos", words(placement[:3, 3]))
    if not np.array_equal(placement[:3, :3], np.eye(3)):
        element.set("quat", words(quaternion_from_rotation(placement[:3, :3])))


def _site(body: Element, name: str, placement: Array) -> None:
    _place(etree.SubElement(body, "site", name=name), placement)


def _joints(body: Element, joint: Joint) -> None:
    """The joints in MuJoCo that together make one of the tree; free ones are on the world only."""
    if joint.type is JointType.FLOATING and body.getparent().tag == "worldbody":
        if joint.physics == NO_PHYSICS:
            etree.SubElement(body, "freejoint", name=joint.name)
        else:
            _physics(etree.SubElement(body, "joint", name=joint.name, type="free"), joint)
        return
    for count, (kind, axis) in enumerate(parts(joint), 1):
        _joint(body, joint.name if count == 1 else f"{joint.name}/{count}", kind, axis, joint)


def _joint(body: Element, name: str, kind: str, axis: Array | None, joint: Joint) -> None:
    element = etree.SubElement(body, "joint", name=name, type=kind)
    if axis is not None:
        element.set("axis", words(axis))
    limits = joint.limits
    if joint.type.single and (limits.lower, limits.upper) != (None, None):
        lower = -1e10 if limits.lower is None else limits.lower
        upper = 1e10 if limits.upper is None else limits.upper
        element.set("range", words((lower, upper)))
    _physics(element, joint)


def _physics(element: Element, joint: Joint) -> None:
    """The attributes of what a joint does by itself.  A `springref` counts from 0, since no `ref` is written."""
    physics = said(joint.physics)
    values = {"damping": physics.damping, "frictionloss": physics.friction, "stiffness": physics.stiffness}
    values |= {"springref": physics.rest or 0.0, "armature": physics.rotor}
    for key, value in values.items():
        if value:
            element.set(key, number(value))


def said(physics: JointPhysics) -> JointPhysics:
    """What of a joint's physics the attributes of a `<joint>` say, as they are read."""
    spring = physics.stiffness != 0.0
    return JointPhysics(
        damping=physics.damping,
        friction=physics.friction,
        stiffness=physics.stiffness,
        rest=(physics.rest or 0.0) if spring else None,
        rotor=physics.armature,
    )


def _fill(body: Element, link: Link, meshes: Meshes) -> None:
    if link.inertial is not None:
        _inertial(body, link.inertial)
    if link.gravity_compensation and body.tag == "body":
        body.set("gravcomp", number(link.gravity_compensation))
    for shapes, visual in ((link.visuals, True), (link.collisions, False)):
        for shape in shapes:
            _geom(body, shape, visual, meshes)


def _inertial(body: Element, inertial: Inertial) -> None:
    given = {"pos": words(inertial.com), "mass": number(inertial.mass), "fullinertia": words(inertial.entries)}
    etree.SubElement(body, "inertial", given)


def _geom(body: Element, shape: Shape, visual: bool, meshes: Meshes) -> None:
    element = etree.Element("geom", type=shape.kind, mass="0")
    if shape.name:
        count = sum(1 for other in body.getroottree().iter("geom") if plain_name(other.get("name", "")) == shape.name)
        element.set("name", f"{shape.name}#{count + 1}" if count else shape.name)
    _place(element, shape.placement)
    if shape.kind == "mesh":
        if shape.mesh is None or (shape.mesh, shape.size) not in meshes:
            return
        element.set("mesh", meshes[shape.mesh, shape.size])
    elif shape.kind == "box":
        element.set("size", words([0.5 * value for value in shape.size]))
    elif shape.kind == "sphere":
        element.set("size", words(shape.size))
    else:
        element.set("size", words((shape.size[0], 0.5 * shape.size[1])))
    if shape.colour is not None:
        element.set("rgba", words(shape.colour))
    if visual:
        element.set("contype", "0")
        element.set("conaffinity", "0")
        element.set("group", "2")
    body.append(element)


def _cut(cut: CutJoint, bodies: Mapping[str, Element], equality: Element) -> None:
    a, b = (bodies[frame.link] for frame in (cut.a, cut.b))
    if cut.bushing is not None:
        return
    if cut.type in _SAID or cut.type.has_length:
        sites = f"{cut.name}/a", f"{cut.name}/b"
        _site(a, sites[0], cut.a.placement)
        _site(b, sites[1], cut.b.placement)
    if cut.type.has_length:
        return
    if cut.type in _SAID:
        etree.SubElement(equality, _SAID[cut.type], name=cut.name, site1=sites[0], site2=sites[1])
    elif cut.type.kinds == (Kind.POINT, Kind.HINGE):
        for number_of, along in ((1, -0.5 * APART), (2, 0.5 * APART)):
            sites = f"{OWN}{cut.name}/a{number_of}", f"{OWN}{cut.name}/b{number_of}"
            for body, frame, name in ((a, cut.a, sites[0]), (b, cut.b, sites[1])):
                point = np.array(frame.placement)
                point[:3, 3] += along * point[:3, 2]
                _site(body, name, point)
            etree.SubElement(equality, "connect", name=f"{cut.name}/{number_of}", site1=sites[0], site2=sites[1])
    else:
        _carrier(cut, a, b, equality)


def _carrier(cut: CutJoint, a: Element, b: Element, equality: Element) -> None:
    """A body with next to no mass on link `a` that moves as the cut lets it, welded to link `b`."""
    name = f"{OWN}{cut.name}"
    body = etree.SubElement(a, "body", name=name)
    _place(body, cut.a.placement)
    for count, (kind, axis) in enumerate(carrier_parts(cut), 1):
        joint = etree.SubElement(body, "joint", name=name if count == 1 else f"{name}/{count}", type=kind)
        if axis is not None:
            joint.set("axis", " ".join(f"{value:g}" for value in axis))
    etree.SubElement(body, "inertial", pos="0 0 0", mass="1e-6", diaginertia="1e-9 1e-9 1e-9")
    sites = f"{name}/a", f"{name}/b"
    _site(body, sites[0], np.eye(4))
    _site(b, sites[1], cut.b.placement)
    etree.SubElement(equality, "weld", name=f"{cut.name}/1", site1=sites[0], site2=sites[1])
