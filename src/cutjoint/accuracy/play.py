"""How far the tool can move while its actuators have play: backlash of gears and spindles.

Each actuator is anywhere within its half-width, so the tool is anywhere in the image of a box: a zonotope, whose
corners are among the images of the corners of the box.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np

from cutjoint.accuracy.deviations import deviating
from cutjoint.accuracy.sensitivity import LoopFollower
from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.doors import door
from cutjoint.mechanism import Posture
from cutjoint.reprs import line
from cutjoint.stiffness import Springs

MOST_CORNERS = 16
"""Most actuators of which all corners are looked at; of more the sum of the parts bounds the distance."""


@dataclass(frozen=True, eq=False)
class ToolPlay(Frozen):
    """Where the tool can be while actuators have play.

    Attributes:
        robot: its name.
        actuators: those with play.
        units: of each, m or rad.
        halves: half the width of the play of each, shape (k,), [m] or [rad].
        parts: how the tool moves as each goes half its play, displacement [m] and rotation [rad], shape (6, k).
        corners: displacement and rotation at the corners of the box, shape (2^k, 6); none where there are too many.
    """

    robot: str
    actuators: tuple[str, ...]
    units: tuple[str, ...]
    halves: Array
    parts: Array
    corners: Array

    __repr__ = line("robot", "actuators", "halves", "box", halves="m or rad", box="m, rad")

    @property
    def box(self) -> Array:
        """Largest displacement [m] along and rotation [rad] about each axis of the world, either way, shape (6,)."""
        return np.asarray(np.abs(self.parts).sum(axis=1))

    @property
    def furthest(self) -> tuple[float, float]:
        """Largest displacement [m] and rotation [rad] from the middle; a bound where there are no corners."""
        many = self.corners.T if len(self.corners) else np.abs(self.parts)
        sizes = [np.linalg.norm(many[few], axis=0) for few in (slice(0, 3), slice(3, 6))]
        away, turned = (one.max() if len(self.corners) else one.sum() for one in sizes)
        return float(away), float(turned)


@door
def backlash(
    chain: ClosedChain,
    halves: Mapping[str, float],
    at: Posture | None = None,
    springs: Springs | None = None,
) -> ToolPlay:
    """How far the tool can move by backlash, in a posture (default home).

    Args:
        halves: actuator, or a pattern -> half the width of its play, at the joint, [m] or [rad].
        springs: what gives where more actuators than freedoms are at odds; default all joints and cuts alike.

    Raises:
        UnknownNameError: no such actuator.
        InputError: no number >= 0, or none is given.
        ActuationError: the tool can move while the actuators hold.
    """
    found, sized = deviating(chain.description, {f"actuators.{name}": half for name, half in halves.items()})
    told = LoopFollower(chain, at, springs).sensitivity(found)
    sizes = np.array([one.size for one in sized])
    parts = told.matrix * sizes
    corners = np.zeros((0, 6))
    if len(sizes) <= MOST_CORNERS:
        corners = np.array(list(product((-1.0, 1.0), repeat=len(sizes)))) @ parts.T
    names = tuple(source.places[0].name for source in found)
    return ToolPlay(chain.name, names, tuple(source.unit for source in found), sizes, parts, corners)
