"""Actuators that are locked: brakes hold them where they are, and what a brake gives is found with the motion.

Accelerations are affine in the efforts.  With a0 the acceleration without the brakes and B what a unit effort of each
locked actuator changes, the brakes give the x with (a0 + B x) = 0 in the locked coordinates: no spring, no stiffness to
choose.  B comes from differences of a function that is affine, so the solution is put into it and mended until the
locked coordinates are at rest to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.errors import InputError, UnknownNameError
from cutjoint.simulation.plant import Plant, State

LEFT = 1e-9
"""Part of the accelerations without brakes that may be left in the locked coordinates; with more the brakes do not
hold."""
FLOOR = 1e-11
"""What may be left in any case [m/s2] or [rad/s2]."""
ROUNDS = 4


class Locks:
    """The locked actuators of a plant, none or some.

    Attributes:
        names: of the locked actuators, in the robot's order.

    Raises:
        UnknownNameError: the robot has no such actuator.
        InputError: one is named twice, or is not among the plant's velocities.
    """

    def __init__(self, plant: Plant, names: str | Sequence[str]) -> None:
        known = [one.name for one in plant.mechanism.actuators]
        given = (names,) if isinstance(names, str) else tuple(names)
        for name in given:
            if name not in known:
                raise UnknownNameError("actuator", str(name), known)
            if given.count(name) > 1:
                raise InputError(f"actuator '{name}' is locked twice")
        self.names = tuple(name for name in known if name in given)
        self._plant = plant
        self._index = [known.index(name) for name in self.names]
        self._rows = plant.actuated[self._index]
        for name, row in zip(self.names, self._rows, strict=True):
            if row < 0:
                raise InputError(
                    f"actuator '{name}' is no coordinate of {plant.name}, so it cannot be locked there; simulate it in "
                    "full coordinates (ConstrainedPlant)"
                )

    def check_rest(self, state: State) -> None:
        """Raises InputError where a locked actuator moves."""
        speeds = state.v[self._rows]
        if speeds.any():
            told = ", ".join(f"'{name}' at {speed:.6g}" for name, speed in zip(self.names, speeds, strict=True))
            raise InputError(f"locked actuators are at rest, found {told}; start without their speed")

    def holding(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """`effort` (n,) of which the locked actuators' part is what holds them."""
        return self.motion(state, effort, push)[0] if self._index else effort

    def motion(self, state: State, effort: Array, push: Array | None = None) -> tuple[Array, Array]:
        """Efforts with what the brakes give, shape (n,), and the acceleration under them and under what loads do
        (`Plant.pushed`), shape (nv,).

        Raises:
            CutjointError: the state is singular or not closed, or cannot be held by these actuators.
        """
        if not self._index:
            return effort, self._plant.acceleration(state, effort, push)
        rows, held = self._rows, np.array(effort)
        held[self._index] = 0.0
        free = self._plant.acceleration(state, held, push)
        response = np.empty((free.size, len(rows)))
        for column, actuator in enumerate(self._index):
            trial = held.copy()
            trial[actuator] = 1.0
            response[:, column] = self._plant.acceleration(state, trial, push) - free
        found = free
        for _ in range(ROUNDS):
            held[self._index] -= np.linalg.lstsq(response[rows], found[rows], rcond=LEFT)[0]
            found = np.array(self._plant.acceleration(state, held, push))
            if np.abs(found[rows]).max() <= FLOOR:
                break
        if not np.abs(found[rows]).max() <= FLOOR + LEFT * np.abs(free).max():
            left = float(np.abs(found[rows]).max())
            raise InputError(f"brakes on {', '.join(self.names)} cannot hold: what they lock accelerates by {left:.3g}")
        found[rows] = 0.0
        return held, found
