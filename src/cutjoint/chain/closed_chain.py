"""The closed robot in actuated coordinates: a `Mechanism` wherever the actuators determine the motion.

With K = [K_a K_p] the constraint Jacobian, split into actuated and passive columns,

    v_full = T v,   T = [1; -K_p^+ K_a]          a_full = T a + d,   d = [0; -K_p^+ K_dot v_full]
    mass = T' M T,  coriolis = T' (M d + C v_full),  gravity = T' g

where M, C and g of the tree come from Pinocchio (crba, rnea).  The pseudo-inverse keeps exactly as many singular
values as there are passive velocities, so redundant rows do no harm and a singular posture raises an error.

Idle motions, such as a rod between two balls that spins about itself, need no actuator: T gives them no momentum
(`cutjoint.chain.tangent`), and they accelerate as no motor pushes them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
import pinocchio as pin

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.closing.closing import FullChain
from cutjoint.chain.closing.continuation import ActuatedDriver, Driver, Stopped, ToolDriver
from cutjoint.chain.closing.walking import Walker
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.reduced import Reduced
from cutjoint.description.model import RobotDescription
from cutjoint.errors import ClosureError, SingularError, UnreachableError
from cutjoint.mechanism import Posture, Terms, Tool

if TYPE_CHECKING:
    from cutjoint import CompiledChain


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
        self._last: Reduced | None = None

    def close(self, q: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The closed posture with actuated coordinates `q`, shape (n,) [m] or [rad], on the branch of `near`.

        The robot is walked there along a path without singular postures, which keeps it on its branch.

        Raises:
            InputError: wrong shape or not finite.
            ClosureError: on this branch the loops cannot be kept closed all the way.
            SingularError: the way leads through a type-2 singularity, where branches meet.
        """
        target = as_vector("q", q, self.n)
        placed = self._placed(near)
        start = placed.q
        quick = self._step(placed, self._drive(start[self._q_index], target))
        if quick is not None:
            return self._posture(quick)
        found = self._walker.walk(start, start[self._q_index], target, self._drive)
        if isinstance(found, Stopped):
            if found.singular:
                raise self._crossing(f"be closed at {self._show(target)}", found, "type-2")
            distance, angle, cut = self._open_gap(found, target)
            raise ClosureError(
                f"{self.name} cannot be closed at {self._show(target)}: from {self._show(start[self._q_index])} it got "
                f"{found.fraction:.1%} of the way, to {self._show(found.q[self._q_index])}, where {found.why} "
                f"(distance to a type-2 singularity {self._type2(self._k.at(found.q)):.2g})"
                + (
                    f"; with the actuators at the target, cut '{cut}' stays {distance:.3g} m, {angle:.3g} rad open"
                    if cut
                    else ""
                ),
                gap=(distance, angle),
                cut=cut,
                progress=found.fraction,
            )
        return self._posture(self._k.at(found))

    def reach(self, p: npt.ArrayLike, near: Posture | None = None) -> Posture:
        """The closed posture with the tool point at `p`, shape (3,) [m], on the branch of `near`.

        The tool is walked there along a line (or two) inside the workspace, which keeps the robot on its branch.  Where
        it can only move on a curve or a surface, it is walked along that.

        Raises:
            InputError: wrong shape, not finite, or the robot has no tool.
            UnreachableError: the tool cannot come there on this branch.
            SingularError: the way leads through a type-1 singularity, where branches meet.
        """
        target = as_vector("p", p, 3, "m")
        self._need_tool()
        placed = self._placed(near)
        goal = target - self._k.origin
        origin = placed.tool_position
        quick = self._step(placed, ToolDriver(origin, goal))
        if quick is not None:
            return self._posture(quick)
        found = self._lead_tool(placed.q, origin, goal)
        if isinstance(found, Stopped):
            if found.singular:
                raise self._crossing(f"reach {np.round(target, 6).tolist()} m", found, "type-1")
            reached = readonly(self._k.at(found.q).tool_position + self._k.origin)
            raise UnreachableError(
                f"{self.name} cannot reach {np.round(target, 6).tolist()} m on this branch: "
                f"it got {found.fraction:.1%} of the way, to {np.round(reached, 6).tolist()} m, where {found.why}; "
                "choose a target inside the workspace or start from a posture of another working mode",
                target=readonly(target),
                reached=reached,
                progress=found.fraction,
            )
        return self._posture(self._k.at(found))

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
        return self._tangent(at).map @ as_vector("v", v, self.n)

    def drift(self, at: Posture, v: npt.ArrayLike) -> Array:
        """d with a_full = T @ a + d, shape (nv,): what the passive joints accelerate at constant actuator speed."""
        tangent, v_full = self._tangent(at), self.full_velocity(at, v)
        drift = tangent.drift(v_full)
        if tangent.idle.size:
            drift = drift - tangent.idle @ (tangent.idle.T @ self._k.forces(at.q_full, v_full, drift))
        return drift

    def tool(self, at: Posture, v: npt.ArrayLike | None = None) -> Tool:
        """Position, Jacobian (3, n) and J_dot v of the tool point in world axes.

        Raises:
            InputError: the robot has no tool, or `at` is another robot's posture.
            ActuationError, SingularError: as `tangent`.
        """
        self._need_tool()
        tangent = self._tangent(at)
        if v is None:
            placed, drift = tangent.placed, np.zeros(3)
        else:
            v_full = self.full_velocity(at, v)
            placed = moving = self._k.moving(at.q_full, v_full)
            drift = moving.tool_drift + moving.tool_jacobian[:3] @ tangent.drift(v_full)
        return Tool(placed.tool_position + self._k.origin, placed.tool_jacobian[:3] @ tangent.map, drift)

    def terms(self, at: Posture, v: npt.ArrayLike | None = None) -> Terms:
        """Mass matrix (n, n), Coriolis vector (n,) and gravity (n,) in actuated coordinates.

        Raises:
            ActuationError, SingularError: as `tangent`.
        """
        tangent, q = self._tangent(at), at.q_full
        mass, gravity = self._k.mass(q), self._k.gravity(q)
        coriolis = np.zeros(self.n)
        if v is not None:
            v_full = self.full_velocity(at, v)
            drift = tangent.drift(v_full)
            coriolis = tangent.transposed @ (self._k.forces(q, v_full, drift) - gravity)
        reduced = tangent.transposed @ mass @ tangent.map
        return Terms(0.5 * (reduced + reduced.T), coriolis, tangent.transposed @ gravity)

    def potential_energy(self, at: Posture) -> float:
        """Potential energy of gravity [J], zero at the world origin."""
        k = self._k
        near = float(pin.computePotentialEnergy(k.model, k.data, self._placed(at).q))
        if not k.origin.any():
            return near
        mass = sum(inertia.mass for inertia in list(k.model.inertias)[1:])
        return near - float(mass * np.array(k.model.gravity.linear) @ k.origin)

    def inverse_dynamics(self, at: Posture, v: npt.ArrayLike, a: npt.ArrayLike) -> Array:
        """Effort that gives the acceleration `a`, shape (n,): T' rnea(q, T v, T a + d).

        Raises:
            InputError, ActuationError, SingularError: as `tangent`.
        """
        tangent = self._tangent(at)
        v_full = tangent.map.dot(as_vector("v", v, self.n))
        full = tangent.map.dot(as_vector("a", a, self.n)) + tangent.drift(v_full)
        k = self._k
        return np.asarray(tangent.transposed.dot(pin.rnea(k.model, k.data, at.q_full, v_full, full)))

    def forward_dynamics(self, at: Posture, v: npt.ArrayLike, effort: npt.ArrayLike) -> Array:
        """Acceleration that `effort` gives, shape (n,): (T' M T)^-1 (effort - T' rnea(q, T v, d)).

        Raises:
            InputError, ActuationError, SingularError: as `tangent`.
        """
        tangent = self._tangent(at)
        v_full = tangent.map.dot(as_vector("v", v, self.n))
        k = self._k
        held = pin.rnea(k.model, k.data, at.q_full, v_full, tangent.drift(v_full))
        push = as_vector("effort", effort, self.n) - tangent.transposed.dot(held)
        return np.asarray(tangent.inverse_mass.dot(push))

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

    def __reduce__(self) -> tuple[Callable[..., ClosedChain], tuple[RobotDescription, str | None]]:
        """Built anew from its description, in another process too."""
        return type(self), (self.description, self._home_name)

    def _tangent(self, at: Posture) -> Reduced:
        """Tangent map of a posture; that of the last one is kept, since several calls at one posture are the rule."""
        last = self._last
        if last is None or last.posture is not at:
            placed = self._placed(at)
            quick = self._nearby.tangent(placed) if self._nearby is not None else None
            last = Reduced(self._k, self._passive, at, placed, self._map(placed) if quick is None else quick)
            self._last = last
        return last

    def _step(self, start: Placed, driver: Driver) -> Placed | None:
        """A short way in one go, where that is plainly on the same branch."""
        return self._nearby.follow(start, driver) if self._nearby is not None else None

    @cached_property
    def _walker(self) -> Walker:
        return Walker(self._k, self._assembler, self._drive, self._regular)

    def _drive(self, origin: Array, goal: Array) -> ActuatedDriver:
        """Leads the actuated coordinates from `origin` to `goal`, shape (n,)."""
        return ActuatedDriver(self._q_index, self._selection, self._actuated_lengths, origin, goal)

    def _lead_tool(self, start: Array, origin: Array, goal: Array) -> Array | Stopped:
        """Walk the tool from `origin` to `goal` in the model: straight, else along what it can reach at all."""
        found = self._walker.walk(start, origin, goal, ToolDriver)
        if not isinstance(found, Stopped) or (found.singular and found.fraction == 0.0):
            return found
        there, now = ToolDriver(goal, goal), self.actuated
        beside: Array | None = None

        def tangent(placed: Placed) -> Array:
            return self._map(placed).map

        if self.n == 1:
            beside = self._walker.along_curve(start, there, now, tangent)
        elif self._is_determined and self._structure.directions == 2:
            beside = self._walker.over_surface(start, there, now, tangent)
        return found if beside is None else beside

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
        return self._k.at(q).gap
