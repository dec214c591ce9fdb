"""Stiction: joints whose dry friction holds them while they rest, and lets go when it is not enough.

Every such joint is in one of three modes: it slips forward or backward, with its friction against it, or it sticks.
What holds a joint that sticks is found with the motion: accelerations are affine in the friction forces, so those are
solved for with which the rates of the joints stay zero.  No spring and no speed has to be chosen.

    slips    until its rate passes through zero; then it sticks, where its friction is enough to hold it, or turns round
    sticks   until what holds it exceeds its friction; then it slips the way it is pushed

The instants are found on the interpolant of the step, by bisection: to rounding, and as exact as the interpolant.

D. E. Stewart, Rigid-body dynamics with friction and impact, SIAM Review 42(1), 2000.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import Plant, State

LOOKS = 3
"""How often a step with an interpolant is looked at between its ends: what happens twice between two looks is
missed."""
HALVINGS = 44
"""Bisections: to rounding."""
ENOUGH = 1e-12
"""By what part a force may exceed the friction that holds it, for rounding."""
UNMET = 1e-9
"""A joint that keeps more than this part of its acceleration is not held."""
RESTED = 1e-9
"""Largest change, as part of the largest rate until then, by which joints that stick are put to rest."""
RESTS = 1e-13
"""A rate below this part of the largest until then is rounding."""


class Stiction:
    """Which joints of a plant stick.

    Args:
        plant: the robot; `plant.sticking` says which of its joints have stiction.
        locks: its locked actuators.
        start: its first state.

    Attributes:
        modes: of every such joint: 1 or -1 where it slips forward or backward, 0 where it sticks.
    """

    def __init__(self, plant: Plant, locks: Locks, start: State) -> None:
        self._plant, self._locks = plant, locks
        self._index = np.array(list(plant.sticking), dtype=int)
        self._friction = np.array(list(plant.sticking.values()))
        rates = self.rates(start)
        self._fastest = float(np.abs(rates).max(initial=0.0))
        self.modes = np.where(np.abs(rates) > RESTS * self._fastest, np.sign(rates), 0.0)

    def rates(self, state: State) -> Array:
        """Rates of its joints, shape (k,)."""
        return np.asarray(self._plant.joint_rows(state, self._index)[0] @ state.v)

    def motion(self, state: State, effort: Array, push: Array | None) -> tuple[Array, Array]:
        """Efforts and acceleration as `Locks.motion` gives them, with the friction of these joints."""
        found = self._solved(state, effort, push)
        return found[0], found[1]

    def settle(self, state: State, effort: Array, push: Array | None) -> bool:
        """Let go joints that are not held, one after the other; whether any was."""
        changed = False
        for _ in range(len(self._index)):
            excess = self.excess(state, effort, push)
            worst = int(excess.argmax())
            if excess[worst] <= ENOUGH:
                break
            self._let_go(worst, state, effort, push)
            changed = True
        return changed

    def _let_go(self, joint: int, state: State, effort: Array, push: Array | None) -> None:
        self.modes[joint] = -np.sign(self.forces(state, effort, push)[joint])

    def forces(self, state: State, effort: Array, push: Array | None) -> Array:
        """Friction on every joint, along its rate, shape (k,); infinite where no friction could hold it, as at the
        moment at which its rate passes through zero while the robot moves on."""
        return self._solved(state, effort, push)[2]

    def excess(self, state: State, effort: Array, push: Array | None) -> Array:
        """By what part what holds every joint exceeds its friction; -1 of those that slip, shape (k,)."""
        forces = np.abs(self.forces(state, effort, push)) / self._friction - 1.0
        return np.where(self.modes == 0.0, forces, -1.0)

    def passed(self, state: State, effort: Array, push: Array | None) -> int | None:
        """A joint whose mode ends at or before a state, or None."""
        turned = np.flatnonzero(self.modes * self.rates(state) < -RESTS * self._fastest)
        if turned.size:
            return int(turned[0])
        if not (self.modes == 0.0).any():
            return None
        excess = self.excess(state, effort, push)
        worst = int(excess.argmax())
        return worst if excess[worst] > ENOUGH else None

    def first(
        self, t: float, end: float, passed: Callable[[float], int | None], looks: int
    ) -> tuple[float, int] | None:
        """When after `t` [s] the first mode ends, and of which joint; None where none does until `end`, as far as so
        many `looks` between show."""
        inside = t
        for beyond in np.linspace(t, end, looks + 2)[1:].tolist():
            joint = passed(beyond)
            if joint is None:
                inside = beyond
                continue
            for _ in range(HALVINGS):
                middle = 0.5 * (inside + beyond)
                if not inside < middle < beyond:
                    break
                found = passed(middle)
                if found is None:
                    inside = middle
                else:
                    beyond, joint = middle, found
            return beyond, joint
        return None

    def late(self, joint: int, state: State, effort: Array, push: Array | None) -> float:
        """How long ago the rate of a joint that slips was zero [s]; 0 for one that sticks."""
        if self.modes[joint] == 0.0:
            return 0.0
        rows, drift = self._plant.joint_rows(state, self._index[[joint]])
        grows = float((rows @ self.motion(state, effort, push)[1] + drift)[0])
        return float((rows @ state.v)[0]) / grows if grows else 0.0

    def switch(self, joint: int, state: State, effort: Array, push: Array | None) -> None:
        """The mode of a joint has ended: what stuck slips, and what slipped sticks, unless `settle` lets it go."""
        if self.modes[joint] == 0.0:
            self._let_go(joint, state, effort, push)
        else:
            self.modes[joint] = 0.0

    def at_rest(self, state: State) -> Array:
        """The velocity of a state with the joints that stick at rest, shape (nv,)."""
        if (self.modes != 0.0).any():
            self._fastest = max(self._fastest, float(np.abs(self.rates(state)).max(initial=0.0)))
        held = self.modes == 0.0
        if not held.any():
            return state.v
        rows = self._plant.joint_rows(state, self._index[held])[0]
        change = np.linalg.lstsq(rows, rows @ state.v, rcond=None)[0]
        # a rate may also pass through zero while the robot moves on
        moves_on = 0.0 < RESTED * self._fastest < np.abs(change).max()
        return state.v if moves_on else np.asarray(state.v - change)

    def _solved(self, state: State, effort: Array, push: Array | None) -> tuple[Array, Array, Array]:
        """Efforts, acceleration, and friction forces."""
        rows, drift = self._plant.joint_rows(state, self._index)
        # the plant has the friction that goes with the sign of the rate; that of the mode stands in its place
        forces = -self.modes * self._friction
        instead = forces + self._friction * np.sign(rows @ state.v)
        known = rows.T @ instead if push is None else push + rows.T @ instead
        held = np.flatnonzero(self.modes == 0.0)
        effort_there, free = self._locks.motion(state, effort, known)
        if not held.size:
            return effort_there, free, forces
        own = rows[held]
        response = np.empty((held.size, held.size))
        for column, row in enumerate(own):
            response[:, column] = own @ (self._locks.motion(state, effort, known + row)[1] - free)
        wanted = -(own @ free + drift[held])
        found = np.linalg.lstsq(response, wanted, rcond=1e-12)[0]
        if not np.isfinite(found).all():
            raise InputError("what holds the joints that stick cannot be told: the posture is singular")
        left = response @ found - wanted
        sizes = np.abs(wanted) + np.abs(own) @ np.abs(free) + np.abs(drift[held])
        effort_there, moved = self._locks.motion(state, effort, known + own.T @ found)
        forces = forces.copy()
        forces[held] = np.where(np.abs(left) > UNMET * sizes, np.copysign(np.inf, wanted), found)
        return effort_there, moved, forces
