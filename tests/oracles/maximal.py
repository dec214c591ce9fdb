"""Any robot with loops in maximal coordinates: every link a free body, every joint and cut a constraint.

Independent of cutjoint and pinocchio: robot.urdf and loops.toml are read by `oracles.reading`, and the equations are
those of Newton and Euler for each body, with twists [v; w] of the link's origin in world axes:

    M A + b = W + sum of joint efforts + G' f,       G A + g = 0

G holds the rows of all joints and cuts on relative twists, dimensionless (lengths divided by `length`, [m]).  Its rank
by singular values gives the mobility: 6 x bodies - rank.  Accelerations are found in an orthonormal basis of the
motions that are left, so bodies without mass do no harm as long as some mass moves with every motion.

    robot = Maximal("urdf/stewart", length=0.3)
    placed = robot.at({"leg1_slide": 0.53, ...})        # every joint of the tree; placed.gaps says whether it closes
    placed.mobility
    state = placed.moving({"leg1_slide": 0.1, ...})     # every joint's velocity
    motion = state.driven({"leg1_slide": 12.0, ...})    # efforts of any joints -> accelerations, wrenches
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from oracles.physics import Bush, Law
from oracles.placed import Placed
from oracles.reading import COORDINATES, Array, Robot, read


class Maximal:
    """A robot read from its files; `length` [m] makes lengths and angles comparable.

    All positions are counted from `origin` (3,) [m], a point of the world: near the robot no digits are lost to a base
    that stands far away.  `laws` of joints and cuts, and `bushings` of cuts, are those of `oracles.physics`.
    """

    def __init__(
        self,
        path: Path | str,
        variant: str | None = None,
        length: float = 1.0,
        origin: Array | None = None,
        laws: Mapping[str, Law] | None = None,
        bushings: Mapping[str, Bush] | None = None,
    ) -> None:
        self.robot: Robot = read(path, variant)
        self.laws, self.bushings = dict(laws or {}), dict(bushings or {})
        self.length = length
        self.origin = np.zeros(3) if origin is None else np.array(origin, dtype=float)
        free = [joint.child for joint in self.robot.joints]
        self.column = {link: 6 * index for index, link in enumerate(free)}
        self.size = 6 * len(free)
        self.velocity: dict[str, slice] = {}
        count = 0
        for joint in self.robot.joints:
            self.velocity[joint.name] = slice(count, count + COORDINATES[joint.kind])
            count += COORDINATES[joint.kind]
        self.velocities = count

    def at(self, coordinates: Mapping[str, Array | float]) -> Placed:
        """The robot at a value of every joint; see `connections.placed_child` for joints of several coordinates."""
        return Placed(self, coordinates)

    def flat(self, values: Mapping[str, Array | float]) -> Array:
        """Values of joints, by name, as one vector (velocities,); those left out are 0."""
        flat = np.zeros(self.velocities)
        for name, value in values.items():
            flat[self.velocity[name]] = value
        return flat
