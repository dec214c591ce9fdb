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
        self._links = kinematics.description.links
        self.support = np.array([support(model, joint) for joint in range(model.njoints)])
        gravity = np.array(model.gravity.linear)
        self._pulls = [(1.0 - link.gravity_compensation) * gravity for link in self._links]

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
        found = np.zeros((len(self.names), 6))
        for index, (joint, link) in enumerate(zip(self.joint, self._links, strict=True)):
            inertial = link.inertial
            if inertial is None or not inertial.mass > 0.0:
                continue
            axes, origin = placements[index, :3, :3], placements[index, :3, 3]
            c, inertia = origin + axes @ inertial.com, axes @ inertial.inertia @ axes.T
            (u, w), (du, dw) = twists[joint].reshape(2, 3), rates[joint].reshape(2, 3)
            change = du + np.cross(dw, c) + np.cross(w, u + np.cross(w, c)) - self._pulls[index]
            force = inertial.mass * change
            found[index] = *force, *(inertia @ dw + np.cross(w, inertia @ w) + np.cross(c, force))
        return found
