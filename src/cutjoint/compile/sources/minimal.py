"""A closed chain as a source of expressions in minimal coordinates, whatever drives it."""

from __future__ import annotations

import json
from collections.abc import Sequence

from cutjoint.chain.minimal import MinimalCoordinates
from cutjoint.compile.equations.carried import Carried
from cutjoint.compile.equations.coordinates import from_rate_derivatives, moved, turning_axes
from cutjoint.compile.equations.turned import Turned
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.once import once
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.compile.sources.chain_state import ChainState
from cutjoint.compile.sources.interface import Need
from cutjoint.errors import CompileError, CutjointError, InputError


class MinimalState(ChainState):
    """A state whose independent velocities are those of minimal coordinates."""

    def __init__(
        self, source: MinimalSource, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]
    ) -> None:
        super().__init__(source, graph, q, parameters)
        self._inner = self.reduction
        if not source.minimal.is_flat:
            self.reduction = Turned(self._inner, source.actuated_rates)

    def settled(self, target: Sequence[Number] | None) -> tuple[list[Number], list[Number]]:
        """One Newton step towards closed loops while the coordinates change by `target`; to first order where bodies
        turn."""
        change = [0.0] * self.reduction.n if target is None else list(target)
        return moved(self.pose, self.reduction.correction(change)), self.reduction.residuals

    def full_drift(self, v: Sequence[Number]) -> list[Number]:
        u, motion, drift = self.moving(v)
        if isinstance(self._inner, Carried):
            drift = self._inner.undriven(u, motion, drift, turning_axes(self.pose, u, motion), self._passive(u))
        return from_rate_derivatives(self.pose, u, motion, drift)


class MinimalSource(ChainSource):
    """A closed chain to be traced in minimal coordinates: what the base class calls actuated are these."""

    def __init__(self, minimal: MinimalCoordinates) -> None:
        super().__init__(minimal.chain)
        self.minimal = minimal
        self.name = f"{minimal.chain.name}, minimal"
        self.actuated_rates = tuple(int(i) for i in minimal.v_index)

    def __reduce__(self) -> tuple[object, ...]:
        return MinimalSource, (self.minimal,)

    @once
    def n(self) -> int:
        """Number of coordinates."""
        return self.minimal.n

    @once
    def idle(self) -> int | None:
        """Number of idle freedoms."""
        return self.minimal.idle

    def need_all_rows(self) -> None:
        """Check that there is something to compile.

        Raises:
            CompileError: there is no coordinate, or the loops close only without some of their rows.
        """
        if self.n == 0:
            raise CompileError(f"{self.name} has no coordinate, as its loops hold it: there is nothing to compile")
        super().need_all_rows()

    def lacks(self, need: Need) -> CutjointError | None:
        if need in (Need.TASK, Need.PARAMETERS):
            return InputError(f"functions in minimal coordinates of {self.chain.name} have no task and no parameters")
        return super().lacks(need)

    def state(self, graph: Graph, q: Sequence[Expression], parameters: Sequence[Expression]) -> MinimalState:
        """The state at the configuration `q` (Pinocchio's layout)."""
        return MinimalState(self, graph, q, parameters)

    @once
    def content(self) -> str:
        """Everything that the expressions depend on."""
        found = ChainSource.content.function(self)
        return json.dumps({"minimal": self.actuated_rates, "chain": found})
