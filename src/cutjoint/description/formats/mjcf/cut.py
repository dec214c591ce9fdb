"""Cut joints as MJCF: equalities between sites, a held tendon, or a body of their own that has the joint."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from lxml import etree

from cutjoint.arrays import Array
from cutjoint.description.formats.common.exact import words
from cutjoint.description.formats.mjcf.types import EQUALITIES, OWN, carrier_parts, has_carrier
from cutjoint.description.model import CutJoint, RobotDescription
from cutjoint.description.transforms import quaternion_from_rotation
from cutjoint.description.xml import Element

APART = 0.1
"""m between the two points that hold the axis of a revolute cut."""
SAID = {kind: tag for tag, kind in EQUALITIES.items()}
"""Types of cuts that one equality says -> its tag."""


def write_place(element: Element, placement: Array) -> None:
    """Where an element is, in the body that it is in."""
    if placement[:3, 3].any():
        element.set("pos", words(placement[:3, 3]))
    if not np.array_equal(placement[:3, :3], np.eye(3)):
        element.set("quat", words(quaternion_from_rotation(placement[:3, :3])))


def write_site(body: Element, name: str, placement: Array) -> None:
    """A site of a body."""
    write_place(etree.SubElement(body, "site", name=name), placement)


def write_cut(cut: CutJoint, bodies: Mapping[str, Element], equality: Element, alone: bool) -> None:
    """The sites, bodies and equalities of a cut, but for what `write_distance` writes; nothing of a bushing.

    Unless it stands `alone`, the custom text says it too, and the equality has a name that its reader passes over.
    """
    a, b = (bodies[frame.link] for frame in (cut.a, cut.b))
    if cut.bushing is not None:
        return
    if cut.type in SAID or cut.type.has_length:
        sites = f"{cut.name}/a", f"{cut.name}/b"
        write_site(a, sites[0], cut.a.placement)
        write_site(b, sites[1], cut.b.placement)
    if cut.type.has_length:
        return
    if cut.type in SAID:
        name = cut.name if alone else OWN + cut.name
        etree.SubElement(equality, SAID[cut.type], name=name, site1=sites[0], site2=sites[1])
    elif not has_carrier(cut):
        for number_of, along in ((1, -0.5 * APART), (2, 0.5 * APART)):
            sites = f"{OWN}{cut.name}/a{number_of}", f"{OWN}{cut.name}/b{number_of}"
            for body, frame, name in ((a, cut.a, sites[0]), (b, cut.b, sites[1])):
                point = np.array(frame.placement)
                point[:3, 3] += along * point[:3, 2]
                write_site(body, name, point)
            etree.SubElement(equality, "connect", name=f"{OWN}{cut.name}/{number_of}", site1=sites[0], site2=sites[1])
    else:
        _carrier(cut, a, b, equality)


def _carrier(cut: CutJoint, a: Element, b: Element, equality: Element) -> None:
    """A body with next to no mass on link `a` that moves as the cut lets it, welded to link `b`."""
    name = f"{OWN}{cut.name}"
    body = etree.SubElement(a, "body", name=name)
    write_place(body, cut.a.placement)
    for count, (kind, axis) in enumerate(carrier_parts(cut), 1):
        joint = etree.SubElement(body, "joint", name=name if count == 1 else f"{name}/{count}", type=kind)
        if axis is not None:
            joint.set("axis", " ".join(f"{value:g}" for value in axis))
    etree.SubElement(body, "inertial", pos="0 0 0", mass="1e-6", diaginertia="1e-9 1e-9 1e-9")
    sites = f"{name}/a", f"{name}/b"
    write_site(body, sites[0], np.eye(4))
    write_site(b, sites[1], cut.b.placement)
    etree.SubElement(equality, "weld", name=f"{name}/1", site1=sites[0], site2=sites[1])


def write_distance(cut: CutJoint, placed: Mapping[str, Array], equality: Element, tendon: Element) -> None:
    """A distance between two sites, NAME/a and NAME/b."""
    ends = [(placed[frame.link] @ frame.placement)[:3, 3] for frame in (cut.a, cut.b)]
    name = f"{OWN}{cut.name}"
    element = etree.SubElement(tendon, "spatial", name=name)
    for site in (f"{cut.name}/a", f"{cut.name}/b"):
        etree.SubElement(element, "site", site=site)
    more = cut.length - float(np.linalg.norm(ends[1] - ends[0]))
    etree.SubElement(equality, "tendon", name=name, tendon1=name, polycoef=words((more, 0.0, 0.0, 0.0, 0.0)))


def at_zero(robot: RobotDescription) -> dict[str, Array]:
    """Placements of all links where all coordinates are 0."""
    placed = {robot.root: np.eye(4)}
    left = list(robot.joints)
    while left:
        known = [joint for joint in left if joint.parent in placed]
        for joint in known:
            placed[joint.child] = placed[joint.parent] @ joint.placement
        left = [joint for joint in left if joint.child not in placed]
    return placed
