"""What a plant is: the robot that is simulated, as a state on a manifold with a velocity.

Integrators see flat vectors only.  A plant gives them a chart around each accepted state: coordinates u near it, with
du/dt linear in the velocity.  Where the configuration is a vector space the chart is the configuration itself; on
rotations it is the exponential map (Munthe-Kaas), so that the order of the integrator is the order of the simulation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from cutjoint.arrays import Array, Frozen, Values, readonly
from cutjoint.chain import ClosedChain
from cutjoint.doors import door
from cutjoint.errors import ActuationError, CutjointError
from cutjoint.mechanism import Loads, Mechanism, Posture, Tool
from cutjoint.mechanism.rotations import quaternion_of
from cutjoint.reprs import line, told

STILL = 1e-9
"""A tool whose turning is below this part of its moving, in lengths of the robot, never turns."""


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

    __repr__ = line(q="m or rad", v="m/s or rad/s")


@dataclass(frozen=True, eq=False)
class Observation(Frozen):
    """What a record of a run holds of one state.

    Attributes:
        q, v: actuated coordinates and velocities, shape (n,).
        tool, tool_velocity: shape (3,), [m] and [m/s].
        kinetic, potential: [J].
        gap: worst loop residual, shape (2,), [m] and [rad].
        q_full: full configuration in the layout of the mechanism's postures.
        orientation, angular_velocity: of the tool, a quaternion x, y, z, w of shape (4,), and (3,) [rad/s] in the axes
            of the world; None of a tool that never turns.
    """

    q: Array
    v: Array
    tool: Array
    tool_velocity: Array
    kinetic: float
    potential: float
    gap: tuple[float, float]
    q_full: Array
    orientation: Array | None = None
    angular_velocity: Array | None = None

    __repr__ = line(
        q="m or rad",
        v="m/s or rad/s",
        tool="m",
        tool_velocity="m/s",
        kinetic="J",
        potential="J",
        gap="m, rad",
        angular_velocity="rad/s",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("orientation", "angular_velocity"):
            if (value := getattr(self, name)) is not None:
                self.__dict__[name] = readonly(value)


class Plant(Protocol):
    """A robot to simulate.

    Attributes:
        actuated: where in a state's velocity the actuators' are, shape (n,); -1 of those that are not in it.
    """

    actuated: npt.NDArray[np.intp]

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

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """dv/dt under the actuators' `effort`, and what `pushed` gave if anything does, shape (nv,).

        Raises:
            CutjointError: the state is singular or not closed.
        """

    def pushed(self, state: State, loads: Loads) -> Array:
        """What loads from outside do to the velocities of the state: their power is this times `v`, shape (nv,).

        Raises:
            InputError, UnknownNameError: they are no loads, or act where there is nothing.
            ActuationError: they move the robot otherwise than `v` tells.
        """

    @property
    def sticking(self) -> Mapping[int, float]:
        """Joints with stiction, as `joint_rows` numbers them, and their friction: [N] or [N m]."""

    def joint_rows(self, state: State, joints: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """Rates of joints by the velocity of a state, shape (k, nv), and what these accelerate beside, shape (k,)."""

    @property
    def dissipates(self) -> bool:
        """Whether it has dampers or friction that may take work."""

    def dissipation(self, state: State) -> float:
        """Power that these take [W], at least 0."""

    def settled(self, state: State) -> tuple[State, float]:
        """The state put back onto its loops, and how far off it was [m]."""

    def observe(self, state: State) -> Observation:
        """What to record."""


class Advanced(NamedTuple):
    """What became of a plant: its state on the loops, the work of its actuators and what friction took [J], how far off
    the loops it was [m], evaluations of the equations of motion, and the step to go on with [s]."""

    state: State
    work: float
    lost: float
    strayed: float
    evaluations: int
    ahead: float

    def __repr__(self) -> str:
        return told(self, work="J", lost="J", strayed="m", ahead="s")


@runtime_checkable
class Advancing(Plant, Protocol):
    """A plant that integrates itself where efforts do not change.

    Attributes:
        method: by which, with its settings.
    """

    method: str

    def advance(self, state: State, effort: Array, span: float, ahead: float) -> Advanced | None:
        """From `state` on over `span` [s] under `effort`, with steps of about `ahead` [s] at first; None where that
        cannot be trusted."""

    def observe_all(self, states: Sequence[State]) -> list[Observation]:
        """What to record of many states."""


@door
class ReducedPlant:
    """Any `mechanism` in its n actuated coordinates, by its own forward dynamics.

    The loops are closed exactly at every evaluation, so nothing drifts.  A robot with idle motions that masses or
    weights notice moves in more than its actuated coordinates; it is refused.

    Raises:
        ActuationError: n coordinates do not tell its motion.
    """

    __repr__ = line("name")

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
        self.actuated = np.arange(mechanism.n)
        self._turns = tool_turns(mechanism, mechanism.home, getattr(mechanism, "length", 1.0))
        robot = getattr(mechanism, "plain", mechanism)  # of a compiled robot, the chain it was made from
        self._idle_chain = robot if isinstance(robot, ClosedChain) else None

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
        """Closed at `u`, on the branch of `origin`.  Joint limits are watched by the loop, at states it accepts."""
        return State(u, v, self.mechanism.close(u, origin.posture, limits="ignore"))

    def chart_rate(self, origin: State, state: State) -> Array:
        """du/dt = v."""
        return state.v

    def measured(self, state: State) -> tuple[Array, Array]:
        """The state itself."""
        return state.q, state.v

    def acceleration(self, state: State, effort: Array, push: Array | None = None) -> Array:
        """Forward dynamics, shape (n,)."""
        return self.mechanism.forward_dynamics(_closed(state), state.v, effort if push is None else effort + push)

    def pushed(self, state: State, loads: Loads) -> Array:
        """Loads as efforts, shape (n,)."""
        at = _closed(state)
        if self._idle_chain is not None and self._idle_chain.pushes_idle(at, loads):
            raise ActuationError(
                f"the loads push an idle motion of {self.mechanism.name}, such as the spin of a rod between two balls, "
                "which the actuated coordinates do not tell; simulate it in full coordinates (ConstrainedPlant)",
                mobility=self.mechanism.n,
                actuators=self.mechanism.n,
                free=(),
            )
        return self.mechanism.load_effort(at, loads)

    @property
    def sticking(self) -> Mapping[int, float]:
        """See `Plant.sticking`: of chains, by the velocities of their trees; published models have none."""
        found: Mapping[int, float] = getattr(self.mechanism, "sticking", {})
        return found

    def joint_rows(self, state: State, joints: npt.NDArray[np.intp]) -> tuple[Array, Array]:
        """See `Plant.joint_rows`."""
        at, chain = _closed(state), self.mechanism
        assert isinstance(chain, ClosedChain), "published models have no stiction"
        return chain.tangent(at)[joints], chain.drift(at, state.v)[joints]

    @property
    def dissipates(self) -> bool:
        """See `Plant.dissipates`."""
        return self.mechanism.dissipates

    def dissipation(self, state: State) -> float:
        """See `Plant.dissipation`."""
        return self.mechanism.dissipation(_closed(state), state.v)

    def settled(self, state: State) -> tuple[State, float]:
        """Closed already."""
        return state, 0.0

    def observe(self, state: State) -> Observation:
        """What to record."""
        at, v = _closed(state), state.v
        tool = self.mechanism.tool(at)
        kinetic = 0.5 * float(v @ self.mechanism.terms(at).mass @ v)
        potential = self.mechanism.potential_energy(at)
        turned = (quaternion_of(tool.rotation), tool.frame_jacobian[3:] @ v) if self._turns else ()
        return Observation(at.q, v, tool.position, tool.jacobian @ v, kinetic, potential, at.gap, at.q_full, *turned)


def _closed(state: State) -> Posture:
    assert state.posture is not None, "states of a reduced plant carry their posture"
    return state.posture


class HasTool(Protocol):
    """What tells a tool: a mechanism, or minimal coordinates."""

    def tool(self, at: Posture) -> Tool: ...


def tool_turns(robot: HasTool, home: Posture, length: float) -> bool:
    """Whether the tool can turn, as far as its motions at `home` tell; yes where they do not.

    Args:
        robot: what has the tool.
        home: where it is asked.
        length: of the robot [m].
    """
    try:
        jacobian = robot.tool(home).frame_jacobian
    except CutjointError:
        return True
    return bool(length * np.abs(jacobian[3:]).max(initial=0.0) > STILL * np.abs(jacobian[:3]).max(initial=0.0))
