"""Closing one robot: by its actuators, from any configuration, and back from an integrator's drift."""

from __future__ import annotations

import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.continuation import Stopped
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.newton import settled
from cutjoint.chain.closing.ways import Near, Way, Ways
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.rank import null_space
from cutjoint.errors import ClosureError, SingularError
from cutjoint.mechanism import ActuatedCoordinates, JointLimits, Posture, actuated_values
from cutjoint.mechanism.interface import are_respected


class Closing:
    """The ways to closed postures of one robot; what they raise is said in `ClosedChain`."""

    def __init__(self, mobility: Mobility, ways: Ways) -> None:
        self._mobility, self._postures, self._ways = mobility, mobility.postures, ways
        self._k, self._actuated = mobility.postures.k, mobility.postures.actuated

    def posture(self, q_full: npt.ArrayLike) -> Posture:
        """A configuration (nq,) that is closed already."""
        q = readonly(as_vector("q_full", q_full, self._k.model.nq))
        placed = self._k.at(q)
        if System(self._k, None).at(placed).openness > 1.0:
            distance, angle, cut = placed.gap
            raise ClosureError(
                f"{self._k.name}: {self._k.closure.told(cut)} is open by {distance:.3g} m, {angle:.3g} rad; "
                "use close(), reach() or assemble()",
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
        placed = self._ways.short(start, driver) if driver is not None else None
        placed = placed or settled(System(k, driver).at(start), tolerances.STRIDE.value)
        if placed is None:
            distance, angle, cut = start.gap
            raise ClosureError(
                f"{k.name} cannot be projected onto its loops: {k.closure.told(cut)} is open by {distance:.3g} m, "
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

    def close(self, q: ActuatedCoordinates, near: Near, limits: JointLimits) -> Posture:
        """The closed posture with actuated coordinates `q` (n,), on the branch of `near`."""
        own, respected = self._actuated, are_respected(limits)
        target = actuated_values(q, own.joints)
        start = self._ways.start(near)
        origin = own.of(start.q)
        found: Placed | Stopped | None = self._ways.short(start, own.lead(origin, target))
        if found is None:
            found = self._ways.walker.walk(start, origin, target, own.lead, own.lengths)
        if isinstance(found, Stopped):
            raise self._not_closed(found, origin, target)
        if respected and self._ways.limits.exceeded(start.q, found.q):
            way = Way(start, origin, target, own.lead, own.lengths)
            raise self._ways.beyond_limits(way, found, f"close at {own.show(target)}", target)
        return self._postures.make(found)

    def _not_closed(self, stopped: Stopped, origin: Array, target: Array) -> ClosureError | SingularError:
        k, show, last = self._k, self._actuated.show, stopped.placed
        if stopped.singular:
            return self._ways.crossing(f"be closed at {show(target)}", stopped, "type-2")
        q = last.q.copy()
        q[self._actuated.q_index] = target
        distance, angle, cut = k.at(q).gap
        opened = (
            f"; with the actuators at the target, {k.closure.told(cut)} stays {distance:.3g} m, {angle:.3g} rad open"
        )
        return ClosureError(
            f"{k.name} cannot be closed at {show(target)}: from {show(origin)} it got {stopped.fraction:.1%} of the "
            f"way, to {show(self._actuated.of(last.q))}, where {stopped.why} (distance to a type-2 singularity "
            f"{self._mobility.type2(last):.2g}){opened if cut else ''}",
            gap=(distance, angle),
            cut=cut,
            progress=stopped.fraction,
        )
