"""What a model offers to the compiler: its quantities as expressions of one state.

`TracedState` is to expressions what `Mechanism` is to floats.  There are two ways to get one: a closed chain, whose
tree and loops are traced (`cutjoint.compile.sources.chain`), and a published model, whose own equations are run on
expressions (`cutjoint.compile.sources.paper`).  Everything behind this interface is the same for both.
"""

from __future__ import annotations

from collections.abc import Sequence
from enum import Enum, auto
from typing import NamedTuple, Protocol

from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.errors import CutjointError

PAYLOAD = "payload"
"""Name of the inertial parameter that is a point mass at the tool point [kg]."""


class Need(Enum):
    """What a function may need that not every model has."""

    ACTUATED = auto()
    """Actuators that determine the motion; idle freedoms do not count as motion."""
    TOOL = auto()
    """A tool."""
    JOINTS = auto()
    """Joints beside the actuated ones."""
    TASK = auto()
    """A task that says where the actuators are, and an order of elimination for it."""
    SMOOTH = auto()
    """No friction that jumps at rest (stiction)."""
    PARAMETERS = auto()
    """Parameters that are arguments."""
    CLOSED_FORM = auto()
    """Inverse kinematics in closed form."""


class TracedTool(NamedTuple):
    """Kinematics of a tool; see `cutjoint.mechanism.Tool`.

    Attributes:
        position: (3).
        rotation: (3, 3).
        jacobian: rows of the velocity of the point, then of the angular velocity, (6, n).
        drift, twist: (6).
    """

    position: list[Number]
    rotation: list[list[Number]]
    jacobian: list[list[Number]]
    drift: list[Number]
    twist: list[Number]


class TracedState(Protocol):
    """A state: position variables, and the independent velocities `v` of length n."""

    q: list[Expression]
    """The position variables."""
    strain: Number
    """How badly conditioned the evaluation is; beyond STRAIN_LIMIT, or not a number, nothing here may be used."""

    @property
    def actuated(self) -> list[Number]:
        """Actuated coordinates, length n."""

    def position_rate(self, v: Sequence[Number]) -> list[Number]:
        """Time derivative of the position variables."""

    def full_velocity(self, v: Sequence[Number]) -> list[Number]:
        """Velocities of all joints that the model has."""

    def mass(self) -> list[list[Number]]:
        """Mass matrix, (n, n)."""

    def gravity(self) -> list[Number]:
        """Effort that holds the posture."""

    def coriolis(self, v: Sequence[Number]) -> list[Number]:
        """Coriolis vector."""

    def springs(self) -> list[Number]:
        """Effort that holds springs, bushings and stops."""

    def friction(self, v: Sequence[Number]) -> list[Number]:
        """Effort that overcomes dampers and dry friction."""

    def bias(self, v: Sequence[Number]) -> list[Number]:
        """Effort that keeps the velocity: Coriolis vector, gravity, springs and friction."""

    def inverse(self, v: Sequence[Number], a: Sequence[Number]) -> list[Number]:
        """Effort for the acceleration `a`."""

    def potential(self) -> Number:
        """Potential energy of gravity and springs [J]."""

    def tool(self, v: Sequence[Number]) -> TracedTool:
        """The tool."""

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """Position variables after one Newton step towards closed loops with the actuators at `target` (None: where
        they are), and what the loops are open by now."""


class Source(Protocol):
    """A model that can be traced, with its arguments.

    Attributes:
        name: of the model.
        n: number of independent velocities.
        positions: number of position variables.
        nv: number of velocities of all joints that the model has.
        rows: number of equations of its loops.
        parameters: names of what stays an argument.
        content: all that the traced expressions depend on, as text; sources with the same text trace the same.
    """

    @property
    def name(self) -> str: ...
    @property
    def n(self) -> int: ...
    @property
    def positions(self) -> int: ...
    @property
    def nv(self) -> int: ...
    @property
    def rows(self) -> int: ...
    @property
    def parameters(self) -> tuple[str, ...]: ...
    @property
    def content(self) -> str: ...

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> TracedState:
        """The state at the position variables `q`."""

    def lacks(self, need: Need) -> CutjointError | None:
        """What to raise where the model does not have what a function needs, or None."""


def size(source: Source, symbol: str) -> int:
    """The number that a symbol of a shape stands for: itself, or that quantity of a model."""
    if symbol.isdigit():
        return int(symbol)
    found: int | tuple[str, ...] = getattr(source, symbol)
    return found if isinstance(found, int) else len(found)
