"""How far the tool moves as links grow warm, its actuators held.

A link that grows warm by dT gets longer by expansion dT of every length in it: the places of the joints that it
carries, of the frames of cuts and of the tool on it, all counted from its own frame.  A robot that is warm all over,
with the rods and the scales of its sliding actuators, is the same robot, larger.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np

from cutjoint.accuracy.sensitivity import LoopFollower
from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.description.cuts import CutType
from cutjoint.description.model import RobotDescription
from cutjoint.description.paths import Path
from cutjoint.description.values import number
from cutjoint.doors import described, door
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.mechanism import Posture
from cutjoint.reprs import line
from cutjoint.stiffness import Springs

MATERIALS: Mapping[str, float] = {
    "steel": 11.7e-6,
    "stainless": 17.3e-6,
    "aluminium": 23.1e-6,
    "titanium": 8.6e-6,
    "brass": 19.0e-6,
    "invar": 1.2e-6,
}
"""Expansion [1/K] of usual materials near 20 degrees Celsius, rounded; alloys differ by some percent.  Carbon steel
AISI 1020, stainless steel AISI 304, pure aluminium and titanium, yellow brass and invar, after W. M. Haynes (ed.): CRC
Handbook of Chemistry and Physics, section 12, and the makers' data."""


@dataclass(frozen=True, eq=False)
class Growth(Frozen):
    """How the tool moves as parts grow warm.

    Attributes:
        robot: its name.
        names: of the parts.
        warmth: by how much each is warmer, shape (k,) [K].
        expansion: of each, shape (k,) [1/K].
        parts: how each moves the tool, displacement [m] and rotation [rad], world axes, shape (6, k).
        play: how far the joint that gives most must give for each, shape (k,) [m].
    """

    robot: str
    names: tuple[str, ...]
    warmth: Array
    expansion: Array
    parts: Array
    play: Array

    __repr__ = line("robot", "names", "shift", shift="m, rad")

    @property
    def shift(self) -> Array:
        """How the tool moves altogether, shape (6,)."""
        return np.asarray(self.parts.sum(axis=1))


@door
def growth(
    chain: ClosedChain,
    warm: Mapping[str, float],
    expansion: str | float | Mapping[str, str | float],
    at: Posture | None = None,
    springs: Springs | None = None,
) -> Growth:
    """How the tool moves as parts grow warm, in a posture (default home).

    Args:
        warm: part, or a pattern -> by how much it is warmer [K].  A part is a link, a cut of type distance (a rod), or
            a sliding actuator (its spindle or scale).
        expansion: a material of `MATERIALS`, or a number [1/K]; or part or pattern -> its own.
        springs: what gives where the joints alone cannot follow; default all joints and cuts alike.

    Raises:
        UnknownNameError: no such part or material.
        InputError: no numbers, or a part without a material.
        ActuationError: the tool can move while the actuators hold.
    """
    robot = chain.description
    known = [link.name for link in robot.links]
    known += [cut.name for cut in robot.closing if cut.type is CutType.DISTANCE and cut.name not in known]
    known += [name for name in robot.actuators if robot.joint(name).type.slides and name not in known]
    warmth = _by_name({name: _number("warmth", name, one) for name, one in warm.items()}, known, robot.name)
    if not warmth:
        raise InputError("nothing grows warm; name a part and by how much, such as 'base': 10.0")
    share = {"*": expansion} if not isinstance(expansion, Mapping) else dict(expansion)
    of_part = _by_name({name: _expansion(one) for name, one in share.items()}, known, robot.name)
    if missing := [name for name in warmth if name not in of_part]:
        raise InputError(f"nobody says how '{missing[0]}' of {robot.name} expands; name its material")
    follower = LoopFollower(chain, at, springs)
    k, place = len(warmth), follower.displaced
    opened, moved = np.zeros((place.rows, k)), np.zeros((6, k))
    for column, (name, warmer) in enumerate(warmth.items()):
        for path in _lengths_of(robot, name):
            if path.part == "actuators":
                value = float(place.placed.q[place.kinematics.model.idx_qs[place.kinematics.model.getJointId(name)]])
            else:
                value = number(robot, path)
            if value:
                rows, tool = place.of(path)
                opened[:, column] += rows * value * of_part[name] * warmer
                moved[:, column] += tool * value * of_part[name] * warmer
    parts, play, _, _ = follower.follow(opened, moved)
    used = [of_part[name] for name in warmth]
    return Growth(chain.name, tuple(warmth), np.array(list(warmth.values())), np.array(used), parts, play)


def _lengths_of(robot: RobotDescription, part: str) -> list[Path]:
    """The lengths of a part."""
    found: list[Path] = []
    if any(link.name == part for link in robot.links):
        for axis in "xyz":
            found += [Path("joints", one.name, f"origin.{axis}") for one in robot.joints if one.parent == part]
            for cut in robot.closing:
                found += [Path("cuts", cut.name, f"{side}.{axis}") for side in "ab" if getattr(cut, side).link == part]
            if robot.tool is not None and robot.tool.link == part:
                found.append(Path("tool", "", axis))
        return found
    if any(cut.name == part for cut in robot.closing):
        return [Path("cuts", part, "length")]
    return [Path("actuators", part, "")]


def _by_name(given: Mapping[str, float], known: list[str], robot: str) -> dict[str, float]:
    """Values by exact name, in the order of `known`; an exact name goes before a pattern."""
    patterns: dict[str, float] = {}
    for name, value in given.items():
        found = [name] if name in known else [one for one in known if fnmatchcase(one, name)]
        if not found:
            raise UnknownNameError(f"link, rod or sliding actuator of {robot}", str(name), known)
        if name not in known:
            for one in found:
                if one in patterns and one not in given and patterns[one] != value:
                    raise InputError(f"'{one}' is given twice, also by '{name}'")
                patterns[one] = value
    return {name: given.get(name, patterns.get(name, 0.0)) for name in known if name in given or name in patterns}


def _expansion(given: str | float) -> float:
    if isinstance(given, str):
        if given not in MATERIALS:
            raise UnknownNameError("material", given, list(MATERIALS))
        return MATERIALS[given]
    return _number("expansion", "a part", given)


def _number(what: str, of: str, given: float) -> float:
    if isinstance(given, bool) or not isinstance(given, int | float) or not np.isfinite(given):
        raise InputError(f"{what} of {of} must be a finite number, found {described(given)}")
    return float(given)
