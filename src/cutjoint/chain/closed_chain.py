"""The closed robot in actuated coordinates: a `Mechanism` wherever the actuators determine the motion.

With K = [K_a K_p] the constraint Jacobian, split into actuated and passive columns,

    v_full = T v,   T = [1; -K_p^+ K_a]          a_full = T a + d,   d = [0; -K_p^+ K_dot v_full]
    mass = T' M T,  coriolis = T' (M d + C v_full),  gravity = T' g

where M, C and g of the tree come from Pinocchio (crba, rnea).  The pseudo-inverse keeps exactly as many singular
values as there are passive velocities, so redundant rows do no harm and a singular posture raises an error.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.assembly import UNBOUND, ActuatedDriver, Driver, Stopped, ToolDriver
from cutjoint.chain.full import FullChain
from cutjoint.description.model import RobotDescription
from cutjoint.errors import ActuationError, ClosureError, SingularError, UnreachableError
from cutjoint.mechanism import Posture, Terms, Tool

FURTHEST_DETOUR = 2.0 * np.pi
"""Ways longer than this (in radians or link lengths) are walked straight or not at all."""

CURVE_STEP = 0.2
"""How finely a robot with one actuator is searched along its curve, in radians or link lengths."""

if TYPE_CHECKING:
    from cutjoint import CompiledChain


@dataclass(frozen=True, eq=False)
class _Tangent:
    """T of a posture (nv, n), and K_p^+ (passive, rows) where it was found by singular values."""

    posture: Posture
    map: Array
    inverse: Array | None


class ClosedChain(FullChain):
    """A robot with loops, built from its description.

    Args:
        description: the open tree, the cuts, the actuators.
        home: name of the home posture; default the first one, or the zero configuration.

    Raises:
        UnknownNameError: there is no such home posture.
        ClosureError: the loops cannot be closed at home.
    """

    def __init__(self, description: RobotDescription, home: str | None = None) -> None:
        super().__init__(description, home)
        self._last: _Tangent | None = None

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The closed posture with actuated coordinates `q`, shape (n,) [m] or [rad], on the branch of `near`.

        The robot is walked there along a path without singular postures, which keeps it on its branch.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: on this branch the loops cannot be kept closed all the way.
            SingularError: the way leads through a type-2 singularity, where branches meet.
        """
        target = as_vector("q", q, self.n)
        start = self._full(near)

        move = target - start[self._q_index]
        quick = self._nearby.close(start, move) if self._nearby is not None else None
        if quick is not None:
            return self._posture(quick)

        def driver(origin: Array, goal: Array) -> Driver:
            return ActuatedDriver(self._q_index, self._selection, self._actuated_lengths, origin, goal)

        found = self._walk(start, start[self._q_index], target, driver)
        if isinstance(found, Stopped):
            if found.singular:
                raise self._crossing(f"be closed at {self._show(target)}", found, "type-2")
            distance, angle, cut = self._open_gap(found, target)
            raise ClosureError(
                f"{self.name} cannot be closed at {self._show(target)}: from {self._show(start[self._q_index])} it got "
                f"{found.fraction:.1%} of the way, to {self._show(found.q[self._q_index])}, where {found.why} "
                f"(distance to a type-2 singularity {self._type2(found.q):.2g})"
                + (
                    f"; with the actuators at the target, cut '{cut}' stays {distance:.3g} m, {angle:.3g} rad open"
                    if cut
                    else ""
                ),
                gap=(distance, angle),
                cut=cut,
                progress=found.fraction,
            )
        return self._posture(found)

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The closed posture with the tool point at `p`, shape (3,) [m], on the branch of `near`.

        The tool is walked there along a line (or two) inside the workspace, which keeps the robot on its branch.  Where
        it can only move on a curve (one actuator), it is walked along that.

        Raises:
            InputError: wrong shape, not finite, or the robot has no tool.
            UnreachableError: the tool cannot come there on this branch.
            SingularError: the way leads through a type-1 singularity, where branches meet.
        """
        target = as_vector("p", p, 3, "m")
        tool = self._need_tool()
        start = self._full(near)
        self._k.update(start)
        origin = np.array(tool.pose(self._k.data).translation)
        found = self._walk(start, origin, target, lambda here, goal: ToolDriver(tool, here, goal))
        if isinstance(found, Stopped) and self.n == 1:
            on_curve = self._on_curve(start, ToolDriver(tool, target, target))
            found = found if on_curve is None else on_curve
        if isinstance(found, Stopped):
            if found.singular:
                raise self._crossing(f"reach {np.round(target, 6).tolist()} m", found, "type-1")
            self._k.update(found.q)
            reached = readonly(tool.pose(self._k.data).translation)
            raise UnreachableError(
                f"{self.name} cannot reach {np.round(target, 6).tolist()} m on this branch: "
                f"it got {found.fraction:.1%} of the way, to {np.round(reached, 6).tolist()} m, where {found.why}; "
                "choose a target inside the workspace or start from a posture of another working mode",
                target=readonly(target),
                reached=reached,
                progress=found.fraction,
            )
        return self._posture(found)

    # ---- in actuated coordinates (Mechanism) -----------------------------------------------------------------------

    def tangent(self, at: Posture) -> Array:
        """T with v_full = T @ v, shape (nv, n).

        Raises:
            ActuationError: the actuators do not determine the motion.
            SingularError: type-2 singularity.
        """
        return self._tangent(at).map

    def full_velocity(self, at: Posture, v: npt.ArrayLike) -> Array:
        """Velocity of all joints, shape (nv,)."""
        return self.tangent(at) @ as_vector("v", v, self.n)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,): what the passive joints accelerate at constant actuator speed."""
        return self._drift(at, self.full_velocity(at, v))

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Position, Jacobian (3, n) and J_dot v of the tool point in world axes.

        Raises:
            InputError: the robot has no tool, or `at` is another robot's posture.
            ActuationError, SingularError: as `tangent`.
        """
        tool = self._need_tool()
        tangent = self.tangent(at)
        drift = np.zeros(3)
        if v is None:
            self._k.update(at.q_full)
        else:
            v_full = self.full_velocity(at, v)
            passive = self._drift(at, v_full)
            self._k.update_rates(at.q_full, v_full)
            drift = tool.drift(self._k.data, v_full) + tool.jacobian(self._k.data)[:3] @ passive
        position = tool.pose(self._k.data).translation
        return Tool(position, tool.jacobian(self._k.data)[:3] @ tangent, drift)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix (n, n), Coriolis vector (n,) and gravity (n,) in actuated coordinates.

        Raises:
            ActuationError, SingularError: as `tangent`.
        """
        tangent, data = self.tangent(at), self._k.data
        q = at.q_full
        upper = pin.crba(self.model, data, q)
        mass = np.triu(upper) + np.triu(upper, 1).T
        gravity = np.array(pin.computeGeneralizedGravity(self.model, data, q))
        coriolis = np.zeros(self.n)
        if v is not None:
            v_full = self.full_velocity(at, v)
            drift = self._drift(at, v_full)
            coriolis = tangent.T @ (np.array(pin.rnea(self.model, data, q, v_full, drift)) - gravity)
        reduced = tangent.T @ mass @ tangent
        return Terms(0.5 * (reduced + reduced.T), coriolis, tangent.T @ gravity)

    def potential_energy(self, at: Posture) -> float:
        """Potential energy of gravity [J], zero at the world origin."""
        return float(pin.computePotentialEnergy(self.model, self._k.data, self._full(at)))

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Effort that gives the acceleration `a`, shape (n,): T' rnea(q, T v, T a + d).

        Raises:
            InputError, ActuationError, SingularError: as `tangent`.
        """
        tangent, v_full = self.tangent(at), self.full_velocity(at, v)
        full = tangent @ as_vector("a", a, self.n) + self._drift(at, v_full)
        return np.asarray(tangent.T @ pin.rnea(self.model, self._k.data, at.q_full, v_full, full))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration that `effort` gives, shape (n,), by `pin.constraintDynamics` in full coordinates.

        Raises:
            InputError, ActuationError, SingularError: as `tangent`.
            DynamicsError: the solution does not respect the cuts.
        """
        v_full = self.full_velocity(at, v)
        acceleration = self._dynamics.checked(at.q_full, v_full, self.full_effort(effort))
        return self.actuated_velocity(acceleration)

    def with_payload(self, mass: float) -> ClosedChain:
        """The same robot with a further point mass [kg] at the tool point.

        Raises:
            InputError: no tool, or not a mass.
        """
        return ClosedChain(self.description.with_payload(mass), self._home_name)

    def compile(self) -> CompiledChain:
        """This robot as straight-line machine code; `cutjoint.compiled` has the options.

        Raises:
            CompileError: the extra `compile` is not installed, or the robot cannot be compiled.
        """
        from cutjoint import CompiledChain, compiled

        robot = compiled(self)
        assert isinstance(robot, CompiledChain)
        return robot

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _tangent(self, at: Posture) -> _Tangent:
        """Tangent map of a posture; that of the last one is kept, since several calls at one posture are the rule."""
        if self._last is None or self._last.posture is not at:
            q = self._full(at)
            self._need_determined()
            self._last = _Tangent(at, *self._tangent_at(q))
        return self._last

    def _drift(self, at: Posture, v_full: Array) -> Array:
        tangent = self._tangent(at)
        if tangent.inverse is None and self._nearby is not None:
            return self._nearby.drift(at.q_full, v_full, tangent.map)
        drift = np.zeros(self.nv)
        if tangent.inverse is not None:
            self._k.update_rates(at.q_full, v_full)
            drift[self._passive] = -(tangent.inverse @ self._k.closure.drift(self._k.data, v_full))
        return drift

    def _need_determined(self) -> None:
        report = self._determined
        if report.determined:
            return
        if report.free:
            why = f"with all actuators locked these joints still move: {', '.join(report.free)}"
        else:
            why = f"{report.actuators - report.mobility} actuators more than the mobility depend on the others"
        raise ActuationError(
            f"the actuators of {self.name} do not determine its motion: mobility {report.mobility}, actuators "
            f"{report.actuators}; {why}. Full coordinates still work",
            mobility=report.mobility,
            actuators=report.actuators,
            free=report.free,
        )

    def _walk(
        self, q: Array, origin: Array, target: Array, driver: Callable[[Array, Array], Driver]
    ) -> Array | Stopped:
        """Follow the straight line from `origin` to `target`, or where it leaves the workspace, a detour of two lines.

        A detour is tried only where the robot can be closed at the target at all, and only for short ways.
        """
        line = driver(origin, target)
        straight = self._assembler.follow(q, line)
        if not isinstance(straight, Stopped) or straight.far:
            return straight
        if self._assembler.assemble(straight.q, driver(target, target)) is None:
            return replace(straight, why=UNBOUND, singular=False) if straight.singular else straight
        if np.abs((target - origin) / np.where(line.is_length, self.length, 1.0)).max(initial=0.0) > FURTHEST_DETOUR:
            return straight
        for corner in _detours(origin, target, self.length):
            there = self._assembler.follow(q, driver(origin, corner))
            if isinstance(there, Stopped):
                continue
            found = self._assembler.follow(there, driver(corner, target))
            if not isinstance(found, Stopped):
                return found
        return straight

    def _on_curve(self, start: Array, driver: ToolDriver) -> Array | None:
        """Configuration of a robot with one actuator that meets the driver, within half a turn either way."""
        passed: list[Array] = []
        for stride in (CURVE_STEP, -CURVE_STEP):
            step = np.where(self._actuated_lengths, stride * self.length, stride)
            q: Array | Stopped = start
            for _ in range(int(np.pi / CURVE_STEP) + 1):
                if isinstance(q, Stopped):
                    break
                passed.append(q)
                now = q[self._q_index]
                q = self._assembler.follow(
                    q, ActuatedDriver(self._q_index, self._selection, self._actuated_lengths, now, now + step)
                )

        def miss(q: Array) -> float:
            self._k.update(q)
            return float(np.linalg.norm(driver.error(self._k.data, q, 1.0)))

        for nearest in sorted(passed, key=miss)[:3]:
            found = self._assembler.assemble(nearest, driver)
            if found is not None and np.abs(pin.difference(self.model, nearest, found)).max() < 2.0 * CURVE_STEP:
                return found
        return None

    def _crossing(self, what: str, stopped: Stopped, kind: str) -> SingularError:
        return SingularError(
            f"{self.name} cannot {what} without leaving its branch: {stopped.fraction:.1%} of the way, at "
            f"{self._show(stopped.q[self._q_index])}, {stopped.why} (distance to a {kind} singularity "
            f"{stopped.measure:.2g}); start from a posture beyond it",
            kind=kind,
            measure=stopped.measure,
            limit=tolerances.SINGULAR.value,
        )

    def _open_gap(self, stopped: Stopped, target: Array) -> tuple[float, float, str]:
        """Gaps that stay with the actuators moved on to `target` from where `_walk` stopped."""
        q = stopped.q.copy()
        q[self._q_index] = target
        self._k.update(q)
        return self._k.gap(q)


def _detours(origin: Array, target: Array, length: float) -> Iterator[Array]:
    """Points beside the middle of a line, by half and by the whole of its length, in all directions across it."""
    line = target - origin
    size = max(float(np.linalg.norm(line)), 0.5 * length)
    across = np.linalg.svd(line[None, :])[2][1:]
    for reach in (0.5, 1.0):
        for direction in across:
            for sign in (1.0, -1.0):
                yield 0.5 * (origin + target) + sign * reach * size * direction
