"""Stiction: joints whose dry friction holds them while they rest, and lets go when it is not enough.

Every such joint is in one of three modes: it slips forward or backward, with its friction against it, or it sticks.
What holds a joint that sticks is found with the motion: accelerations are affine in the friction forces, so those are
solved for with which the rates of the joints stay zero.  No spring and no speed has to be chosen.

    slips    until its rate passes through zero; then it sticks, where its friction is enough to hold it, or turns round
    sticks   until the friction of all joints that stick is not enough to hold them (`bounded_friction`); then those
             slip that accelerate

The instants are found on the interpolant of the step, by bisection: to rounding, and as exact as the interpolant.

D. E. Stewart, Rigid-body dynamics with friction and impact, SIAM Review 42(1), 2000.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.simulation.bounded_friction import bounded
from cutjoint.simulation.locks import Locks
from cutjoint.simulation.plant import Plant, State

LOOKS = 3
"""How often a step with an interpolant is looked at between its ends: what happens twice between two looks is
missed."""
HALVINGS = 44
"""Bisections: to rounding."""
HELD, LET_GO = 1e-9, 1e-10
"""A joint at rest that accelerates by more than this part of what acts on it ends its mode; and slips from then on."""
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
        """Efforts and acceleration as `Locks.motion` gives them, with the friction of the joints that slip, and those
        that stick at rest."""
        held, known, own = self._acting(state, push)
        if not held.size:
            return self._locks.motion(state, effort, known)
        response, free, drift = self._response(state, effort, known, own, held)
        found = np.linalg.lstsq(response, -(own @ free + drift), rcond=1e-12)[0]
        if not np.isfinite(found).all():
            raise InputError("what holds the joints that stick cannot be told: the posture is singular")
        return self._locks.motion(state, effort, known + own.T @ found)

    def settle(self, state: State, effort: Array, push: Array | None) -> bool:
        """Which of the joints at rest stick and which slip from now on; whether any changes its mode."""
        rests = (self.modes == 0.0) | (np.abs(self.rates(state)) <= RESTS * self._fastest)
        if not rests.any():
            return False
        before = self.modes.copy()
        self.modes[rests] = 0.0
        _, accelerations = self._held(state, effort, push, LET_GO)
        self.modes[rests] = np.sign(accelerations[rests])
        return not np.array_equal(before, self.modes)

    def forces(self, state: State, effort: Array, push: Array | None) -> Array:
        """Friction on every joint, along its rate, shape (k,)."""
        return self._held(state, effort, push, HELD)[0]

    def passed(self, state: State, effort: Array, push: Array | None) -> int | None:
        """A joint whose mode ends at or before a state, or None."""
        turned = np.flatnonzero(self.modes * self.rates(state) < -RESTS * self._fastest)
        if turned.size:
            return int(turned[0])
        if not (self.modes == 0.0).any():
            return None
        _, accelerations = self._held(state, effort, push, HELD)
        worst = int(np.abs(accelerations).argmax())
        return worst if accelerations[worst] else None

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

    def stop(self, joint: int) -> None:
        """The mode of a joint has ended: it is at rest, and `settle` says whether it sticks."""
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

    def _held(self, state: State, effort: Array, push: Array | None, enough: float) -> tuple[Array, Array]:
        """Friction on every joint, and accelerations of those that stick, as far as friction leaves any: those above
        the part `enough` of what acts on them, else 0; shape (k,) each."""
        forces, accelerations = -self.modes * self._friction, np.zeros(len(self.modes))
        held, known, own = self._acting(state, push)
        if held.size:
            response, free, drift = self._response(state, effort, known, own, held)
            bounds = self._friction[held]
            forces[held], left = bounded(response, own @ free + drift, bounds)
            sizes = np.abs(response) @ bounds + np.abs(own) @ np.abs(free) + np.abs(drift)
            accelerations[held] = np.where(np.abs(left) > enough * sizes, left, 0.0)
        return forces, accelerations

    def _acting(self, state: State, push: Array | None) -> tuple[npt.NDArray[np.intp], Array, Array]:
        """Joints that stick; what pushes the plant beside what holds them, shape (nv,); and the rows of their rates."""
        rows = self._plant.joint_rows(state, self._index)[0]
        # the plant has the friction that goes with the sign of the rate; that of the mode stands in its place
        instead = self._friction * (np.sign(rows @ state.v) - self.modes)
        known = rows.T @ instead if push is None else push + rows.T @ instead
        held = np.flatnonzero(self.modes == 0.0)
        return held, known, rows[held]

    def _response(
        self, state: State, effort: Array, known: Array, own: Array, held: npt.NDArray[np.intp]
    ) -> tuple[Array, Array, Array]:
        """Accelerations of the joints that stick by their friction forces (k, k); acceleration without these (nv,); and
        what the joints accelerate beside it (k,)."""
        free = self._locks.motion(state, effort, known)[1]
        columns = [own @ (self._locks.motion(state, effort, known + row)[1] - free) for row in own]
        return np.array(columns).T, free, self._plant.joint_rows(state, self._index)[1][held]
