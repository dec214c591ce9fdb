"""What loads from outside do to a chain: the generalised forces of the tree that do their work.

A force f at the point p of a body, with the moment m, works on the twist (u, w) of the body about the model's origin as
f . u + (m + p x f) . w, so with J the columns of the joints that carry the body it is J' (f, m + p x f).
"""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.joints import support
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.errors import UnknownNameError
from cutjoint.mechanism import Load, Loads
from cutjoint.mechanism.loads import as_loads


class ChainLoads:
    """Loads on one robot, of which `kinematics` are."""

    def __init__(self, kinematics: Kinematics) -> None:
        self._k = kinematics
        self._frames: dict[str, tuple[int, pin.SE3, Array]] = {}

    def forces(self, placed: Placed, loads: Loads) -> Array:
        """Generalised forces of all joints that do the work of `loads`, shape (nv,), [N] and [N m].

        Raises:
            InputError: they are no loads, or one acts at a tool that the robot does not have.
            UnknownNameError: there is no link of a name.
        """
        given = as_loads(loads)
        total = np.zeros(self._k.model.nv)
        bodies = self._k.tree.bodies(placed.q) if any(load.link is not None for load in given) else None
        for load in given:
            axes, place, moves = self._frame(placed, load, bodies)
            force, moment, at = load.wrench(axes, place)
            total += moves * (placed.twists.T @ np.concatenate([force, moment + np.cross(at, force)]))
        return total

    def _frame(self, placed: Placed, load: Load, bodies: tuple[Array, Array] | None) -> tuple[Array, Array, Array]:
        """Axes (3, 3) and origin (3,) of the frame that a load is given in, in the model, and what moves it (nv,)."""
        if load.link is None:
            self._k.need_tool()
            assert self._k.tool_support is not None
            return placed.tool_axes, placed.tool_position, self._k.tool_support
        assert bodies is not None
        joint, place, moves = self._link(load.link)
        axes, origin = bodies[0][joint], bodies[1][joint]
        return axes @ place.rotation, origin + axes @ place.translation, moves

    def _link(self, name: str) -> tuple[int, pin.SE3, Array]:
        """The joint that carries a link, the link's frame in it, and what moves it."""
        if name not in self._frames:
            known = [link.name for link in self._k.description.links]
            if name not in known:
                raise UnknownNameError(f"link of {self._k.name}", str(name), known)
            frame = self._k.model.frames[self._k.model.getFrameId(name, pin.FrameType.BODY)]
            joint = int(frame.parentJoint)
            self._frames[name] = joint, pin.SE3(frame.placement), support(self._k.model, joint)
        return self._frames[name]
