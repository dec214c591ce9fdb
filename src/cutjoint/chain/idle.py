"""Whether the idle motions of a robot stay without momentum, so that its actuated coordinates tell the whole motion.

In actuated coordinates idle motions are given no momentum (`cutjoint.chain.tangent`), at every single state exactly.
That it stays so while the robot moves needs more: neither the reduced mass matrix nor gravity may depend on where the
idle motions are, as for a round rod between two balls; their coordinates are then cyclic.  A bent rod that spins gains
momentum from the motion of the others, and a link that merely hangs is a pendulum.

After Routh's elimination of cyclic coordinates; E. J. Routh, Stability of Motion, 1877.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.tangent import TangentMap
from cutjoint.errors import SingularError

TURN = 0.3
"""By how much the robot is moved along its idle motions, in radians or characteristic lengths."""


def is_cyclic(
    kinematics: Kinematics,
    postures: Sequence[Placed],
    tangent: Callable[[Placed], TangentMap],
    settle: Callable[[Array], Placed | None],
) -> bool:
    """Whether mass matrix and gravity in actuated coordinates are the same after a motion along any idle direction.

    Args:
        postures: closed ones to look at; singular ones are passed over.
        tangent: of a closed configuration.
        settle: closes a configuration that is nearly closed, the actuators held.
    """
    k, looked = kinematics, False
    for placed in postures:
        try:
            here = tangent(placed)
        except SingularError:
            continue
        looked = True
        mass, gravity = _reduced(k, here, placed)
        weights = np.abs(here.map.T) @ np.abs(k.tree.gravity(placed.q))
        for motion in here.idle.T:
            step = motion * (TURN / float(np.abs(motion / k.column_scale).max()))
            moved = settle(k.tree.integrate(placed.q, step))
            if moved is None:
                return False
            mass_there, gravity_there = _reduced(k, tangent(moved), moved)
            size = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
            heavier = np.abs(mass_there - mass) > tolerances.DYNAMICS.value * size
            largest = np.maximum(weights, np.abs(here.map.T) @ np.abs(k.tree.gravity(moved.q)))
            if heavier.any() or (np.abs(gravity_there - gravity) > tolerances.DYNAMICS.value * largest).any():
                return False
    return looked


def _reduced(k: Kinematics, tangent: TangentMap, placed: Placed) -> tuple[Array, Array]:
    """Mass matrix (n, n) and gravity (n,) in actuated coordinates."""
    return tangent.map.T @ k.tree.mass_matrix(placed.q) @ tangent.map, tangent.map.T @ k.tree.gravity(placed.q)
