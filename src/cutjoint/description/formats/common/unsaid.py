"""What links, joints and cuts do by themselves that other programs do not find in a file: it has no words for it, or
only those of cutjoint."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from cutjoint.description.findings import listing
from cutjoint.description.model import JointPhysics, RobotDescription
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


def unsaid(robot: RobotDescription, known: Collection[str]) -> tuple[str, ...]:
    """What is lost to others of `WORDS`: of joints and links all but what is `known`, of cuts all."""
    said = []
    for kind, has, items in (("joint", known, robot.joints), ("cut", (), robot.cuts)):
        physics = [(one.name, one.physics) for one in items]
        for what, keys in WORDS.items():
            if what not in has:
                said += _sentence(what, kind, (name for name, one in physics if _gives(one, keys)))
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
