"""Loads from outside during a run: constant, over time, or as a function of the state, such as a wall or a spring."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

from cutjoint.arrays import Array
from cutjoint.errors import InputError
from cutjoint.mechanism import Load, Loads
from cutjoint.mechanism.loads import as_loads
from cutjoint.plugins import guarded
from cutjoint.simulation.plant import Observation, Plant, State

RunLoads: TypeAlias = Loads | Callable[[float, Observation], Loads]
"""Loads, or a function (time [s], what is seen of the state) -> loads."""


class Pushing:
    """Loads on a plant over a run.

    Args:
        plant: the robot.
        given: the loads.

    Raises:
        InputError: they are neither loads nor a function.
    """

    def __init__(self, plant: Plant, given: RunLoads) -> None:
        self._plant, self._function = plant, None
        self._constant: tuple[Load, ...] = ()
        if callable(given) and not isinstance(given, Load):
            self._function = given
            self._told = f"the loads' function '{getattr(given, '__name__', type(given).__name__)}'"
        else:
            self._constant = as_loads(given)

    @property
    def about(self) -> str | list[dict[str, object]]:
        """For result files: each load in numbers, or the name of the function."""
        if self._function is not None:
            return self._told
        return [
            {
                "link": one.link,
                "force": one.force.tolist(),
                "moment": one.moment.tolist(),
                "point": one.point.tolist(),
                "axes": one.axes,
            }
            for one in self._constant
        ]

    def on(self, t: float, state: State) -> Array:
        """What the loads do at `t` [s] to the velocities of the plant's state, shape (nv,), [N] or [N m].

        Raises:
            InputError: the function raised, or gave no loads.
            UnknownNameError: there is no such link.
        """
        return self._plant.pushed(state, self._constant if self._function is None else self._asked(t, state))

    def _asked(self, t: float, state: State) -> tuple[Load, ...]:
        assert self._function is not None
        found = guarded(self._told, self._function, t, self._plant.observe(state))
        try:
            loads = as_loads(found)  # type: ignore[arg-type]  # it is asked whether they are
        except InputError as error:
            raise InputError(f"{self._told} gives no loads: {error}") from error
        return loads
