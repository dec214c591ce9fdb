"""Which freedoms of a closed robot are idle: whether what its actuators leave free matters to anybody.

With all actuators locked a robot may still move: a rod between two balls spins about itself.  Such a motion is idle if
it leaves the tool where it is; for a robot without a tool, if all that it does is spin bodies that are held by two
connections or more, about those.
"""

from __future__ import annotations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.closure import Cut, bind_frame
from cutjoint.compile.cloud import null_space
from cutjoint.compile.projection import Projection


def idle_freedoms(numbers: Projection, cuts: tuple[Cut, ...], q: Array) -> int | None:
    """Number of idle freedoms of a chain at the closed configuration `q`, or None where its actuators do not determine
    the rest of its motion."""
    nv = numbers.model.nv
    constraints = numbers.jacobian(q)
    locked = np.concatenate([constraints, np.eye(nv)[numbers.rates]])
    free = null_space(locked).shape[1]
    if len(numbers.rates) + free != null_space(constraints).shape[1]:
        return None
    if free == 0:
        return 0
    tool = numbers.chain.description.tool
    if tool is None:
        seen = _connections(numbers, cuts, q)
    else:
        joint, placement = bind_frame(numbers.model, tool)
        seen = _scaled(numbers, numbers.point(q, joint, np.array(placement.translation))[1])
    return free if null_space(np.concatenate([locked, seen])).shape[1] == free else None


def _scaled(numbers: Projection, twist: Array) -> Array:
    """Velocities of a point (3) and angular velocities (3), dimensionless."""
    lengths = np.array([1.0 / numbers.chain.length] * 3 + [1.0] * 3)[:, None]
    return np.asarray(lengths * twist * numbers.scale)


def _connections(numbers: Projection, cuts: tuple[Cut, ...], q: Array) -> Array:
    """Velocities that vanish where bodies only spin about what holds them, shape (rows, nv).

    Of a body with two connections or more these are the velocities of their origins, of any other body its twist.
    """
    model = numbers.model
    levers: list[list[Array]] = [[np.zeros(3)] for _ in range(model.njoints)]
    for joint in range(1, model.njoints):
        levers[model.parents[joint]].append(np.array(model.jointPlacements[joint].translation))
    for cut in cuts:
        levers[cut.joint_a].append(np.array(cut.placement_a.translation))
        levers[cut.joint_b].append(np.array(cut.placement_b.translation))
    rows = []
    for joint in range(1, model.njoints):
        rank = 3 if len(levers[joint]) > 1 else 6
        rows += [_scaled(numbers, numbers.point(q, joint, lever)[1])[:rank] for lever in levers[joint]]
    return np.concatenate(rows) if rows else np.zeros((0, model.nv))
