"""Keyframes of MJCF as homes, and the posture of the file itself where it is not zero."""

from __future__ import annotations

from collections.abc import Collection

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.mjcf.body import Bodies
from cutjoint.description.formats.mjcf.compiled import Numbers
from cutjoint.description.formats.mjcf.types import MADE_OF, NUMBERS
from cutjoint.description.model import Home, Joint, JointType, Place
from cutjoint.description.transforms import rotation_from_quaternion, rpy_from_rotation
from cutjoint.findings import Findings, check_range

AS_WRITTEN = "qpos0"
"""The home where the bodies are as they are written, in a file without keyframes."""


def read_homes(bodies: Bodies, actuators: Collection[str], findings: Findings) -> tuple[Home, ...]:
    """Each `<key>` with a qpos as a home; without one the posture of a foreign file, unless it is that of zeros."""
    homes = []
    said = [(one, place) for one, place in bodies.source.all("key") if one.get("qpos") is not None]
    unnamed = iter([pair for pair in said if not pair[0].get("name")])
    named = {str(one.get("name")): (one, place) for one, place in said}
    for number, row in enumerate(bodies.model.keys, 1):
        name = row.name or f"key_{number}"
        nobody = (None, Place(findings.file))
        element, place = named.get(name, nobody) if row.name else next(unnamed, nobody)
        count = len(row.qpos) if element is None else len(str(element.get("qpos")).split())
        if count != len(row.qpos):  # MuJoCo fills up what is short
            findings.error(f"qpos of key '{name}': {count} numbers", f"{len(row.qpos)} numbers", "", place)
        elif check_range(row.qpos, f"qpos of key '{name}'", findings, place):
            homes.append(_home(name, row.qpos, bodies, actuators))
    if not homes and not bodies.own and any(bodies.model.qpos0):
        home = _home(AS_WRITTEN, bodies.model.qpos0, bodies, actuators)
        moved = [np.any(value) for value in (*home.actuated.values(), *home.passive.values())]
        homes += [home] if any(moved) else []
    return tuple(homes)


def _home(name: str, qpos: Numbers, bodies: Bodies, actuators: Collection[str]) -> Home:
    given: dict[str, float] = {}
    passive: dict[str, float | tuple[float, ...]] = {}
    for joint in bodies.tree.joints:
        if joint.name in bodies.tendons:
            value = _length(bodies.tendons[joint.name], qpos, bodies)
            (given if joint.name in actuators else passive)[joint.name] = value
        elif joint.type.moves:
            start = bodies.addresses[joint.name]
            part = qpos[start : start + sum(NUMBERS[kind] for kind in MADE_OF[joint.type])]
            if len(part) > 1:
                passive[joint.name] = _coordinates(joint, part)
            else:
                (given if joint.name in actuators else passive)[joint.name] = part[0]
    return Home(name, given, passive)


def _length(terms: dict[str, float], qpos: Numbers, bodies: Bodies) -> float:
    return sum(value * qpos[bodies.addresses[joint]] for joint, value in terms.items())


def _coordinates(joint: Joint, part: Numbers) -> tuple[float, ...]:
    """Those of a joint with several numbers in a qpos."""
    if joint.type is JointType.FLOATING:
        turn = joint.placement[:3, :3].T
        at = turn @ (np.array(part[:3]) - joint.placement[:3, 3])
        return (*map(float, at), *rpy_from_rotation(turn @ _rotation(part[3:])))
    if "ball" in MADE_OF[joint.type]:
        return (*part[:-4], *rpy_from_rotation(_rotation(part[-4:])))
    return part


def _rotation(quaternion: Numbers) -> Array:
    """Of zeros, which MuJoCo reads as no rotation, too."""
    return rotation_from_quaternion(quaternion if any(quaternion) else (1.0, 0.0, 0.0, 0.0))
