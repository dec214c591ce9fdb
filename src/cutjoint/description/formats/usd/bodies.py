"""The rigid bodies of a USD stage: where they stand, what they weigh, and their shapes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cutjoint.arrays import Array, readonly
from cutjoint.description.formats.usd.facts import Facts, Prim
from cutjoint.description.formats.usd.frames import Stand, local, stand
from cutjoint.description.formats.usd.mass import Collider, along, inertial_of
from cutjoint.description.model import IDENTITY, Link, Place, Shape
from cutjoint.description.transforms import inverse, turned
from cutjoint.findings import Findings, Harmless, listing

API = "PhysicsRigidBodyAPI"
COLLISION = "PhysicsCollisionAPI"
WORLD = "world"
SOLIDS = ("Cube", "Sphere", "Cylinder", "Capsule")
PLACES = ("Xform", "Scope", "")
"""Prims without a shape: a collision schema on them does nothing."""
FORMS = (*SOLIDS, "Mesh", "Cone", "Plane", "Points", "BasisCurves", "NurbsPatch", "Capsule_1", "Cylinder_1")
"""Prims that are shapes."""


@dataclass(frozen=True, eq=False)
class Body:
    """A link of the robot, the placement (4, 4) of its frame in the world in metres as the file has it, and its prim;
    the world has none."""

    link: Link
    world: Array
    prim: Prim | None = None


@dataclass(frozen=True, eq=False)
class BodyTable:
    """All bodies, by the paths of their prims; the world under the empty path.

    `stands` is where every prim stands that has a place, bodies or not.
    """

    by_path: Mapping[str, Body]
    stands: Mapping[str, Stand]
    length: float

    def frame(self, target: str, position: tuple[float, ...], turn: tuple[float, ...]) -> tuple[Body, Array] | None:
        """The body that a joint's relationship means, and a frame (4, 4) on it that is given in the axes of the target;
        None where the target stands nowhere.  Without a target it is the world, and so it is for what is no body."""
        if not target:
            return self.by_path[""], local(position, turn, np.ones(3), self.length)
        if target not in self.stands:
            return None
        where = self.stands[target]
        body = self.by_path[owner(target, self.by_path)]
        at = where.world @ local(position, turn, where.scale, self.length)
        own = local(position, turn, where.scale, self.length)
        return body, own if body.prim is not None and body.prim.path == target else readonly(inverse(body.world) @ at)


def owner(path: str, bodies: Mapping[str, Body]) -> str:
    """The path of the nearest body at or above a prim, or the empty path of the world."""
    while path and path not in bodies:
        path = path.rpartition("/")[0]
    return path


def read_bodies(facts: Facts, findings: Findings) -> BodyTable:
    """The bodies that move, with the world before them.

    BodyTable that are switched off or led by an animation stand where the file has them, as parts of the world.
    """
    place = Place(findings.file)
    stands = {prim.path: one for prim in facts.prims if (one := stand(prim, facts.length)) is not None}
    prims = [prim for prim in facts.prims if prim.has(API) and _simulated(prim, findings)]
    names = unique_names([prim.path for prim in prims], (WORLD, "universe"))
    found = {"": Body(Link(WORLD, place=place), IDENTITY)}
    for prim in prims:
        where = stands.get(prim.path)
        if where is None or where.scale.min() < 0.0:
            what = "stands nowhere, or is mirrored, or scaled askew to its axes"
            findings.error(f"body <{prim.path}> {what}", "translations, turns, and scales along its own axes")
            where = Stand(IDENTITY, np.ones(3))
        found[prim.path] = Body(Link(names[prim.path], place=place), where.world, prim)
    _animated(facts, found, findings)
    shapes = _shapes(facts, found, stands, findings)
    for path, body in found.items():
        if body.prim is not None:
            visuals, collisions, colliders = shapes[path]
            inertial = inertial_of(body.prim, stands[path].scale if path in stands else np.ones(3), colliders, facts,
                                   findings)  # fmt: skip
            floats = float(body.prim.flag("physxRigidBody:disableGravity", False))
            link = Link(body.link.name, inertial, tuple(visuals), tuple(collisions), place, floats)
            found[path] = replace(body, link=link)
    return BodyTable(found, stands, facts.length)


def unique_names(paths: list[str], taken: tuple[str, ...] = ()) -> dict[str, str]:
    """Path -> the shortest end of it that no other has and that is not taken."""
    names: dict[str, str] = {}
    counts: dict[str, int] = {}
    ends = {path: [path.strip("/").split("/")[-size:] for size in range(1, path.count("/") + 1)] for path in paths}
    for path in paths:
        for end in ends[path]:
            counts["/".join(end)] = counts.get("/".join(end), 0) + 1
    for path in paths:
        fitting = [name for end in ends[path] if counts[name := "/".join(end)] == 1 and name not in taken]
        names[path] = fitting[0] if fitting else path
    return names


def _simulated(prim: Prim, findings: Findings) -> bool:
    for name in ("velocity", "linearVelocity", "angularVelocity"):
        if any(prim.vector(f"physics:{name}")):
            findings.warn(f"physics:{name} of body <{prim.path}> is not used", "a start at rest")
    if not prim.flag("physics:rigidBodyEnabled", True):
        findings.warn(f"body <{prim.path}> is switched off: it stands still", "physics:rigidBodyEnabled = true")
        return False
    if prim.flag("physics:kinematicEnabled", False):
        findings.warn(f"body <{prim.path}> is kinematic: it stands still", "physics:kinematicEnabled = false")
        return False
    return True


def _animated(facts: Facts, bodies: Mapping[str, Body], findings: Findings) -> None:
    """Note transformations that only an animation gives, and that a body hangs on."""
    for prim in facts.prims:
        moving = [name for name in prim.moving if name.startswith(("xformOp:", "physics:"))]
        if moving and any(path == prim.path or path.startswith(f"{prim.path}/") for path in bodies):
            found = f"{listing(moving)} of <{prim.path}> is given by time samples only"
            findings.error(found, "a default value", "write the values of one time as defaults")


_Parts = tuple[list[Shape], list[Shape], list[Collider]]


def _shapes(
    facts: Facts, bodies: Mapping[str, Body], stands: Mapping[str, Stand], findings: Findings
) -> dict[str, _Parts]:
    """Visual shapes, collision shapes and colliders of every body."""
    found: dict[str, _Parts] = {path: ([], [], []) for path in bodies}
    left: list[str] = []
    switched = {prim.path for prim in facts.prims if prim.has(API)} - set(bodies)
    for prim in facts.prims:
        collides = prim.has(COLLISION)
        if prim.type not in FORMS and not (collides and prim.type not in PLACES):
            continue
        path = owner(prim.path, {**bodies, **dict.fromkeys(switched, bodies[""])})
        if not path or path in switched:
            continue
        visuals, collisions, colliders = found[path]
        shape = _shape(prim, bodies[path].world, stands.get(prim.path), facts.length, Harmless(findings))
        where = stands.get(prim.path)
        if collides and prim.flag("physics:collisionEnabled", True):
            colliders.append(Collider(prim, np.ones(3) if where is None else where.scale, shape))
        if shape is None:
            left.append(prim.path)
        elif collides:
            collisions.append(shape)
        if shape is not None and prim.word("purpose", "default") in ("default", "render") and _visible(prim):
            visuals.append(shape)
    if left:
        findings.warn(f"{len(left)} shapes are not drawn: {listing(f'<{one}>' for one in left)}",
                      "cubes, spheres, cylinders and capsules")  # fmt: skip
    return found


def _visible(prim: Prim) -> bool:
    return prim.word("visibility", "inherited") != "invisible"


def _shape(prim: Prim, body: Array, where: Stand | None, length: float, findings: Findings) -> Shape | None:
    """A solid in the frame of its body; None where it is none."""
    if prim.type not in SOLIDS or where is None:
        return None
    scale = np.abs(where.scale)
    placement = turned(inverse(body) @ where.world, along(prim))
    x, y, z = (float(one) for one in np.abs(along(prim).T @ scale))
    if prim.type == "Cube":
        size = tuple(float(length * one * prim.number("size", 2.0)) for one in scale)
    elif prim.type == "Sphere":
        size = (length * x * prim.number("radius", 1.0),)
    else:
        size = (length * x * prim.number("radius", 0.5), length * z * prim.number("height", 1.0))
    round_ = prim.type == "Sphere" or prim.type == "Capsule"
    if prim.type != "Cube" and (abs(x - y) > 1e-5 * x or (round_ and abs(x - z) > 1e-5 * x)):
        findings.error(f"{prim.type} <{prim.path}> is scaled by {_told(scale)}", "one scale for what is round")
        return None
    colour = prim.vector("primvars:displayColor")
    kind = "box" if prim.type == "Cube" else prim.type.lower()
    opaque = (*colour, 1.0) if len(colour) == 3 else None
    return Shape(kind, size, placement, opaque, name=prim.name)


def _told(scale: Array) -> str:
    return " x ".join(f"{one:g}" for one in scale)
