"""Inverse dynamics of robots with more or fewer actuators than mobility.

Let N be a basis of the motions that the loops allow.  An effort tau of the actuators acts on them as N' S' tau, and a
motion needs N' rnea(q, v, a).  With more actuators than mobility many efforts do the same: the least one is given, and
with it the efforts that only press the links against each other (internal preload).  With fewer, most motions cannot be
produced: the error names the joints of the motion that is out of reach.

Least is meant in the actuators' own units, so it is a matter of taste where forces and torques are mixed.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, readonly
from cutjoint.chain.kinematics import Kinematics, ToolPoint
from cutjoint.chain.mobility import joints_of, null_space
from cutjoint.errors import ActuationError, InputError


@dataclass(frozen=True, eq=False)
class ActuatorEfforts:
    """Efforts that produce a motion.

    Attributes:
        effort: the least one, shape (n,), [N] or [N m].
        preload: orthonormal basis of efforts that produce no motion, shape (n, k); effort + preload @ anything does the
            same motion.
    """

    effort: Array
    preload: Array


def actuator_efforts(
    name: str, kinematics: Kinematics, actuated: Array, q: Array, v: Array, a: Array
) -> ActuatorEfforts:
    """Least actuator efforts for the motion q (nq,), v and a (nv,) of all joints, which the loops must allow.

    Raises:
        ActuationError: the actuators cannot produce the motion.
    """
    k = kinematics
    needed = np.array(pin.rnea(k.model, k.data, q, v, a))
    k.update(q)
    scale = k.column_scale
    motions = scale[:, None] * null_space(k.scaled_jacobian())
    acting = motions[actuated].T
    left, values, right = np.linalg.svd(acting)
    rank = int(np.sum(values > tolerances.RANK.value * max(values.max(initial=0.0), 1e-300)))
    wanted = motions.T @ needed
    effort = right[:rank].T @ ((left[:, :rank].T @ wanted) / values[:rank])
    out_of_reach = left[:, rank:]
    missing = out_of_reach.T @ wanted
    size = float(np.abs(missing).max(initial=0.0))
    if size > tolerances.DYNAMICS.value * max(float(np.abs(wanted).max(initial=0.0)), 1.0):
        joints = joints_of(k.model, (motions @ (out_of_reach @ missing))[:, None] / scale[:, None] / size)
        raise ActuationError(
            f"the actuators of {name} cannot produce this motion: they act on {rank} of its {motions.shape[1]} degrees "
            f"of freedom, and the rest would need a generalised force of {size:.3g} along the joint motion of "
            f"{', '.join(joints)}",
            mobility=motions.shape[1],
            actuators=len(actuated),
            free=joints,
        )
    return ActuatorEfforts(readonly(effort), readonly(right[rank:].T))


def motion_of_tool(
    name: str, kinematics: Kinematics, tool: ToolPoint, q: Array, velocity: Array, acceleration: Array
) -> tuple[Array, Array]:
    """Least motion of all joints, v and a (nv,) each, that the loops allow and that moves the tool point as asked.

    Raises:
        InputError: the tool cannot move like that here.
    """
    k, scale = kinematics, kinematics.column_scale
    k.update(q)
    rows = np.concatenate([k.closure.jacobian(k.data), tool.jacobian(k.data)[:3]])
    still = np.zeros(k.closure.rows)

    def least(what: str, right: Array) -> Array:
        motion = scale * np.linalg.lstsq(rows * scale, right, rcond=tolerances.RANK.value)[0]
        miss = float(np.abs(rows @ motion - right).max())
        if miss > tolerances.DYNAMICS.value * max(float(np.abs(right).max()), 1.0):
            raise InputError(f"the tool of {name} cannot have this {what} here: it would be off by {miss:.3g}")
        return np.asarray(motion)

    v = least("velocity", np.concatenate([still, velocity]))
    k.update_rates(q, v)
    drift = np.concatenate([k.closure.drift(k.data, v), tool.drift(k.data, v)])
    return v, least("acceleration", np.concatenate([still, acceleration]) - drift)
