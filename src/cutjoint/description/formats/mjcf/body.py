"""The bodies of an MJCF file: nested frames, joints inside bodies, geoms, sites, inertias.

A body moves by its joints, which act one after the other at their own points of it: each but the last carries a
massless link.  Two hinges called X and X/2 at one point with perpendicular axes are one universal joint; two slides and
a hinge called X, X/2 and X/3 a planar one; slides along x, y, z and a ball called X to X/4 a floating one.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.common.extras import OpenTree
from cutjoint.description.formats.mjcf.compiled import BodyRow, JointRow, Model
from cutjoint.description.formats.mjcf.geom import shape_of
from cutjoint.description.formats.mjcf.joint import joint_of, motion_back
from cutjoint.description.formats.mjcf.source import MjcfText
from cutjoint.description.formats.mjcf.types import MADE_OF, OWN, parts
from cutjoint.description.model import IDENTITY, Frame, Inertial, Joint, JointPhysics, JointType, Limits, Link, Place
from cutjoint.description.numbers import LARGEST_INERTIA, LARGEST_MASS
from cutjoint.description.transforms import from_rotation, inverse, rotation_from_quaternion
from cutjoint.findings import Findings, check_range, nearest


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
    if together is None or askew or rolls:
        return joints
    axis, axis2 = (*hinges, *(first.axis, first.axis2)[len(hinges) :])
    whole = replace(first, type=together, axis=axis, axis2=axis2, limits=Limits())
    usual = [direction for kind, direction in parts(whole) if kind == "slide" and direction is not None]
    return [whole] if np.allclose(slides, usual, rtol=0.0, atol=1e-12) else joints


WORLD = "world"


class Bodies:
    """The bodies of a compiled model as a tree, and the names that its joints, bodies and sites have there.

    Attributes:
        tree: links and joints; the world is the root.
        names: of bodies, by their index.
        joints: the name of the joint that each joint of MuJoCo is (part of), by its index; empty for the writer's own.
        addresses: where the coordinates of a joint of the tree begin in a qpos.
        references: their coordinates where the bodies are as they are written.
        tendons: joints that stand for lengths of tendons, with what each joint adds to them.
    """

    def __init__(self, model: Model, source: MjcfText, own: bool, findings: Findings) -> None:
        self.model, self.source, self.own, self.findings = model, source, own, findings
        self.tree = OpenTree(str(source.root.get("model") or source.path.stem))
        self.names: list[str] = []
        self.joints: list[str] = []
        self.addresses: dict[str, int] = {}
        self._meshes = {mesh.name: mesh for mesh in model.meshes}
        self._unnamed = 0
        self.references: dict[str, float] = {}
        self.tendons: dict[str, dict[str, float]] = {}
        for row in model.bodies:
            self._body(row)

    def frame(self, site: int) -> Frame:
        """The frame of a site."""
        row = self.model.sites[site]
        return Frame(self.names[row.body], _pose(row.position, row.quaternion))

    def name_fixed_joints(self, names: Mapping[str, str]) -> None:
        """Give fixed joints the names that the extras hold for them, by the link that they carry."""
        for number, joint in enumerate(self.tree.joints):
            if not joint.type.moves and joint.child in names:
                self.tree.joints[number] = replace(joint, name=names[joint.child])
        known = {joint.child for joint in self.tree.joints if not joint.type.moves}
        for link in names.keys() - known:
            found = f"[fixed] of the text 'cutjoint' names '{link}'"
            self.findings.error(found, "a link on a fixed joint", nearest(link, known))

    def drop_empty_world(self, used: Collection[str]) -> None:
        """Leave the world out where it is nothing but the place on which one body stands fixed."""
        world = next(link for link in self.tree.links if link.name == WORLD)
        below = [joint for joint in self.tree.joints if joint.parent == WORLD]
        if world.visuals or world.collisions or WORLD in used or len(below) != 1:
            return
        if not below[0].type.moves and np.array_equal(below[0].placement, IDENTITY):
            self.tree.links.remove(world)
            self.tree.joints.remove(below[0])

    def _body(self, row: BodyRow) -> None:
        name = WORLD if not self.names else row.name.strip()
        if not name:
            self._unnamed += 1
            name = f"body_{self._unnamed}"
        self.names.append(name)
        if name.startswith(OWN):
            self.joints += ["" for _ in row.joints]
            return
        place = self.source.place(row.line, "body") or Place(self.findings.file)
        local = _pose(row.position, row.quaternion)
        check_range(row.position, f"pos of body '{name}'", self.findings, place)
        if row.mocap:
            self.findings.warn(f"mocap body '{name}' stands still", "", "", place)
        if name == WORLD:
            first = next(self.source.all("worldbody"), None)
            self._link(row, name, place if first is None else first[1])
            return
        joints = self._joints(row, name, place)
        self._link(row, name, place)
        self._chain(name, self.names[row.parent], local, joints, row.joints, place)

    def _joints(self, row: BodyRow, body: str, at: Place) -> list[Joint]:
        found: list[Joint] = []
        for number, one in enumerate(row.joints):
            other = "_free" if one.kind == "free" else "_joint" if number == 0 else f"_joint_{number + 1}"
            name = one.name or f"{body}{other}"
            place = self.source.place(one.line, "joint", "freejoint") or at
            found.append(joint_of(one, name, body, place, self.findings))
            self.references[name] = one.ref
        together = found if any(one.ref for one in row.joints) else merged(found)
        whole = len(together) < len(found)
        for joint, one in zip(found, row.joints, strict=True):
            self.joints.append(found[0].name if whole else joint.name)
            self.addresses.setdefault(self.joints[-1], one.address)
        return together

    def _chain(
        self, name: str, parent: str, local: Array, joints: list[Joint], rows: Sequence[JointRow], place: Place
    ) -> None:
        """The joints of a body from its parent on, each at its own point."""
        if not joints:
            self.tree.joints.append(Joint(f"{name}_fixed", JointType.FIXED, parent, name, local, place=place))
            return
        link, reach = parent, local  # `reach`: the body's frame as it is written, seen from `link`
        for number, (one, row) in enumerate(zip(joints, rows, strict=False)):
            centred = not one.placement[:3, 3].any()
            moves_body = number == len(joints) - 1 and centred
            child = name if moves_body else f"{name}_at_{one.name}"
            placed = reach if centred else reach @ one.placement
            if row.ref != 0.0:
                placed = placed @ motion_back(row)
            if row.kind == "free" and not self.own:
                placed = IDENTITY  # the coordinates are the body's own in the world
            self.tree.joints.append(replace(one, parent=link, child=child, placement=placed))
            if not moves_body:
                self.tree.links.append(Link(child, place=place))
            link, reach = child, inverse(one.placement)
        if link != name:
            self.tree.joints.append(Joint(f"{link}_fixed", JointType.FIXED, link, name, reach, place=place))

    def _link(self, row: BodyRow, name: str, place: Place) -> None:
        shapes = [(geom, shape_of(geom, self._meshes, self.source)) for geom in row.geoms]
        visuals = tuple(shape for geom, shape in shapes if shape is not None and geom.visual)
        collisions = tuple(shape for geom, shape in shapes if shape is not None and not geom.visual)
        inertial = self._inertial(row, name, place)
        self.tree.links.append(Link(name, inertial, visuals, collisions, place, 0.0 if name == WORLD else row.gravcomp))

    def _inertial(self, row: BodyRow, name: str, place: Place) -> Inertial | None:
        if row.inertia is None or name == WORLD:
            return None
        mass, com, entries = row.inertia
        fine = check_range((mass,), f"mass of body '{name}'", self.findings, place, LARGEST_MASS)
        fine &= check_range(com, f"centre of mass of body '{name}'", self.findings, place)
        fine &= check_range(entries, f"inertia of body '{name}'", self.findings, place, LARGEST_INERTIA)
        return Inertial.of(mass, com, entries) if fine else None


def _pose(position: Sequence[float], quaternion: Sequence[float]) -> Array:
    """A placement (4, 4) of MuJoCo's numbers."""
    return readonly(from_rotation(rotation_from_quaternion(quaternion), position))
