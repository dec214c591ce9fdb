"""The bodies of an MJCF file: nested frames, joints inside bodies, geoms, sites, inertias.

A body moves by its joints, which act one after the other at their own points of it: each but the last carries a
massless link.  Two hinges called X and X/2 at one point with perpendicular axes are one universal joint; two slides and
a hinge called X, X/2 and X/3 a planar one; slides along x, y, z and a ball called X to X/4 a floating one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.findings import Findings
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.mjcf.geom import Geom, Mesh, inertia_of_geoms, read_geom
from cutjoint.description.formats.mjcf.joint import read_free_joint, read_joint
from cutjoint.description.formats.mjcf.pose import AngleUnits, Defaults, read_placement
from cutjoint.description.formats.mjcf.types import MADE_OF
from cutjoint.description.model import IDENTITY, Frame, Inertial, Joint, JointPhysics, JointType, Limits, Link, Place
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS, read_numbers
from cutjoint.description.transforms import inverse
from cutjoint.description.xml import Element, children, only_child


def merged(joints: list[Joint]) -> list[Joint]:
    """X and X/2 as one universal joint, up to X/3 a planar one, up to X/4 a floating one; else as they are.

    Joints with ranges of their own, or with dampers, springs and the like that differ, stay as they are; what slides
    and turns has nothing but dampers.
    """
    if not joints or joints[0].placement[:3, 3].any():
        return joints
    first, others = joints[0], joints[1:]
    named = [one.name for one in others] == [f"{first.name}/{number}" for number in range(2, len(joints) + 1)]
    if not named or any(not np.array_equal(one.placement, first.placement) for one in others):
        return joints
    if any(one.physics != first.physics or one.limits != Limits() for one in joints):
        return joints
    kinds = tuple(kind for one in joints for kind in MADE_OF[one.type])
    together = next((kind for kind, made in MADE_OF.items() if made == kinds and len(made) == len(joints) > 1), None)
    slides, hinges = ([one.axis for one in joints if MADE_OF[one.type] == (kind,)] for kind in ("slide", "hinge"))
    askew = len(hinges) == 2 and abs(hinges[0] @ hinges[1]) >= 1e-9
    rolls = bool(slides and first.physics != JointPhysics(damping=first.physics.damping))
    if together is None or askew or rolls or (len(slides) == 3 and not np.array_equal(slides, np.eye(3))):
        return joints
    axis, axis2 = (*hinges, *(first.axis, first.axis2)[len(hinges) :])
    return [replace(first, type=together, axis=axis, axis2=axis2, limits=Limits())]


WORLD = "world"
OWN = "cutjoint:"
"""Names of what cutjoint's writer adds to close loops; the cuts themselves are among the extras."""


@dataclass(frozen=True)
class Compiler:
    """What `<compiler>` says."""

    units: AngleUnits = field(default_factory=AngleUnits)
    inertia_from_geoms: str = "auto"
    meshes: str = ""


class Bodies:
    """Everything under `<worldbody>`: the tree, the world placements at zero, the sites, the joints' names."""

    def __init__(
        self, root: Element, compiler: Compiler, meshes: Mapping[str, Mesh | None], path: Path, findings: Findings
    ) -> None:
        self.compiler, self.meshes, self.findings = compiler, meshes, findings
        self.defaults = Defaults(root, findings)
        self.tree = OpenTree(str(root.get("model") or path.stem))
        self.world: dict[str, Array] = {WORLD: IDENTITY}
        self.sites: dict[str, Frame] = {}
        self.joint_names: list[str] = []
        self.references: dict[str, float] = {}
        self._unnamed = 0
        bases = list(children(root, "worldbody"))
        shapes = [geom for base in bases for geom in self._geoms(base, WORLD, "")]
        self._link(WORLD, None, shapes, Place(findings.file, bases[0].sourceline if bases else None))
        if not bases or not any(len(list(children(base, "body"))) for base in bases):
            findings.error("no body under <worldbody>", "<worldbody><body>...", "", root.sourceline)
        stack = [(body, WORLD, "") for base in reversed(bases) for body in reversed(list(children(base, "body")))]
        for base in bases:
            self._sites(base, WORLD, "")
        while stack:
            element, parent, childclass = stack.pop()
            if str(element.get("name") or "").startswith(OWN):
                continue
            name, inner = self._body(element, parent, childclass)
            stack += [(body, name, inner) for body in reversed(list(children(element, "body")))]

    def name_fixed_joints(self, names: Mapping[str, str]) -> None:
        """Give fixed joints the names that the extras hold for them, by the link that they carry."""
        for number, joint in enumerate(self.tree.joints):
            if not joint.type.moves and joint.child in names:
                self.tree.joints[number] = replace(joint, name=names[joint.child])

    def drop_empty_world(self, used: Collection[str]) -> None:
        """Leave the world out where it is nothing but the place on which one body stands fixed."""
        world = next(link for link in self.tree.links if link.name == WORLD)
        below = [joint for joint in self.tree.joints if joint.parent == WORLD]
        if world.visuals or world.collisions or WORLD in used or len(below) != 1:
            return
        if not below[0].type.moves and np.array_equal(below[0].placement, IDENTITY):
            self.tree.links.remove(world)
            self.tree.joints.remove(below[0])

    def _body(self, element: Element, parent: str, childclass: str) -> tuple[str, str]:
        childclass = str(element.get("childclass") or childclass)
        name = str(element.get("name") or "").strip()
        if not name:
            self._unnamed += 1
            name = f"body_{self._unnamed}"
        what = f"body '{name}'"
        own = {str(key): str(value) for key, value in element.attrib.items()}
        local = read_placement(element, own, self.compiler.units, what, self.findings)
        place = Place(self.findings.file, element.sourceline)
        joints = self._joints(element, name, childclass)
        self.world[name] = readonly(self.world.get(parent, IDENTITY) @ local)
        geoms = self._geoms(element, name, childclass)
        self._link(name, self._inertial(element, name, geoms), geoms, place)
        self._sites(element, name, childclass)
        self._chain(name, parent, local, joints, place)
        return name, childclass

    def _joints(self, element: Element, body: str, childclass: str) -> list[Joint]:
        found: list[Joint] = []
        for child in children(element):
            get = self.defaults.attributes(child, childclass) if child.tag == "joint" else {}
            if child.tag == "freejoint" or get.get("type") == "free":
                found.append(read_free_joint(child, get, body, self.findings))
            elif child.tag == "joint":
                one = read_joint(child, get, self.compiler.units, body, len(found), self.findings)
                if one is not None:
                    found.append(one[0])
                    self.references[one[0].name] = one[1]
        self.joint_names += [joint.name for joint in found]
        if len(found) > 1 and any(joint.type is JointType.FLOATING for joint in found):
            problem = f"body '{body}' has a free joint and others"
            self.findings.error(problem, "a free joint alone", "", element.sourceline)
        return merged(found)

    def _chain(self, name: str, parent: str, local: Array, joints: list[Joint], place: Place) -> None:
        """The joints of a body from its parent on, each at its own point."""
        if not joints:
            self.tree.joints.append(Joint(f"{name}_fixed", JointType.FIXED, parent, name, local, place=place))
            return
        link, reach = parent, local  # `reach`: the body's frame at zero, seen from `link`
        for number, one in enumerate(joints):
            centred = not one.placement[:3, 3].any()
            moves_body = number == len(joints) - 1 and centred
            child = name if moves_body else f"{name}_at_{one.name}"
            placed = reach if centred else reach @ one.placement
            self.tree.joints.append(replace(one, parent=link, child=child, placement=placed))
            if not moves_body:
                self.tree.links.append(Link(child, place=place))
            link, reach = child, inverse(one.placement)
        if link != name:
            self.tree.joints.append(Joint(f"{link}_fixed", JointType.FIXED, link, name, reach, place=place))

    def _geoms(self, element: Element, body: str, childclass: str) -> list[Geom]:
        geoms = []
        for child in children(element, "geom"):
            get = self.defaults.attributes(child, childclass)
            geoms.append(read_geom(child, get, self.meshes, self.compiler.units, body, self.findings))
        return [geom for geom in geoms if geom is not None]

    def _sites(self, element: Element, body: str, childclass: str) -> None:
        for child in children(element, "site"):
            get = self.defaults.attributes(child, childclass)
            if "name" in get and not get["name"].startswith(OWN):
                at = read_placement(child, get, self.compiler.units, f"site '{get['name']}'", self.findings)
                self.sites[get["name"]] = Frame(body, at)

    def _link(self, name: str, inertial: Inertial | None, geoms: list[Geom], place: Place) -> None:
        drawn = [geom for geom in geoms if geom.shape.kind != "ellipsoid"]
        visuals = tuple(geom.shape for geom in drawn if geom.visual)
        collisions = tuple(geom.shape for geom in drawn if not geom.visual)
        self.tree.links.append(Link(name, inertial, visuals, collisions, place))

    def _inertial(self, body: Element, name: str, geoms: list[Geom]) -> Inertial | None:
        element = only_child(body, "inertial", self.findings)
        mode = self.compiler.inertia_from_geoms
        if mode == "true" or (mode == "auto" and element is None):
            return inertia_of_geoms(geoms, name, self.findings, body.sourceline)
        if element is None:
            return None
        get = {str(key): str(value) for key, value in element.attrib.items()}
        what, line = f"the inertia of body '{name}'", element.sourceline
        at = read_placement(element, get, self.compiler.units, what, self.findings)
        mass = read_numbers(get.get("mass"), 1, f"mass of body '{name}'", self.findings, line, LARGEST_MASS)
        key = "fullinertia" if "fullinertia" in get else "diaginertia"
        values = read_numbers(
            get.get(key), 6 if key == "fullinertia" else 3, f"{key} of body '{name}'", self.findings, line,
            LARGEST_INERTIA,
        )  # fmt: skip
        if mass is None or values is None:
            return None
        return Inertial.of(mass[0], at[:3, 3], values, at[:3, :3] if key == "diaginertia" else np.eye(3))
