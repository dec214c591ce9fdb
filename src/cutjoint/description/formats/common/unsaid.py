"""What other programs do not find in a file: what links, joints and cuts do by themselves where it has no words for it,
or only those of cutjoint; and shapes that it cannot hold."""

from __future__ import annotations

from collections.abc import Collection, Iterable

import numpy as np

from cutjoint.description.model import Inertial, JointPhysics, RobotDescription, Shape
from cutjoint.findings import listing
from cutjoint.mechanism.physics import NO_PHYSICS

WORDS = {
    "damping": ("damping",),
    "friction": ("friction",),
    "friction_speed": ("friction_speed",),
    "springs": ("stiffness",),
    "rotors": ("rotor",),
    "stops": ("stop_stiffness",),
}
"""What is told of joints and cuts -> the quantities it is about."""
COMPENSATION = "gravity compensation"
"""What is told of links."""

MESHES = (".stl", ".obj", ".msh")
"""Files of meshes that MuJoCo reads."""

EQUAL = 3e-15
"""Relative to the largest moment of inertia: how far rounding takes it from the sum of the others."""


def triangle(inertial: Inertial) -> tuple[float, float]:
    """By how much the largest moment of inertia is more than the others together, and that moment [kg m2]."""
    small, middle, large = (float(moment) for moment in np.linalg.eigvalsh(inertial.inertia))
    return large - middle - small, large


def drawn(shape: Shape, meshes: Collection[str]) -> bool:
    """Whether MuJoCo takes a shape: a mesh of these files, or one of some size."""
    if shape.mesh is not None:
        return shape.mesh.suffix.lower() in meshes
    return min(shape.size) > 0.0


def left_out(robot: RobotDescription, meshes: Collection[str]) -> tuple[str, ...]:
    """The shapes that a file leaves out where only meshes of these files are read."""
    found = []
    for link in robot.links:
        lost = [shape for shape in (*link.visuals, *link.collisions) if not drawn(shape, meshes)]
        files = dict.fromkeys(shape.mesh.name for shape in lost if shape.mesh is not None)
        found += [f"mesh {name} of link {link.name}" for name in files]
        found += [f"{shape.kind} of size 0 of link {link.name}" for shape in lost if shape.mesh is None]
    return (listing(found),) if found else ()


def unsaid(robot: RobotDescription, known: Collection[str]) -> tuple[str, ...]:
    """What is lost to others of `WORDS`: of joints and links all but what is `known`, of cuts all; and inertias that
    MuJoCo evens out."""
    said = []
    for kind, has, items in (("joint", known, robot.joints), ("cut", (), robot.cuts)):
        physics = [(one.name, one.physics) for one in items]
        for what, keys in WORDS.items():
            if what not in has:
                said += _sentence(what, kind, (name for name, one in physics if _gives(one, keys)))
    if "inertias" not in known:
        bodies = [(one.name, *triangle(one.inertial)) for one in robot.links if one.inertial is not None]
        impossible = [name for name, excess, largest in bodies if excess > EQUAL * largest]
        said += _sentence("impossible moments of inertia", "link", impossible)
    if COMPENSATION not in known:
        said += _sentence(COMPENSATION, "link", (one.name for one in robot.links if one.gravity_compensation))
    return (*said, *_sentence("bushings", "cut", (cut.name for cut in robot.cuts if cut.bushing is not None)))


def _gives(physics: JointPhysics, keys: tuple[str, ...]) -> bool:
    if keys == ("friction_speed",):
        return physics.friction > 0.0 and not physics.sticks
    return any(getattr(physics, key) != getattr(NO_PHYSICS, key) for key in keys)


def _sentence(what: str, kind: str, names: Iterable[str]) -> list[str]:
    named = list(names)
    return [f"{what} of {kind}{'s' if len(named) > 1 else ''} {listing(named)}"] if named else []
