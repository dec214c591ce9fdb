"""What a working mode holds: of the tool's pose that part which the robot's task is.

Let m be the directions in which the tool can move, with its rotation counted, and r those of its point.

- r = m: the point says where the tool is, so the *point* is held (a five-bar, a Delta, a four-bar).  The tool's
  rotation is whatever comes with it: the rotations that the motion generates are left open.  Of a Delta these are none,
  so its platform stays upright; of a planar robot those about the normal of its plane, so a five-bar counts every
  solution, on whichever limb the tool's frame sits; in space, once it turns about two axes, all of them.
- r < m: position and orientation say where the tool is, so its whole *pose* is held (a planar 3-RRR, a 3-PRS, a Stewart
  platform).

Directions in which the tool moves by less than COMMANDED of its fastest one are side effects, not what a motor is there
for: a 3-PRS moves its point sideways a little while it tilts.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver, PoseDriver, TiltDriver, ToolDriver
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import null_space
from cutjoint.chain.structure import scaled_tool

Held = Literal["point", "pose"]
WAYS: tuple[Held, ...] = ("point", "pose")


def task_of(kinematics: Kinematics, placed: Placed) -> tuple[Held, Array]:
    """Whether point or pose of the tool is commanded at a closed configuration, and an orthonormal basis of the
    axes, shape (3, k), about which it turns there."""
    k = kinematics
    moved = scaled_tool(k, placed) @ null_space(placed.scaled)
    fastest = float(np.linalg.svd(moved, compute_uv=False).max(initial=0.0))

    def directions(rows: Array) -> Array:
        left, values, _ = np.linalg.svd(rows)
        return np.asarray(left[:, : int(np.sum(values > tolerances.COMMANDED.value * max(fastest, 1e-300)))])

    whole, point = directions(moved).shape[1], directions(moved[:3]).shape[1]
    return "point" if point == whole else "pose", directions(moved[3:])


def holding(held: Held, axes: Array, at: Placed) -> tuple[Driver, Driver]:
    """What leads a start to a mode, and what a mode must meet, with the tool as it is `at` a configuration.

    They differ where the point is held and the rotation follows: then it leads, and a robot whose links were rounded by
    the program that exported them is not asked for a rotation that it misses by a micrometre.
    """
    pose = at.tool
    if held == "pose":
        whole = PoseDriver(pose, pose)
        return whole, whole
    point = ToolDriver(at.tool_position, at.tool_position)
    if axes.shape[1] == 0:
        return PoseDriver(pose, pose), point
    return TiltDriver(pose, axes[:, 0]) if axes.shape[1] == 1 else point, point
