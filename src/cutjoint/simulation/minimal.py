"""A plant in minimal coordinates: robots that fly, or have fewer motors than freedoms, without drift of the loops.

The state is the whole configuration with the independent velocities.  The loops are closed exactly at every evaluation
by a motion of the independent joints, so nothing has to be put back.  Where bodies turn freely the chart is the
exponential one of their joints, so that the order of the integrator is the order of the simulation.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint.arrays import Array, as_vector
from cutjoint.chain import ClosedChain
from cutjoint.doors import door
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Loads, Posture, Tool
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.reprs import line
from cutjoint.simulation.plant import Observation, State, tool_turns


class Coordinates(Protocol):
    """Minimal coordinates: those of a chain (`cutjoint.chain.minimal.MinimalCoordinates`), or compiled ones."""

    name: str
    chain: ClosedChain
    joints: tuple[str, ...]
    n: int
    v_index: Array
    is_flat: bool
    idle_is_cyclic: bool

    def moved(self, at: Posture, change: npt.ArrayLike) -> Posture: ...
    def tangent(self, at: Posture) -> Array: ...
    def drift(self, at: Posture, v: npt.ArrayLike) -> Array: ...
    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array: ...
    def effort_map(self, at: Posture) -> Array: ...
    def accelerated(self, at: Posture, v: npt.ArrayLike, force: npt.ArrayLike) -> Array: ...
    def load_effort(self, at: Posture, loads: Loads) -> Array: ...
    def pushes_idle(self, at: Posture, loads: Loads) -> bool: ...
    def kinetic_energy(self, at: Posture, v: npt.ArrayLike) -> float: ...
    def tool(self, at: Posture) -> Tool: ...


# long: what every `Plant` has, a few lines a method
@door
class MinimalPlant:
    """A robot in its minimal coordinates.

    Args:
        minimal: the coordinates, of `ClosedChain.minimal`, compiled or not.

    Raises:
        InputError: the robot has no tool to record.
        ActuationError: the coordinates do not tell its motion: idle motions gain momentum.
    """

    __repr__ = line("name")

    def __init__(self, minimal: Coordinates) -> None:
        chain = minimal.chain
        if chain.description.tool is None:
            raise InputError(f"{chain.name} has no tool frame to simulate; name one under [tool] in its loops.toml")
        if not minimal.idle_is_cyclic:
            report = chain.mobility()
            raise ActuationError(
                f"{chain.name} has idle motions that its masses or weights notice ({', '.join(report.idle)}); name "
                "those joints in chain.minimal(joints) too",
                mobility=report.mobility,
                actuators=report.actuators,
                free=report.idle,
            )
        self.minimal, self.chain = minimal, chain
        rows = np.rint(chain.actuated_velocity(np.arange(chain.nv, dtype=np.float64))).astype(np.intp)
        place = {int(index): k for k, index in enumerate(minimal.v_index)}
        self.actuated = np.array([place.get(int(row), -1) for row in rows], dtype=np.intp)
        self._index = self._flat_index()
        self._turns = tool_turns(minimal, chain.home, chain.length)

    def __reduce__(self) -> tuple[object, ...]:
        return type(self), (self.minimal,)

    def _flat_index(self) -> Array | None:
        """Where the coordinates are in a configuration, shape (n,); None where bodies turn freely."""
        if not self.minimal.is_flat:
            return None
        model = self.chain.model
        index = [int(model.idx_qs[joint]) + k for joint in self._joints() for k in range(model.nqs[joint])]
        return np.array(index, dtype=int)

    def _joints(self) -> list[int]:
        return [int(self.chain.model.getJointId(name)) for name in self.minimal.joints]

    @property
    def mechanism(self) -> ClosedChain:
        """The closed robot."""
        return self.chain

    @property
    def name(self) -> str:
        """For messages and tables."""
        return f"{self.minimal.name}, minimal"

    def start(self, posture: Posture, v: Array) -> State:
        """At `posture` with actuated velocity `v`, the other independent velocities zero; `state` starts with all of
        them.

        Raises:
            InputError: an actuator moves that is no coordinate.
        """
        moving = np.zeros(self.minimal.n)
        if v[self.actuated < 0].any():
            names = [one.name for one, k in zip(self.chain.actuators, self.actuated, strict=True) if k < 0]
            raise InputError(
                f"the actuators {', '.join(names)} of {self.chain.name} move as its coordinates make them move; start "
                "with plant.state(posture, v) instead, v of the coordinates"
            )
        own = self.actuated >= 0
        moving[self.actuated[own]] = v[own]
        return self.state(posture, moving)

    def state(self, posture: Posture, v: npt.ArrayLike) -> State:
        """The state at `posture` with independent velocities `v`, shape (n,)."""
        closed = self.minimal.moved(posture, np.zeros(self.minimal.n))
        return State(closed.q_full, as_vector("v", v, self.minimal.n), closed)

    def chart(self, state: State) -> Array:
        """The coordinates themselves where they are numbers of the configuration, else motions away from the state."""
        return np.zeros(self.minimal.n) if self._index is None else state.q[self._index]

    def moved(self, origin: State, u: Array, v: Array) -> State:
        """Closed after a motion of the independent joints, on the branch of `origin`."""
        change = u if self._index is None else u - origin.q[self._index]
        posture = self.minimal.moved(_closed(origin), change)
        return State(posture.q_full, v, posture)

    def chart_rate(self, origin: State, state: State) -> Array:
        """du/dt = v, on rotations times the inverse of the exponential's derivative."""
        if self._index is not None:
            return state.v
        rate = pin.dDifference(self.chain.model, origin.q, state.q, pin.ArgumentPosition.ARG1)
        own = self.minimal.v_index
        return np.asarray(rate[np.ix_(own, own)] @ state.v)

    def measured(self, state: State) -> tuple[Array, Array]:
        """Sensors sit at the actuators."""
        at = _closed(state)
        return at.q, self.minimal.effort_map(at).T @ state.v

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """Of the coordinates, shape (n,)."""
        at = _closed(state)
        force = self.minimal.effort_map(at) @ effort
        return self.minimal.accelerated(at, state.v, force if push is None else force + push)

    def pushed(self, state: State, loads: Loads) -> Array:
        """Loads as generalised forces, shape (n,)."""
        at = _closed(state)
        if self.minimal.pushes_idle(at, loads):
            report = self.chain.mobility()
            raise ActuationError(
                f"the loads push an idle motion of {self.chain.name} ({', '.join(report.idle)}), which its coordinates "
                "do not tell; name those joints in chain.minimal(joints) too",
                mobility=report.mobility,
                actuators=report.actuators,
                free=report.idle,
            )
        return self.minimal.load_effort(at, loads)

    @property
    def sticking(self) -> Mapping[int, float]:
        """See `Plant.sticking`."""
        return self.chain.sticking

    def joint_rows(self, state: State, joints: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """See `Plant.joint_rows`."""
        at = _closed(state)
        return self.minimal.tangent(at)[joints], self.minimal.drift(at, state.v)[joints]

    @property
    def dissipates(self) -> bool:
        """See `Plant.dissipates`."""
        return self.chain.dissipates

    def dissipation(self, state: State) -> float:
        """See `Plant.dissipation`."""
        return self.chain.full_dissipation(state.q, self.minimal.full_velocity(_closed(state), state.v))

    def settled(self, state: State) -> tuple[State, float]:
        """Closed already."""
        return state, 0.0

    def observe(self, state: State) -> Observation:
        """What to record."""
        at, v = _closed(state), state.v
        tool = self.minimal.tool(at)
        twist = tool.frame_jacobian @ v
        kinetic, potential = self.minimal.kinetic_energy(at, v), self.chain.potential_energy(at)
        turned = (quaternion_of(tool.rotation), twist[3:]) if self._turns else ()
        return Observation(
            *self.measured(state), tool.position, twist[:3], kinetic, potential, at.gap, at.q_full, *turned
        )


def _closed(state: State) -> Posture:
    assert state.posture is not None, "states of a minimal plant carry their posture"
    return state.posture
