"""A closed chain against another engine, at random states around home."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.crosscheck import Comparison, Reacher, Row, State
from cutjoint.engines.mujoco import MujocoRobot

TOLERANCE = {
    "mass matrix of the tree": tolerances.ENGINE_MATRIX.value,
    "bias of the tree": tolerances.ENGINE_MATRIX.value,
    "directions of the constraints": tolerances.ENGINE_MATRIX.value,
    "forward dynamics, hard constraints": tolerances.ENGINE_HARD.value,
    "MuJoCo's solver against its own softness": tolerances.ENGINE_HARD.value,
}
SOFT = "MuJoCo's solver against Pinocchio"


def compare_with_mujoco(
    chain: ClosedChain, states: Iterable[State], progress: Callable[[int], None] | None = None
) -> Comparison:
    """Dynamics of `chain` against MuJoCo's at `states` of any model of the robot.

    Errors are relative to the largest entry of each sample.  MuJoCo's own solver is soft: it is compared with what its
    regularisation must give, and what it gives may be off from Pinocchio by as much as that softness explains.

    Raises:
        InputError: MuJoCo is not installed, or has no counterpart for one of the robot's joints.
    """
    robot, data = MujocoRobot(chain), chain.model.createData()
    worst = dict.fromkeys(TOLERANCE, (0.0, 0))
    soft = allowed = 0.0
    reacher = Reacher(chain)
    count = 0
    for count, state in enumerate(states, start=1):
        near = reacher.take_up(state)
        q, v, effort = near.q_full, chain.full_velocity(near, state.v), chain.full_effort(state.effort)
        opinion = robot.opinion(q, v, effort)
        upper = pin.crba(chain.model, data, q)
        mass = np.triu(upper) + np.triu(upper, 1).T
        bias = np.array(pin.nonLinearEffects(chain.model, data, q, v))
        acceleration = chain.full_forward_dynamics(q, v, effort).acceleration
        tangent = chain.tangent(near)
        errors = (
            _relative(opinion.mass, mass),
            _relative(opinion.bias, bias),
            float(np.abs(opinion.jacobian @ tangent).max()) / float(np.abs(tangent).max()),
            _relative(opinion.hard, acceleration),
            _relative(opinion.soft, opinion.softened),
        )
        soft = max(soft, _relative(opinion.soft, acceleration))
        allowed = max(allowed, _relative(opinion.softened, opinion.hard))
        for name, error in zip(TOLERANCE, errors, strict=True):
            if not error <= worst[name][0]:
                worst[name] = (error, count - 1)
        if progress is not None:
            progress(count)
    rows = [Row(name, error, TOLERANCE[name], sample) for name, (error, sample) in worst.items()]
    rows.append(Row(SOFT, soft, 1.01 * allowed + tolerances.ENGINE_HARD.value, 0))
    return Comparison(chain.name, "MuJoCo", count, tuple(rows))


def _relative(found: Array, wanted: Array) -> float:
    error = float(np.abs(found - wanted).max()) / max(float(np.abs(wanted).max()), 1e-300)
    return error if np.isfinite(error) else float("inf")
