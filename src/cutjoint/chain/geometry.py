"""The shapes of a robot as Pinocchio's geometry models: what its collision checks and its visualizers take.

Meshes are read as everywhere in cutjoint (`cutjoint.description.meshes`), also those that Pinocchio's own loader does
not know; the triangles are what a geometry holds, and its path is kept for visualizers that load files themselves.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from cutjoint.chain.build import bind_frame
from cutjoint.description.meshes import read_meshes
from cutjoint.description.model import Frame, Link, RobotDescription, Shape
from cutjoint.errors import InputError
from cutjoint.extras import needed

PLAIN = (0.7, 0.7, 0.7, 1.0)
"""Colour of a shape that has none: red, green, blue, opacity."""


def visual_model(model: pin.Model, description: RobotDescription) -> pin.GeometryModel:
    """The visual shapes of all links, on the joints of `model`.

    Raises:
        InputError: a mesh cannot be read, or a shape is of an unknown kind.
        MissingPackageError: there are meshes, and trimesh is not installed.
    """
    return _geometry(model, description, visual=True)


def collision_model(model: pin.Model, description: RobotDescription) -> pin.GeometryModel:
    """The collision shapes of all links, with all pairs of bodies that may collide: not those of one body, nor of two
    that a joint or a cut joins.

    Raises:
        InputError, MissingPackageError: as `visual_model`.
    """
    shapes = _geometry(model, description, visual=False)
    joined = {(int(model.parents[joint]), joint) for joint in range(1, model.njoints)}
    for cut in description.cuts:
        joined.add((bind_frame(model, cut.a)[0], bind_frame(model, cut.b)[0]))
    bodies = [int(one.parentJoint) for one in shapes.geometryObjects]
    for first, body in enumerate(bodies):
        for second in range(first):
            pair = body, bodies[second]
            if body != bodies[second] and pair not in joined and pair[::-1] not in joined:
                shapes.addCollisionPair(pin.CollisionPair(second, first))
    return shapes


def _geometry(model: pin.Model, description: RobotDescription, *, visual: bool) -> pin.GeometryModel:
    shapes = pin.GeometryModel()
    for link in description.links:
        joint, place = bind_frame(model, Frame(link.name))
        for name, shape in _named(link, visual):
            one = _object(name, shape, joint, place * pin.SE3(np.array(shape.placement)))
            one.parentFrame = model.getFrameId(link.name, pin.FrameType.BODY)
            shapes.addGeometryObject(one)
    return shapes


def _named(link: Link, visual: bool) -> Iterator[tuple[str, Shape]]:
    for number, shape in enumerate(link.visuals if visual else link.collisions):
        yield f"{link.name}_{number}", shape


def _object(name: str, shape: Shape, joint: int, place: pin.SE3) -> pin.GeometryObject:
    path = "" if shape.mesh is None else str(shape.mesh)
    scale = np.array(shape.size if shape.kind == "mesh" and len(shape.size) == 3 else (1.0, 1.0, 1.0))
    colour = np.array(PLAIN if shape.colour is None else shape.colour)
    own = shape.kind == "mesh" and shape.colour is None
    return pin.GeometryObject(name, joint, place, _solid(shape, scale), path, scale, not own, colour)


def _solid(shape: Shape, scale: np.ndarray) -> object:
    """The shape as an object of coal, Pinocchio's library for collisions."""
    coal, size = pin.coal, shape.size
    if shape.kind == "box":
        return coal.Box(*size)
    if shape.kind == "sphere":
        return coal.Sphere(size[0])
    if shape.kind in ("cylinder", "capsule"):
        return (coal.Cylinder if shape.kind == "cylinder" else coal.Capsule)(size[0], size[1])
    if shape.kind != "mesh" or shape.mesh is None:
        raise InputError(
            f"a shape of kind '{shape.kind}' is none in Pinocchio; box, sphere, cylinder, capsule and mesh are"
        )
    needed("trimesh", "a mesh")
    parts = read_meshes(shape.mesh)
    solid = coal.BVHModelOBBRSS()
    solid.beginModel(sum(len(part.faces) for part in parts), sum(len(part.vertices) for part in parts))
    first = 0
    for part in parts:
        solid.addVertices(np.asarray(part.vertices, dtype=float) * scale)
        solid.addTriangles(np.asarray(part.faces, dtype=np.int64) + first)
        first += len(part.vertices)
    solid.endModel()
    return solid
