"""What a plant is: the robot that is simulated, as a state on a manifold with a velocity.

Integrators see flat vectors only.  A plant gives them a chart around each accepted state: coordinates u near it, with
du/dt linear in the velocity.  Where the configuration is a vector space the chart is the configuration itself; on
rotations it is the exponential map (Munthe-Kaas), so that the order of the integrator is the order of the simulation.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from cutjoint.arrays import Array, Frozen, Values
from cutjoint.mechanism import Mechanism, Posture


@dataclass(frozen=True, eq=False)
class State(Values):
    """A plant's own state.

    Attributes:
        q: configuration, shape (nq,) in the plant's layout.
        v: velocity, shape (nv,).
        posture: closed posture at `q`, where the plant works with postures.
    """

    q: Array
    v: Array
    posture: Posture | None = None


@dataclass(frozen=True, eq=False)
class Observation(Frozen):
    """What a record of a run holds of one state.

    Attributes:
        q, v: actuated coordinates and velocities, shape (n,).
        tool, tool_velocity: shape (3,), [m] and [m/s].
        kinetic, potential: [J].
        gap: worst loop residual, shape (2,), [m] and [rad].
        q_full: full configuration in the layout of the mechanism's postures.
    """

    q: Array
    v: Array
    tool: Array
    tool_velocity: Array
    kinetic: float
    potential: float
    gap: tuple[float, float]
    q_full: Array


class Plant(Protocol):
    """A robot to simulate."""

    @property
    def name(self) -> str:
        """For messages and tables."""

    @property
    def mechanism(self) -> Mechanism:
        """The model that moves."""

    def start(self, posture: Posture, v: Array) -> State:
        """The state at `posture`, made by `mechanism`, with actuated velocity `v`, shape (n,)."""

    def chart(self, state: State) -> Array:
        """Coordinates u of the state in the chart around itself, shape (nv,)."""

    def moved(self, origin: State, u: Array, v: Array) -> State:
        """The state at `u` in the chart around `origin`, with velocity `v`."""

    def chart_rate(self, origin: State, state: State) -> Array:
        """du/dt in the chart around `origin`, shape (nv,)."""

    def measured(self, state: State) -> tuple[Array, Array]:
        """Actuated coordinates and velocities, shape (n,) each."""

    def acceleration(self, state: State, effort: Array) -> Array:
        """dv/dt under the actuators' `effort`, shape (nv,).

        Raises:
            CutjointError: the state is singular or not closed.
        """

    def settled(self, state: State) -> tuple[State, float]:
        """The state put back onto its loops, and how far off it was [m]."""

    def observe(self, state: State) -> Observation:
        """What to record."""
