"""Where bodies, cut joints and the centre of mass are in the world, and the energy that they have there."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics
from cutjoint.errors import InputError


class Placements:
    """Placements of one robot at any configuration (nq,), loops open or not."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics
        self._links = [
            (frame.name, frame.parentJoint, pin.SE3(frame.placement))
            for frame in kinematics.model.frames
            if frame.type == pin.FrameType.BODY and frame.name != "universe"
        ]

    def links(self, q: Array) -> dict[str, Array]:
        """World placement (4, 4) of every link."""
        axes, at = self._k.tree.bodies(q)
        joints = [pin.SE3(rotation, place) for rotation, place in zip(axes, at, strict=True)]
        return {name: self._in_world(joints[joint] * place) for name, joint, place in self._links}

    def cuts(self, q: Array) -> list[tuple[str, Array, Array]]:
        """Name and world placements (4, 4) of both frames of every cut."""
        frames = self._k.at(q).frames
        a = [self._in_world(pin.SE3(*one)) for one in zip(frames.axes_a, frames.at_a, strict=True)]
        b = [self._in_world(pin.SE3(*one)) for one in zip(frames.axes_b, frames.at_b, strict=True)]
        return list(zip([cut.name for cut in self._k.closure.cuts], a, b, strict=True))

    def centre_of_mass(self, q: Array) -> Array:
        """Of all links that move, shape (3,) [m].

        Raises:
            InputError: none of them has mass.
        """
        if not self._k.tree.mass > 0.0:
            raise InputError(f"{self._k.name} has no moving link with mass, so no centre of mass")
        return self._k.tree.centre_of_mass(q) + self._k.origin

    def potential_energy(self, q: Array) -> float:
        """Of gravity [J], zero at the world origin."""
        k = self._k
        near = k.tree.potential_energy(q)
        if not k.origin.any():
            return near
        return near - float(k.tree.mass * np.array(k.model.gravity.linear) @ k.origin)

    def _in_world(self, placement: pin.SE3) -> Array:
        """A placement in the model that is computed with as one in the world, shape (4, 4)."""
        found = np.array(placement.homogeneous)
        found[:3, 3] += self._k.origin
        return found
