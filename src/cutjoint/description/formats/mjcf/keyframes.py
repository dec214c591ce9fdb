"""Keyframes of an MJCF file as home postures."""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.description.findings import Findings
from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.types import MADE_OF, NUMBERS
from cutjoint.description.model import Home, JointType
from cutjoint.description.numbers import read_numbers
from cutjoint.description.transforms import rotation_from_quaternion, rpy_from_rotation
from cutjoint.description.xml import Element, children


def read_homes(root: Element, bodies: Bodies, findings: Findings) -> tuple[Home, ...]:
    """Each `<key>` with a qpos as a home.

    A qpos of a free joint is the body's placement in the world; that of the joint is relative to its place at zero.
    """
    joints = [joint for joint in bodies.tree.joints if joint.type.moves]
    actuated = set(bodies.tree.actuators)
    sizes = [sum(NUMBERS[kind] for kind in MADE_OF[joint.type]) for joint in joints]
    homes = []
    for section in children(root, "keyframe"):
        for number, key in enumerate(children(section, "key")):
            if key.get("qpos") is None:
                continue
            name = str(key.get("name") or f"key_{number + 1}")
            values = read_numbers(key.get("qpos"), sum(sizes), f"qpos of key '{name}'", findings, key.sourceline)
            if values is None:
                continue
            given: dict[str, float] = {}
            passive: dict[str, float | tuple[float, ...]] = {}
            start = 0
            for joint, size in zip(joints, sizes, strict=True):
                part = values[start : start + size]
                start += size
                if joint.type is JointType.FLOATING:
                    local = joint.placement[:3, :3].T @ _rotation(part[3:])
                    at = joint.placement[:3, :3].T @ (part[:3] - joint.placement[:3, 3])
                    passive[joint.name] = (*map(float, at), *rpy_from_rotation(local))
                elif "ball" in MADE_OF[joint.type]:
                    passive[joint.name] = (*part[:-4], *rpy_from_rotation(_rotation(part[-4:])))
                elif size > 1:
                    passive[joint.name] = part
                else:
                    value = part[0] - bodies.references.get(joint.name, 0.0)
                    (given if joint.name in actuated else passive)[joint.name] = value
            homes.append(Home(name, given, passive))
    return tuple(homes)


def _rotation(quaternion: tuple[float, ...]) -> Array:
    """Of zeros, which MuJoCo reads as no rotation, too."""
    return rotation_from_quaternion(quaternion if any(quaternion) else (1.0, 0.0, 0.0, 0.0))
