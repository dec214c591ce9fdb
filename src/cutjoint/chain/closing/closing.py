"""Closing one robot: by its actuators, by its tool, from any configuration, and back from an integrator's drift."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.continuation import Stopped
from cutjoint.chain.closing.drivers import Driver, ToolDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settled
from cutjoint.chain.closing.short_steps import short_way
from cutjoint.chain.closing.walking import Walker
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.rank import null_space
from cutjoint.errors import ClosureError, SingularError, UnreachableError
from cutjoint.mechanism import Posture


class Closing:
    """The ways to closed postures of one robot; what they raise is said in `ClosedChain`."""

    def __init__(self, mobility: Mobility) -> None:
        self._mobility, self._postures, self._walker = mobility, mobility.postures, Walker(mobility)
        self._k, self._actuated = mobility.postures.k, mobility.postures.actuated

    def posture(self, q_full: npt.ArrayLike) -> Posture:
        """A configuration (nq,) that is closed already."""
        q = readonly(as_vector("q_full", q_full, self._k.model.nq))
        placed = self._k.at(q)
        if System(self._k, None).at(placed).openness > 1.0:
            distance, angle, cut = placed.gap
            raise ClosureError(
                f"{self._k.name}: cut '{cut}' is open by {distance:.3g} m, {angle:.3g} rad; use close(), reach() or "
                "assemble()",
                gap=(distance, angle),
                cut=cut,
            )
        return self._postures.make(placed)

    def assemble(self, q_full: npt.ArrayLike, keep_actuators: bool) -> Posture:
        """A closed posture from any configuration (nq,), with the actuators kept where they are, or not."""
        start = self._k.tree.normalised(as_vector("q_full", q_full, self._k.model.nq))
        return self._postures.make(assembled(self._k, start, self._actuated.hold(start) if keep_actuators else None))

    def project(self, q_full: Array, v_full: Array) -> tuple[Array, Array]:
        """Nearby closed configuration (nq,) and velocity (nv,)."""
        k, determined = self._k, self._mobility.is_determined
        driver = self._actuated.hold(q_full) if determined else None
        start = k.at(q_full)
        placed = self._short(start, driver) if driver is not None else None
        placed = placed or settled(System(k, driver).at(start), tolerances.STRIDE.value)
        if placed is None:
            distance, angle, cut = start.gap
            raise ClosureError(
                f"{k.name} cannot be projected onto its loops: cut '{cut}' is open by {distance:.3g} m, "
                f"{angle:.3g} rad",
                gap=(distance, angle),
                cut=cut,
            )
        if not determined:
            free = null_space(placed.scaled)
            return placed.q, k.column_scale * (free @ (free.T @ (v_full / k.column_scale)))
        actuated = v_full[self._actuated.v_index]
        quick = self._mobility.quick_tangent(placed)
        if quick is not None:
            return placed.q, quick.map @ actuated
        tangent = self._mobility.tangent(placed)
        driven = tangent.map @ actuated
        if not tangent.idle.size:
            return placed.q, driven
        momentum = tangent.idle.T @ (k.tree.mass_matrix(placed.q) @ (v_full - driven))
        return placed.q, driven + tangent.idle @ momentum

    def close(self, q: npt.ArrayLike, near: Posture | None) -> Posture:
        """The closed posture with actuated coordinates `q` (n,), on the branch of `near`."""
        own = self._actuated
        target = as_vector("q", q, own.n)
        start = self._postures.placed(near)
        origin = own.of(start.q)
        found: Placed | Stopped | None = self._short(start, own.lead(origin, target))
        if found is None:
            found = self._walker.walk(start, origin, target, own.lead)
        if isinstance(found, Stopped):
            raise self._not_closed(found, origin, target)
        return self._postures.make(found)

    def reach(self, p: npt.ArrayLike, near: Posture | None) -> Posture:
        """The closed posture with the tool point at `p` (3,), on the branch of `near`."""
        target = as_vector("p", p, 3, "m")
        self._k.need_tool()
        start = self._postures.placed(near)
        goal, origin = target - self._k.origin, start.tool_position
        found: Placed | Stopped | None = self._short(start, ToolDriver(origin, goal))
        if found is None:
            found = self._lead_tool(start, origin, goal)
        if isinstance(found, Stopped):
            raise self._not_reached(found, target)
        return self._postures.make(found)

    def _short(self, start: Placed, driver: Driver) -> Placed | None:
        """A short way in one go, where that is plainly on the same branch."""
        quick = self._mobility.quick
        return short_way(quick, start, driver) if quick is not None else None

    def _lead_tool(self, start: Placed, origin: Array, goal: Array) -> Placed | Stopped:
        """Walk the tool from `origin` to `goal` in the model: straight, else along what it can reach at all."""
        found = self._walker.walk(start, origin, goal, ToolDriver)
        if not isinstance(found, Stopped) or (found.singular and found.fraction == 0.0):
            return found
        there, beside = ToolDriver(goal, goal), None
        if self._actuated.n == 1:
            beside = self._walker.along_curve(start, there)
        elif self._mobility.is_determined and self._mobility.structure.directions == 2:
            beside = self._walker.over_surface(start, there)
        return found if beside is None else beside

    # ---- what stopped a walk ---------------------------------------------------------------------------------------

    def _not_closed(self, stopped: Stopped, origin: Array, target: Array) -> ClosureError | SingularError:
        k, show, last = self._k, self._actuated.show, stopped.placed
        if stopped.singular:
            return self._crossing(f"be closed at {show(target)}", stopped, "type-2")
        q = last.q.copy()
        q[self._actuated.q_index] = target
        distance, angle, cut = k.at(q).gap
        opened = f"; with the actuators at the target, cut '{cut}' stays {distance:.3g} m, {angle:.3g} rad open"
        return ClosureError(
            f"{k.name} cannot be closed at {show(target)}: from {show(origin)} it got {stopped.fraction:.1%} of the "
            f"way, to {show(self._actuated.of(last.q))}, where {stopped.why} (distance to a type-2 singularity "
            f"{self._mobility.type2(last):.2g}){opened if cut else ''}",
            gap=(distance, angle),
            cut=cut,
            progress=stopped.fraction,
        )

    def _not_reached(self, stopped: Stopped, target: Array) -> UnreachableError | SingularError:
        wanted = np.round(target, 6).tolist()
        if stopped.singular:
            return self._crossing(f"reach {wanted} m", stopped, "type-1")
        reached = readonly(stopped.placed.tool_position + self._k.origin)
        return UnreachableError(
            f"{self._k.name} cannot reach {wanted} m on this branch: it got {stopped.fraction:.1%} of the way, to "
            f"{np.round(reached, 6).tolist()} m, where {stopped.why}; choose a target inside the workspace or start "
            "from a posture of another working mode",
            target=readonly(target),
            reached=reached,
            progress=stopped.fraction,
        )

    def _crossing(self, what: str, stopped: Stopped, kind: str) -> SingularError:
        return SingularError(
            f"{self._k.name} cannot {what} without leaving its branch: {stopped.fraction:.1%} of the way, at "
            f"{self._actuated.show(self._actuated.of(stopped.placed.q))}, {stopped.why} (distance to a {kind} "
            f"singularity {stopped.measure:.2g}); start from a posture beyond it",
            kind=kind,
            measure=stopped.measure,
            limit=tolerances.SINGULAR.value,
        )
