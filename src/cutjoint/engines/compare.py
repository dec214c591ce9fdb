"""A closed chain against another engine, at random states around home."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.kinematics import Kinematics
from cutjoint.crosscheck import Comparison, ComparisonRow, Reacher, SampledState
from cutjoint.engines.mujoco import MujocoRobot, Opinion

TOLERANCE = {
    "mass matrix of the tree": tolerances.ENGINE_MATRIX.value,
    "bias of the tree": tolerances.ENGINE_MATRIX.value,
    "springs, dampers and friction of the tree": tolerances.ENGINE_MATRIX.value,
    "potential energy": tolerances.ENGINE_MATRIX.value,
    "directions of the constraints": tolerances.ENGINE_MATRIX.value,
    "forward dynamics, hard constraints": tolerances.ENGINE_HARD.value,
    "MuJoCo's solver against its own softness": tolerances.ENGINE_HARD.value,
    "MuJoCo's solver against Pinocchio": tolerances.ENGINE_SOLVER.value,
    "what MuJoCo's solver lets through": tolerances.ENGINE_LEAK.value,
}


def compare_with_mujoco(
    chain: ClosedChain, states: Iterable[SampledState], progress: Callable[[int], None] | None = None
) -> Comparison:
    """Dynamics of `chain` against MuJoCo's at `states` of any model of the robot.

    Errors are relative to the largest entry of each sample, with sliding coordinates in lengths of the robot.  MuJoCo's
    own solver is soft: it is compared with what its own regularisation must give, and with what Pinocchio's
    accelerations become where MuJoCo's constraints give by the impedance that was asked for.  What it lets through is
    its difference from hard constraints against what these stop, measured with the mass matrix.  No tolerance depends
    on what was found.

    Raises:
        InputError: MuJoCo is not installed, or has no counterpart for one of the robot's joints.
    """
    robot, data, kinematics = MujocoRobot(chain), chain.model.createData(), Kinematics(chain.description)
    worst = dict.fromkeys(TOLERANCE, (0.0, 0))
    reacher = Reacher(chain)
    count = 0
    for count, state in enumerate(states, start=1):
        near = reacher.take_up(state)
        q, v, effort = near.q_full, chain.full_velocity(near, state.v), chain.full_effort(state.effort)
        opinion = robot.opinion(q, v, effort)
        upper = pin.crba(chain.model, data, q)
        mass = np.triu(upper) + np.triu(upper, 1).T
        lift = kinematics.tree.held_up.lift(q)
        bias = kinematics.tree.bias(q, v) + lift
        placed = kinematics.at(q)
        passive = placed.springs + placed.friction(v) - lift
        acceleration = chain.full_forward_dynamics(near, v, effort).acceleration
        tangent = chain.tangent(near)
        units = robot.units
        predicted = _softened(mass, effort - bias - passive, acceleration, opinion)
        potential = chain.potential_energy(near)
        size = np.abs(tangent / units[:, None]).max()
        errors = (
            _relative(opinion.mass, mass, np.outer(units, units)),
            _relative(opinion.bias, bias, units),
            _relative(opinion.passive, passive, units),
            abs(opinion.potential - potential) / max(abs(potential), robot.energy),
            float(np.abs(opinion.jacobian @ tangent).max(initial=0.0) / size),
            _relative(opinion.hard, acceleration, 1.0 / units),
            _relative(opinion.soft, opinion.softened, 1.0 / units),
            _relative(opinion.soft, predicted, 1.0 / units),
            _let_through(mass, effort - bias - passive, acceleration, opinion),
        )
        for name, error in zip(TOLERANCE, errors, strict=True):
            if not error <= worst[name][0]:
                worst[name] = (error, count - 1)
        if progress is not None:
            progress(count)
    rows = tuple(ComparisonRow(name, error, TOLERANCE[name], sample) for name, (error, sample) in worst.items())
    return Comparison(chain.name, "MuJoCo", count, rows)


def _softened(mass: Array, force: Array, hard: Array, opinion: Opinion) -> Array:
    """What Pinocchio's acceleration `hard` becomes where each row of MuJoCo's constraints gives, shape (nv,).

    With a_0 = M^-1 force the acceleration without constraints and W = J M^-1 J', hard rows ask for J a = J hard, and
    rows that give ask for J a + give f = J hard; so a = a_0 + M^-1 J' f with (W + give) f = J (hard - a_0).  Mass
    matrix, force and acceleration are Pinocchio's; of MuJoCo are the rows' directions and the estimates in `give`.
    """
    rows = opinion.jacobian
    solved = np.linalg.solve(mass, np.column_stack([force, rows.T]))
    free, spread = solved[:, 0], solved[:, 1:]
    return np.asarray(free + spread @ np.linalg.solve(rows @ spread + np.diag(opinion.give), rows @ (hard - free)))


def _let_through(mass: Array, force: Array, hard: Array, opinion: Opinion) -> float:
    """Size of what MuJoCo's solver lets through, relative to what the constraints stop; 0 where there are none."""
    if not len(opinion.jacobian):
        return 0.0
    through, stopped = opinion.soft - hard, np.linalg.solve(mass, force) - hard
    most = float(stopped @ mass @ stopped)
    return float(np.sqrt(through @ mass @ through / most)) if most > 0.0 else 0.0


def _relative(found: Array, wanted: Array, units: Array) -> float:
    error = float(np.abs((found - wanted) * units).max()) / max(float(np.abs(wanted * units).max()), 1e-300)
    return error if np.isfinite(error) else float("inf")
