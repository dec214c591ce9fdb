"""What joints do by themselves, between a description and files: what a format's own words leave over, and springs of
which a file does not say where they are at rest."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields, replace

from cutjoint.description.model import Joint, JointPhysics
from cutjoint.description.numbers import LARGEST_PHYSICS
from cutjoint.findings import LARGEST_LENGTH, Findings

KEYS = tuple(field.name for field in fields(JointPhysics))
"""What the keys of a loops.toml call the physics of a joint."""
CUT_KEYS = ("damping", "friction", "friction_speed", "stiffness", "rest")
"""Those of the motion that a cut joint leaves free."""


def largest(key: str) -> float:
    """The largest size of a quantity that is believed."""
    return LARGEST_LENGTH if key == "rest" else LARGEST_PHYSICS


def leftover(physics: JointPhysics, said: JointPhysics) -> dict[str, float]:
    """The keys of what `said`, as a format's own words will be read, has otherwise than `physics`."""
    values = {key: getattr(physics, key) for key in KEYS}
    return {key: float(value) for key, value in values.items() if value is not None and value != getattr(said, key)}


def with_rest(joint: Joint, given: Collection[str], findings: Findings) -> Joint:
    """The joint without a spring of which its own file, unlike the keys that were `given`, says no rest position."""
    physics = joint.physics
    if physics.stiffness == 0.0 or physics.rest is not None or "stiffness" in given or not joint.type.single:
        return joint
    found = f"stiffness {physics.stiffness:g} of joint '{joint.name}' is not used: the file does not say where"
    expected = "the position in which the spring is at rest"
    mend = f"give rest under [joint.{joint.name}] of a loops.toml"
    findings.warn(f"{found} the spring is at rest", expected, mend, joint.place)
    return replace(joint, physics=replace(physics, stiffness=0.0))
