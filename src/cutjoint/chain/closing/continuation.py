"""Walks that stay on their branch: from a closed posture to a driver's target, in steps short against the links.

Each step along the tangent is corrected by Newton's method.  It is taken back where the determinant of the equations
changes its sign or the direction of the motion jumps, because then a singular posture was stepped over.  Steps are
minimum-norm solutions with the rank cut off, so redundant rows do no harm; configurations move on their manifold, so
free-flying and spherical joints need no special case.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import Linearised, settled
from cutjoint.chain.kinematics import Kinematics, Placed

MOST_STEPS = 2000
UNBOUND = "the joints would have to move without bound"
MEETING = "branches meet"


@dataclass(frozen=True)
class Stopped:
    """How far `follow` came: fraction of the way, the last closed configuration, and why it stopped.

    Attributes:
        singular: whether it stopped where branches cross, so that the robot could go on, but on more than one of them.
        far: whether it was given up for its length.
        measure: smallest singular value of the equations there, dimensionless.
    """

    fraction: float
    placed: Placed
    why: str
    singular: bool = False
    far: bool = False
    measure: float = 0.0


class _Stand(NamedTuple):
    """Where a walk stands: the tree, the equations there, and the motion per fraction of the way."""

    placed: Placed
    linear: Linearised
    onward: Array


def follow(kinematics: Kinematics, start: Placed, driver: Driver, free: int = 0) -> Placed | Stopped:
    """Walk from a closed configuration to the driver's target on the same branch.

    Args:
        free: motions that closure and driver leave free at nearly every posture.
    """
    fraction, step, stride = 0.0, 1.0, tolerances.STRIDE.value
    converged = refused = False
    system = System(kinematics, driver)
    begin, end = system.at(start, 0.0), system.at(start)
    rate = end.error - begin.error
    if end.openness <= 1.0:
        return settled(end, stride) or start
    linear = Linearised.of(begin.matrix, free)
    if not linear.regular:
        return Stopped(0.0, start, MEETING, singular=True, measure=linear.least)
    here = _Stand(start, linear, linear.solve(rate))
    for _ in range(MOST_STEPS):
        step = min(step, 1.0 - fraction)
        goal = 1.0 if fraction + step > 1.0 - 1e-12 else fraction + step
        motion = here.linear.solve(system.at(here.placed, goal).error)
        size = float(np.abs(motion).max(initial=0.0))
        if not np.isfinite(size):
            return Stopped(fraction, here.placed, "the equations are singular")
        if size > 1.01 * stride:
            step *= max(stride / size, 0.1)
            converged = False
        else:
            there = _arrival(system, here, motion, goal, rate)
            converged = there is not None
            if there is not None and same_branch(here.linear, here.onward, there.linear, there.onward):
                here, fraction = there, goal
                if fraction == 1.0:
                    return here.placed
                step, refused = step if refused else 2.0 * step, False
                continue
            step, refused = 0.5 * step, True
        if step < tolerances.SMALLEST_STEP.value:
            least = here.linear.least
            crossing = converged and least < tolerances.CROSSING.value
            why = MEETING if crossing else UNBOUND
            return Stopped(fraction, here.placed, why, singular=crossing, measure=least)
    why = f"{MOST_STEPS} steps were not enough; go there by way of nearer postures"
    return Stopped(fraction, here.placed, why, far=True)


def _arrival(system: System, here: _Stand, motion: Array, goal: float, rate: Array) -> _Stand | None:
    """Where a step leads to once it is corrected; None where Newton's method does not converge near by."""
    k = system.k
    tried = system.at(k.at(k.after(here.placed.q, motion)), goal)
    reach = 0.5 * float(np.abs(motion).max(initial=0.0)) + 1e-9
    placed = settled(tried, reach, goal)
    if placed is None:
        return None
    linear = Linearised.of(system.at(placed, goal).matrix, here.linear.free)
    return _Stand(placed, linear, linear.solve(rate))


def same_branch(here: Linearised, direction: Array, there: Linearised, onward: Array) -> bool:
    """Whether a step from `here` to `there` stayed clear of singular postures, by the equations and by the directions
    of the motion at both ends."""
    turn = float(np.abs(onward - direction).max(initial=0.0))
    size = max(float(np.abs(direction).max(initial=0.0)), float(np.abs(onward).max(initial=0.0)))
    return there.least > tolerances.SINGULAR.value and turn <= tolerances.TURN.value * size and not here.flips(there)
