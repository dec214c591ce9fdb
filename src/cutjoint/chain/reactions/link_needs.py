"""What every link of a description asks for in a motion, by Newton and Euler, links that fixed joints carry included.

Wrenches are force and moment about the origin of the model, in its axes, so those on one link are added as they are.
With (u, w) the twist of a body about that origin, (u', w') its time derivative and c the centre of mass of a link,

    force = m (u' + w' x c + w x (u + w x c) - g),   moment = I w' + w x I w + c x force

and g only that part of gravity which is not compensated.
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.joints import support
from cutjoint.chain.kinematics import Kinematics, Moving


class LinkNeeds:
    """The links of one robot.

    Attributes:
        names: of all links.
        joint: the joint of the model that carries each.
        support: 1 for every velocity that moves a joint of the model, shape (joints, nv).
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self._k, model = kinematics, kinematics.model
        self.names = tuple(link.name for link in kinematics.description.links)
        frames = [model.frames[model.getFrameId(name, pin.FrameType.BODY)] for name in self.names]
        self.joint = [int(frame.parentJoint) for frame in frames]
        self._place = [np.array(pin.SE3(frame.placement).homogeneous) for frame in frames]
        self.support = np.array([support(model, joint) for joint in range(model.njoints)])
        gravity = np.array(model.gravity.linear)
        heavy = [
            (index, link, link.inertial)
            for index, link in enumerate(kinematics.description.links)
            if link.inertial is not None and link.inertial.mass > 0.0
        ]
        count = len(heavy)
        self._heavy = np.array([index for index, _, _ in heavy], dtype=int)
        self._heavy_joint = np.array(self.joint, dtype=int)[self._heavy]
        self._mass = np.array([inertial.mass for _, _, inertial in heavy])
        self._com = np.array([inertial.com for _, _, inertial in heavy]).reshape(count, 3)
        self._inertia = np.array([inertial.inertia for _, _, inertial in heavy]).reshape(count, 3, 3)
        self._pulls = np.array([(1.0 - link.gravity_compensation) * gravity for _, link, _ in heavy]).reshape(count, 3)

    def placements(self, q: Array) -> Array:
        """Of all links in the model, shape (links, 4, 4)."""
        axes, origins = self._k.tree.bodies(q)
        placed = np.tile(np.eye(4), (len(self.names), 1, 1))
        placed[:, :3, :3], placed[:, :3, 3] = axes[self.joint], origins[self.joint]
        return np.asarray(placed @ np.array(self._place).reshape(-1, 4, 4))

    def needs(self, placed: Moving, a: Array, placements: Array) -> Array:
        """Wrenches that make the links move so against what gravity pulls, shape (links, 6)."""
        moving = self.support * placed.v
        twists = moving @ placed.twists.T
        rates = (self.support * a) @ placed.twists.T + moving @ placed.rates.T
        (u, w), (du, dw) = (one[self._heavy_joint].reshape(-1, 2, 3).swapaxes(0, 1) for one in (twists, rates))
        axes, origin = placements[self._heavy, :3, :3], placements[self._heavy, :3, 3]
        c = origin + np.einsum("kij,kj->ki", axes, self._com)
        change = du + np.cross(dw, c) + np.cross(w, u + np.cross(w, c)) - self._pulls
        force = self._mass[:, None] * change
        own_w, own_dw = (np.einsum("kji,kj->ki", axes, one) for one in (w, dw))
        turned = np.einsum("kij,kj->ki", self._inertia, own_dw)
        turned += np.cross(own_w, np.einsum("kij,kj->ki", self._inertia, own_w))
        found = np.zeros((len(self.names), 6))
        found[self._heavy, :3] = force
        found[self._heavy, 3:] = np.einsum("kij,kj->ki", axes, turned) + np.cross(c, force)
        return found
