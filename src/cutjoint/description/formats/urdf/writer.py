"""A description as URDF: the open tree alone, or with the cuts as the proposed `<constraint>` elements.

Joint types that URDF lacks (spherical, universal) are written as floating and given back by the keys that go with them,
as are rotors, gears, stops, bushings and compensated weights.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.formats.common.exact import number, relative, serialised, words
from cutjoint.description.formats.common.names import check_names
from cutjoint.description.formats.common.physics import leftover
from cutjoint.description.formats.common.toml.text import JointKeys, toml_text
from cutjoint.description.formats.urdf.constraint import TYPES as CONSTRAINTS
from cutjoint.description.formats.urdf.dynamics import said, write_dynamics
from cutjoint.description.model import Coupling, CutJoint, Inertial, Joint, JointType, Link, RobotDescription, Shape
from cutjoint.description.transforms import rpy_from_rotation
from cutjoint.description.xml import Element
from cutjoint.mechanism.physics import NO_PHYSICS

_NAMES = {kind: name for name, kind in CONSTRAINTS.items()}


def files(robot: RobotDescription, path: Path) -> Mapping[Path, bytes]:
    """One URDF with `<constraint>` elements, and the rest of the robot in a `<cutjoint>` element."""
    root = robot_element(robot, path)
    for cut in robot.cuts:
        if not _is_constraint(cut):
            continue
        element = etree.SubElement(root, "constraint", name=cut.name, type=_NAMES[cut.type])
        for side, frame in (("parent", cut.a), ("child", cut.b)):
            etree.SubElement(element, side, link=frame.link)
            _origin(element, frame.placement, f"{side}_origin")
        if cut.type.axes == "z":
            etree.SubElement(element, "parent_axis", xyz="0 0 1")
        elif cut.type.axes == "xy":
            etree.SubElement(element, "parent_axis", xyz="1 0 0")
            etree.SubElement(element, "child_axis", xyz="0 1 0")
        write_dynamics(element, cut.physics)
    rest = etree.SubElement(root, "cutjoint")
    cuts = [cut for cut in robot.cuts if not _is_constraint(cut)]
    couplings, joints = couplings_without_mimic(robot), foreign_joints(robot)
    keys = toml_text(robot, urdf=None, cuts=cuts, couplings=couplings, joints=joints, links=robot.links)
    rest.text = f"\n{keys}"
    return {path: serialised(root)}


def _is_constraint(cut: CutJoint) -> bool:
    """Whether `<constraint>` says a cut: its type, and that it holds rigidly."""
    return cut.type in _NAMES and cut.bushing is None


def robot_element(robot: RobotDescription, path: Path) -> Element:
    """The `<robot>` with links and joints; mesh files are named relative to `path`.

    Raises:
        InputError: a name cannot be written.
    """
    check_names(robot, "URDF", xacro=True)
    root = etree.Element("robot", name=robot.name)
    for link in robot.links:
        root.append(_link(link, path))
    mimics = {coupling.joint: coupling for coupling in robot.couplings if is_mimic(coupling)}
    for joint in robot.joints:
        root.append(_joint(joint, mimics.get(joint.name)))
    return root


def is_mimic(coupling: Coupling) -> bool:
    """Whether a coupling is one that `<mimic>` says, name included."""
    return coupling.name == f"{coupling.joint}_mimic" and coupling.gear is not None


def couplings_without_mimic(robot: RobotDescription) -> list[Coupling]:
    """The couplings that `<mimic>` cannot say with their names."""
    return [coupling for coupling in robot.couplings if not is_mimic(coupling)]


def foreign_joints(robot: RobotDescription) -> JointKeys:
    """[joint.NAME] for joints whose type or physics URDF lacks."""
    keys: dict[str, dict[str, object]] = {}
    for joint in robot.joints:
        own: dict[str, object] = {}
        if joint.type.urdf is None:
            own = {"type": joint.type.value, "axis": joint.axis, "axis2": joint.axis2}
        own |= leftover(joint.physics, said(joint.physics) if joint.type.urdf else NO_PHYSICS)
        if own:
            keys[joint.name] = own
    return keys


def _origin(parent: Element, placement: Array, tag: str = "origin") -> None:
    rotation = placement[:3, :3]
    if np.array_equal(placement, np.eye(4)):
        return
    origin = etree.SubElement(parent, tag, xyz=words(placement[:3, 3]))
    if not np.array_equal(rotation, np.eye(3)):
        origin.set("rpy", words(rpy_from_rotation(rotation)))


def _link(link: Link, path: Path) -> Element:
    element = etree.Element("link", name=link.name)
    if link.inertial is not None:
        _inertial(element, link.inertial)
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for number_of, shape in enumerate(shapes):
            _shape(element, tag, shape, f"{link.name}_{tag}_{number_of}", path)
    return element


def _inertial(link: Element, inertial: Inertial) -> None:
    element = etree.SubElement(link, "inertial")
    etree.SubElement(element, "origin", xyz=words(inertial.com))
    etree.SubElement(element, "mass", value=number(inertial.mass))
    tensor = inertial.inertia
    entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    etree.SubElement(element, "inertia", {key: number(tensor[at]) for key, at in entries.items()})


def _shape(link: Element, tag: str, shape: Shape, colour_name: str, path: Path) -> None:
    element = etree.SubElement(link, tag)
    if shape.name:
        element.set("name", shape.name)
    _origin(element, shape.placement)
    inner = etree.SubElement(etree.SubElement(element, "geometry"), shape.kind)
    if shape.kind == "box":
        inner.set("size", words(shape.size))
    elif shape.kind == "mesh":
        inner.set("filename", relative(shape.mesh, path))
        inner.set("scale", words(shape.size))
    else:
        for key, value in zip(("radius", "length"), shape.size, strict=False):
            inner.set(key, number(value))
    if shape.colour is not None:
        material = etree.SubElement(element, "material", name=f"{colour_name}_colour")
        etree.SubElement(material, "color", rgba=words(shape.colour))


def _joint(joint: Joint, mimic: Coupling | None) -> Element:
    kind = joint.type.urdf or JointType.FLOATING.urdf
    element = etree.Element("joint", name=joint.name, type=kind)
    etree.SubElement(element, "parent", link=joint.parent)
    etree.SubElement(element, "child", link=joint.child)
    _origin(element, joint.placement)
    if joint.type.urdf and joint.type.axes:
        etree.SubElement(element, "axis", xyz=words(joint.axis))
    _limits(element, joint)
    if joint.type.urdf:
        write_dynamics(element, joint.physics)
    if mimic is not None:
        driver, ratio = mimic.gear or ("", 1.0)
        etree.SubElement(element, "mimic", joint=driver, multiplier=number(ratio), offset=number(mimic.offset))
    return element


def _limits(element: Element, joint: Joint) -> None:
    limits = joint.limits
    values = {"velocity": limits.velocity, "effort": limits.effort}
    if joint.type.limited and limits.bounded:
        values["lower"], values["upper"] = limits.ends
    given = {key: number(value) for key, value in values.items() if value is not None}
    if given:
        etree.SubElement(element, "limit", given)
