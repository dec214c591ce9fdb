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

from cutjoint import tolerances
from cutjoint.arrays import Array, Values, readonly
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Kinematics, Placed
from cutjoint.chain.rank import Split, null_space
from cutjoint.errors import ActuationError, InputError
from cutjoint.reprs import line


@dataclass(frozen=True, eq=False)
class ActuatorEfforts(Values):
    """Efforts that produce a motion.

    Attributes:
        effort: the least one, shape (n,), [N] or [N m].
        preload: orthonormal basis of efforts that produce no motion, shape (n, k); effort + preload @ anything does the
            same motion.
    """

    effort: Array
    preload: Array

    __repr__ = line(effort="N or N m", preload="N or N m")


def actuator_efforts(
    kinematics: Kinematics, actuated: Array, q: Array, v: Array, a: Array, push: Array
) -> ActuatorEfforts:
    """Least actuator efforts for the motion q (nq,), v and a (nv,) of all joints, which the loops must allow, where
    generalised forces `push` (nv,) act from outside."""
    k = kinematics
    scale = k.column_scale
    mass = scale[:, None] * k.tree.mass_matrix(q) * scale
    placed = k.at(q)
    motions = null_space(placed.scaled)
    inertial, bias = mass @ (a / scale), scale * k.tree.forces(q, v, np.zeros(k.model.nv))
    if k.physics.acts:
        bias = bias + scale * (placed.springs + placed.friction(v))
    split = Split.of(motions[actuated].T)
    pushed = scale * push
    wanted = motions.T @ (inertial + bias - pushed)
    out_of_reach = Split.of(split.left.T).null
    missing = out_of_reach.T @ wanted
    size = float(np.abs(missing).max(initial=0.0))
    terms = np.abs(motions.T) @ (np.abs(inertial) + np.abs(bias) + np.abs(pushed))
    if size > tolerances.REACHED.value * float(terms.max(initial=0.0)) + tolerances.ROUNDED.value * k.load(mass, v, a):
        joints = joints_of(k.model, (motions @ (out_of_reach @ missing))[:, None] / size)
        raise ActuationError(
            f"the actuators of {k.name} cannot produce this motion: they act on {split.rank} of its {motions.shape[1]} "
            f"degrees of freedom, and the rest would need a generalised force of {size:.3g} (dimensionless) "
            f"along the joint motion of {', '.join(joints)}",
            mobility=motions.shape[1],
            actuators=len(actuated),
            free=joints,
        )
    own = scale[actuated]
    preload = np.linalg.qr(split.null / own[:, None])[0]
    effort = split.solve(wanted) / own
    return ActuatorEfforts(readonly(effort - preload @ (preload.T @ effort)), readonly(preload))


def velocity_of_actuators(kinematics: Kinematics, actuated: Array, placed: Placed, v: Array) -> Array:
    """Velocity of all joints (nv,) with the actuators moving with v (n,), of which there may be more than freedoms."""
    k, scale = kinematics, kinematics.column_scale
    motions = null_space(placed.scaled)
    split = Split.of(motions[actuated])
    if split.null.shape[1]:
        joints = joints_of(k.model, motions @ split.null)
        raise ActuationError(
            f"the actuators of {k.name} do not tell how it moves: with them at rest, {', '.join(joints)} may move",
            mobility=motions.shape[1],
            actuators=len(actuated),
            free=joints,
        )
    wanted = v / scale[actuated]
    moving = motions @ split.solve(wanted)
    miss = float(np.abs(moving[actuated] - wanted).max(initial=0.0))
    if miss > tolerances.REACHED.value * float(np.abs(wanted).max(initial=0.0)):
        raise InputError(f"the loops of {k.name} do not let its actuators move so: one would be off by {miss:.3g}")
    return np.asarray(scale * moving)


def motion_of_tool(kinematics: Kinematics, placed: Placed, velocity: Array, acceleration: Array) -> tuple[Array, Array]:
    """Least motion of all joints, v and a (nv,) each, that the loops allow and that moves the tool point as asked."""
    k, scale = kinematics, kinematics.column_scale
    rows = np.concatenate([k.row_scale[:, None] * placed.jacobian, placed.tool_jacobian[:3] / k.length]) * scale
    split = Split.of(rows)
    still = np.zeros(k.closure.rows)

    def least(what: str, right: Array) -> Array:
        motion = split.solve(right)
        terms = np.abs(rows) @ np.abs(motion) + np.abs(right)
        miss = np.abs(rows @ motion - right)
        if miss.max(initial=0.0) > tolerances.REACHED.value * terms.max(initial=0.0):
            off = float(miss[-3:].max()) * k.length
            raise InputError(f"the tool of {k.name} cannot have this {what} here: it would be off by {off:.3g}")
        return np.asarray(scale * motion)

    v = least("velocity", np.concatenate([still, velocity / k.length]))
    moving = k.moving(placed.q, v)
    drift = np.concatenate([k.row_scale * moving.drift, moving.tool_drift[:3] / k.length])
    return v, least("acceleration", np.concatenate([still, acceleration / k.length]) - drift)
