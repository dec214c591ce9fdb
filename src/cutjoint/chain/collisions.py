"""Whether links of a robot touch each other, by Pinocchio's collision checks of its collision shapes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.reprs import line

if TYPE_CHECKING:
    from cutjoint.chain.closed_chain import ClosedChain


class SelfCollisions:
    """Looks for links that touch each other.

    Pairs of links that a joint or cut joins are not looked at, nor those that touch at one posture already: their
    shapes overlap by design.

    Args:
        chain: the robot.
        at: the posture of which contacts are passed; default home.

    Attributes:
        pairs: names of the shapes that are looked at, two by two.
        passed: those that touch at `at`.

    Raises:
        InputError: the robot has no collision shapes that could touch, or a mesh cannot be read.
        MissingPackageError: there are meshes, and trimesh is not installed.
    """

    __repr__ = line("pairs", "passed")

    def __init__(self, chain: ClosedChain, at: Posture | None = None) -> None:
        self._model = chain.model
        shapes = chain.collision_model()
        posture = chain.home if at is None else at
        touching = _touching(self._model, shapes, posture.q_full)
        pairs = list(shapes.collisionPairs)
        names = [(shapes.geometryObjects[one.first].name, shapes.geometryObjects[one.second].name) for one in pairs]
        self.passed = tuple(name for name, hit in zip(names, touching, strict=True) if hit)
        self.pairs = tuple(name for name, hit in zip(names, touching, strict=True) if not hit)
        for pair, hit in zip(pairs, touching, strict=True):
            if hit:
                shapes.removeCollisionPair(pair)
        if not self.pairs:
            raise InputError(
                f"{chain.name} has no links whose collision shapes could touch beside those that are joined or touch "
                "at the start; give its links <collision> shapes"
            )
        self._shapes = shapes
        self._data, self._geometry = self._model.createData(), shapes.createData()

    def touch(self, q_full: Array) -> bool:
        """Whether links touch at a configuration, shape (nq,)."""
        return bool(pin.computeCollisions(self._model, self._data, self._shapes, self._geometry, q_full, True))


def _touching(model: pin.Model, shapes: pin.GeometryModel, q_full: Array) -> list[bool]:
    """Of every pair, whether it touches."""
    data, geometry = model.createData(), shapes.createData()
    pin.updateGeometryPlacements(model, data, shapes, geometry, np.array(q_full))
    return [bool(pin.computeCollision(shapes, geometry, k)) for k in range(len(shapes.collisionPairs))]
