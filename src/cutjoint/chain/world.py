"""Where links and cuts are in the world, whose origin may be far from that of the model that is computed with."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import cut_sides
from cutjoint.chain.tree import TreeModel
from cutjoint.description import RobotDescription


class World:
    """The bodies of a robot in the world.

    Args:
        tree: its open tree.
        description: names its cuts.
        origin: where the tree's origin is in the world, shape (3,) [m].
    """

    def __init__(self, tree: TreeModel, description: RobotDescription, origin: Array) -> None:
        self._tree, self._origin = tree, origin
        self._cuts = [cut.name for cut in description.cuts]
        self._sides = cut_sides(tree.model, description.cuts)
        self._links = [
            (frame.name, frame.parentJoint, pin.SE3(frame.placement))
            for frame in tree.model.frames
            if frame.type == pin.FrameType.BODY and frame.name != "universe"
        ]

    def links(self, q: Array) -> dict[str, Array]:
        """World placement (4, 4) of every link."""
        joints = self._joints(q)
        return {name: self._placed(joints[joint] * place) for name, joint, place in self._links}

    def cuts(self, q: Array) -> list[tuple[str, Array, Array]]:
        """Name and world placements (4, 4) of both frames of every cut, bushings too."""
        joints = self._joints(q)
        placed = [self._placed(joints[joint] * place) for joint, place in self._sides]
        return list(zip(self._cuts, placed[::2], placed[1::2], strict=True))

    def _joints(self, q: Array) -> list[pin.SE3]:
        return [pin.SE3(*one) for one in zip(*self._tree.bodies(q), strict=True)]

    def _placed(self, placement: pin.SE3) -> Array:
        """A placement in the model as one in the world, shape (4, 4)."""
        found = np.array(placement.homogeneous)
        found[:3, 3] += self._origin
        return found
