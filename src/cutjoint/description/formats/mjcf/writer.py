"""A description as MJCF for MuJoCo.

Cut joints become equalities between sites, so the file needs no closed posture: fixed a `weld`, spherical a `connect`,
revolute two `connect`s along the axis, a distance a held tendon.  MuJoCo has no equality for others (universal,
prismatic): they get a body with next to no mass that has the joint, welded to the other link.  What MJCF cannot say
(homes as given, variants, names of fixed joints, such cuts, stops, what cuts do by themselves) goes into a custom text
that the reader understands.  A cut with a bushing is in that text alone: to MuJoCo it is open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.formats.common.exact import number, relative, serialised, words
from cutjoint.description.formats.common.names import check_names
from cutjoint.description.formats.common.physics import leftover
from cutjoint.description.formats.common.toml.text import JointKeys, toml_text
from cutjoint.description.formats.common.unsaid import EQUAL, MESHES, drawn, triangle
from cutjoint.description.formats.mjcf.body import WORLD
from cutjoint.description.formats.mjcf.cut import at_zero, write_cut, write_distance, write_place, write_site
from cutjoint.description.formats.mjcf.geom import plain_name
from cutjoint.description.formats.mjcf.joint import UNLIMITED
from cutjoint.description.formats.mjcf.ties import tendon_lengths, tied, write_couplings, write_tendons
from cutjoint.description.formats.mjcf.told_apart import Told, told_apart
from cutjoint.description.formats.mjcf.types import OWN, parts
from cutjoint.description.model import Inertial, Joint, JointPhysics, JointType, Link, RobotDescription, Shape
from cutjoint.description.xml import Element
from cutjoint.errors import InputError
from cutjoint.mechanism.physics import NO_PHYSICS

FLOOR = 1e-12
"""kg and kg m2 below which MuJoCo is told to lift a moving body's mass and moments: it refuses zeros."""
ALMOST_0 = 1e-300
"""The end of a range from 0 to 0."""
LIFT = 6e-15
"""Relative to the largest moment, above what `EQUAL` leaves and MuJoCo's own rounding."""

Meshes = Mapping[tuple[Path, tuple[float, ...]], str]
"""(file, scale) -> name of the asset."""


def files(robot: RobotDescription, path: Path) -> Mapping[Path, bytes]:
    """One MJCF file.

    Raises:
        InputError: MJCF has no word for a part of the robot.
    """
    check_names(robot, "MJCF", taken=OWN)
    told = told_apart(robot)
    root = etree.Element("mujoco", model=robot.name)
    etree.SubElement(
        root, "compiler", angle="radian", inertiafromgeom="false", autolimits="true", balanceinertia="true",
        boundmass=number(FLOOR), boundinertia=number(FLOOR),
    )  # fmt: skip
    etree.SubElement(root, "option", gravity=words(robot.gravity))
    custom = etree.SubElement(root, "custom")
    etree.SubElement(custom, "text", name="cutjoint", data=_extras(robot, told))
    meshes = _assets(root, robot, path)
    worldbody = etree.SubElement(root, "worldbody")
    bodies = _bodies(worldbody, robot, meshes)
    equality = etree.SubElement(root, "equality")
    for cut in robot.cuts:
        write_cut(cut, bodies, equality, cut.name not in told.cuts)
    tendon = etree.SubElement(root, "tendon")
    tendons = write_tendons(robot, tendon)
    for name, element in tendons.items():
        _range(element, robot.joint(name))
        _physics(element, robot.joint(name), "springlength")
    write_couplings(robot, not told.couplings, equality, tendon)
    for cut in robot.cuts:
        if cut.type.has_length and cut.bushing is None:
            write_distance(cut, at_zero(robot), equality, tendon)
    if not len(tendon):
        root.remove(tendon)
    actuator = etree.SubElement(root, "actuator")
    for name in robot.actuators:
        target = {"tendon": tendons[name].get("name")} if name in tendons else {"joint": name}
        motor = etree.SubElement(actuator, "motor", target, name=name)
        if _bounded(robot.joint(name), robot):
            bound = robot.joint(name).limits.effort or 0.0
            motor.set("forcerange", words((-bound, bound)))
    if robot.tool is not None:
        write_site(bodies[robot.tool.link], f"{OWN}tool", robot.tool.placement)
    return {path: serialised(root)}


def _extras(robot: RobotDescription, told: Told) -> str:
    cuts = [cut for cut in robot.cuts if cut.name in told.cuts]
    fixed = {joint.child: joint.name for joint in robot.joints if not joint.type.moves}
    couplings = tied(robot) if told.couplings else ()
    return toml_text(robot, urdf=None, cuts=cuts, couplings=couplings, joints=_joint_keys(robot), fixed=fixed)


def _bounded(joint: Joint, robot: RobotDescription) -> bool:
    """Whether its `<motor>` says how hard a joint is driven at most; a range from 0 to 0 is none."""
    return joint.name in robot.actuators and bool(joint.limits.effort)


def _joint_keys(robot: RobotDescription) -> JointKeys:
    """[joint.NAME]: limits and physics that MJCF lacks, hinges without range."""
    tables: dict[str, dict[str, object]] = {}
    tendons = tendon_lengths(robot)
    for joint in robot.joints:
        keys: dict[str, object] = {}
        ranged = joint.limits.bounded
        if joint.type.turns and joint.type.limited != ranged:
            keys["type"] = joint.type.value
        if joint.limits.velocity is not None:
            keys["velocity"] = joint.limits.velocity
        if joint.limits.effort is not None and not _bounded(joint, robot):
            keys["effort"] = joint.limits.effort
        keys |= leftover(joint.physics, said(joint.physics))
        if joint.name in tendons and joint.physics.rest == -1.0:  # which says there that the file says nothing
            keys["rest"] = -1.0
        if keys:
            tables[joint.name] = keys
    return tables


def _assets(root: Element, robot: RobotDescription, path: Path) -> dict[tuple[Path, tuple[float, ...]], str]:
    """A `<mesh>` for each file and scale that is used, of the kinds that MuJoCo reads."""
    names: dict[tuple[Path, tuple[float, ...]], str] = {}
    asset = etree.SubElement(root, "asset")
    for link in robot.links:
        for shape in (*link.visuals, *link.collisions):
            if shape.mesh is None or not drawn(shape, MESHES) or (shape.mesh, shape.size) in names:
                continue
            name = f"mesh_{len(names) + 1}"
            names[shape.mesh, shape.size] = name
            given = {"file": relative(shape.mesh, path), "scale": words(shape.size), "inertia": "shell"}
            etree.SubElement(asset, "mesh", given, name=name)  # any other inertia needs a volume
    if not names:
        root.remove(asset)
    return names


def _bodies(worldbody: Element, robot: RobotDescription, meshes: Meshes) -> dict[str, Element]:
    """A `<body>` for each link, nested as the tree is.  A massless root called world is the world itself."""
    below: dict[str, list[Joint]] = {}
    tendons = tendon_lengths(robot)
    for joint in (one for one in robot.joints if one.name not in tendons):
        below.setdefault(joint.parent, []).append(joint)
    base = robot.link(robot.root)
    if any(link.name == WORLD and (link is not base or link.inertial is not None) for link in robot.links):
        raise InputError(f"MJCF calls the ground '{WORLD}', so no body of a robot may have that name; rename the link")
    if base.name == WORLD and base.inertial is None:
        root = worldbody
    else:
        root = etree.SubElement(worldbody, "body", name=base.name)
    bodies = {base.name: root}
    used = Counter[str]()
    _fill(root, base, meshes, used)
    stack = [base.name]
    while stack:
        parent = stack.pop()
        for joint in below.get(parent, []):
            body = etree.SubElement(bodies[parent], "body", name=joint.child)
            write_place(body, joint.placement)
            _joints(body, joint)
            _fill(body, robot.link(joint.child), meshes, used)
            bodies[joint.child] = body
            stack.append(joint.child)
    return bodies


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
    _range(element, joint)
    _physics(element, joint)


def _range(element: Element, joint: Joint) -> None:
    """A range; to MuJoCo one from 0 to 0 is none, and one from x to x an error, so that its end is next to x."""
    limits = joint.limits
    if joint.type.single and limits.bounded:
        lower = -UNLIMITED if limits.lower is None else limits.lower
        upper = UNLIMITED if limits.upper is None else limits.upper
        element.set("range", words((lower, max(upper, float(np.nextafter(lower, np.inf)) if lower else ALMOST_0))))


def _physics(element: Element, joint: Joint, rest: str = "springref") -> None:
    """The attributes of what a joint does by itself.  A `springref` counts from 0, since no `ref` is written."""
    physics = said(joint.physics)
    values = {"damping": physics.damping, "frictionloss": physics.friction, "stiffness": physics.stiffness}
    values |= {rest: physics.rest or 0.0, "armature": physics.rotor}
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


def _fill(body: Element, link: Link, meshes: Meshes, used: Counter[str]) -> None:
    if link.inertial is not None:
        _inertial(body, link.inertial)
    if link.gravity_compensation and body.tag == "body":
        body.set("gravcomp", number(link.gravity_compensation))
    for shapes, visual in ((link.visuals, True), (link.collisions, False)):
        for shape in shapes:
            _geom(body, shape, visual, meshes, used)


def _inertial(body: Element, inertial: Inertial) -> None:
    given = {"pos": words(inertial.com), "mass": number(inertial.mass), "fullinertia": words(_lifted(inertial).entries)}
    etree.SubElement(body, "inertial", given)


def _lifted(inertial: Inertial) -> Inertial:
    """A rod or plate, one of whose moments is the sum of the others but for rounding, with moments a few units of
    rounding larger: where that moment is the larger one, MuJoCo takes the mean of all three."""
    excess, largest = triangle(inertial)
    if abs(excess) > EQUAL * largest:
        return inertial
    return replace(inertial, inertia=inertial.inertia + LIFT * largest * np.eye(3))


def _geom(body: Element, shape: Shape, visual: bool, meshes: Meshes, used: Counter[str]) -> None:
    """A shape under a name of its own; nothing of one that MuJoCo cannot draw."""
    if not drawn(shape, MESHES):
        return
    element = etree.SubElement(body, "geom", type=shape.kind, mass="0")
    if shape.name:
        used[shape.name] += 1
        alone = used[shape.name] == 1 and plain_name(shape.name) == shape.name
        element.set("name", shape.name if alone else f"{shape.name}#{used[shape.name]}")
    write_place(element, shape.placement)
    if shape.mesh is not None:
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
