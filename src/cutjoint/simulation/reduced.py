"""A plant in actuated coordinates: any `Mechanism`, by its own forward dynamics.

The loops are closed exactly at every evaluation, so nothing drifts.
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.simulation.plant import Observation, State


class ReducedPlant:
    """The robot as `mechanism` has it, in n coordinates."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism

    @property
    def name(self) -> str:
        """For messages and tables."""
        return f"{self.mechanism.name}, reduced"

    def start(self, posture: Posture, v: Array) -> State:
        """See `Plant.start`."""
        return State(posture.q, v, posture)

    def chart(self, state: State) -> Array:
        """The configuration is a vector space: u = q."""
        return state.q

    def moved(self, origin: State, u: Array, v: Array) -> State:
        """Closed at `u`, on the branch of `origin`."""
        return State(u, v, self.mechanism.close(u, origin.posture))

    def chart_rate(self, origin: State, state: State) -> Array:
        """du/dt = v."""
        return state.v

    def measured(self, state: State) -> tuple[Array, Array]:
        """The state itself."""
        return state.q, state.v

    def acceleration(self, state: State, effort: Array) -> Array:
        """Forward dynamics, shape (n,)."""
        return self.mechanism.forward_dynamics(_closed(state), state.v, effort)

    def settled(self, state: State) -> tuple[State, float]:
        """Closed already."""
        return state, 0.0

    def observe(self, state: State) -> Observation:
        """What to record."""
        at, v = _closed(state), state.v
        tool = self.mechanism.tool(at)
        kinetic = 0.5 * float(v @ self.mechanism.terms(at).mass @ v)
        potential = self.mechanism.potential_energy(at)
        return Observation(at.q, v, tool.position, tool.jacobian @ v, kinetic, potential, at.gap, at.q_full)


def _closed(state: State) -> Posture:
    assert state.posture is not None, "states of a reduced plant carry their posture"
    return state.posture
