"""A plant in actuated coordinates: any `Mechanism`, by its own forward dynamics.

The loops are closed exactly at every evaluation, so nothing drifts.  A robot with idle motions that masses or weights
notice moves in more than its actuated coordinates; it is refused.
"""

from __future__ import annotations

from cutjoint.arrays import Array
from cutjoint.errors import ActuationError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.simulation.plant import Observation, State


class ReducedPlant:
    """The robot as `mechanism` has it, in n coordinates.

    Raises:
        ActuationError: n coordinates do not tell its motion.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        if not getattr(mechanism, "idle_is_cyclic", True):  # only chains have idle motions
            report = mechanism.mobility()  # type: ignore[attr-defined]
            raise ActuationError(
                f"{mechanism.name} has idle motions that its masses or weights notice, such as a rod that is not round "
                f"({', '.join(report.idle)}): they gain momentum, so the actuated coordinates alone do not tell how it "
                "moves; simulate it in full coordinates (ConstrainedPlant)",
                mobility=report.mobility,
                actuators=report.actuators,
                free=report.idle,
            )
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
