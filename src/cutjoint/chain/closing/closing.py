"""Closing one robot: by its actuators, by its tool, from any configuration, and back from an integrator's drift."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array, as_vector, readonly
from cutjoint.chain.build import rough_home
from cutjoint.chain.closing.assembling import assembled
from cutjoint.chain.closing.continuation import Stopped
from cutjoint.chain.closing.drivers import Driver, TaskDriver, ToolDriver
from cutjoint.chain.closing.equations import System
from cutjoint.chain.closing.joint_limits import LimitCheck
from cutjoint.chain.closing.newton import settled
from cutjoint.chain.closing.short_steps import short_way
from cutjoint.chain.closing.walking import Walker
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.rank import null_space
from cutjoint.chain.task import all_motions, task_of
from cutjoint.errors import ClosureError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import ActuatedCoordinates, JointLimits, Posture, Target, Task, actuated_values
from cutjoint.mechanism.interface import are_respected

Near = Posture | str | None
POINT = {0, 1, 2}
"""Rows of a tool's pose that are its point."""

FURTHEST = 1e6
"""Targets further away than this, in lengths of the robot, are refused at once."""


class Way(NamedTuple):
    """A straight way of a robot.

    Attributes:
        start: where it stands.
        origin, goal: places at both ends, as `driver` takes them.
        driver: leads the robot from one place to another.
        lengths: which coordinates of a place are lengths; default all.
    """

    start: Placed
    origin: Array
    goal: Array
    driver: Callable[[Array, Array], Driver]
    lengths: npt.NDArray[np.bool_] | None = None


class Closing:
    """The ways to closed postures of one robot; what they raise is said in `ClosedChain`."""

    def __init__(self, mobility: Mobility) -> None:
        self._mobility, self._postures, self._walker = mobility, mobility.postures, Walker(mobility)
        self._k, self._actuated = mobility.postures.k, mobility.postures.actuated
        self._limits = LimitCheck(self._k)
        self._homes: dict[str, Placed] = {}

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

    def close(self, q: ActuatedCoordinates, near: Near, limits: JointLimits) -> Posture:
        """The closed posture with actuated coordinates `q` (n,), on the branch of `near`."""
        own, respected = self._actuated, are_respected(limits)
        target = actuated_values(q, own.joints)
        start = self._start(near)
        origin = own.of(start.q)
        found: Placed | Stopped | None = self._short(start, own.lead(origin, target))
        if found is None:
            found = self._walker.walk(start, origin, target, own.lead, own.lengths)
        if isinstance(found, Stopped):
            raise self._not_closed(found, origin, target)
        if respected:
            way = Way(start, origin, target, own.lead, own.lengths)
            self._keep_limits(way, found, f"close at {own.show(target)}", target)
        return self._postures.make(found)

    def _keep_limits(self, way: Way, found: Placed, what: str, target: Array) -> None:
        """Raises LimitError where a joint is beyond its limits at the end of a way."""
        beyond = self._limits.beyond(way.start.q, found.q)
        if beyond is None:
            return

        def go(fraction: float) -> Placed | None:
            goal = way.origin + fraction * (way.goal - way.origin)
            there = self._walker.walk(way.start, way.origin, goal, way.driver, way.lengths)
            return None if isinstance(there, Stopped) else there

        raise self._limits.error(beyond, way.start, found, go, what, target)

    def goes_beyond(self, start: Array, q: Array) -> bool:
        """Whether a joint is beyond its limits at `q` (nq,), further than at `start`."""
        return self._limits.beyond(start, q) is not None

    @cached_property
    def task(self) -> Task:
        """The task of the tool, in the world.

        Raises:
            InputError: the robot has no tool, or its task cannot be told, or cannot be done.
        """
        return task_of(self._mobility)

    def reach(self, given: Any, near: Near, free: bool, limits: JointLimits) -> Posture:  # see `Task.target`
        """The closed posture with the tool at a target, on the branch of `near`."""
        k, respected = self._k, are_respected(limits)
        k.need_tool()
        # where the task cannot be told, all motions may be asked for: what is not led is free anyway
        task = (self.known_task or all_motions(self._postures)) if free else self.task
        target = task.target(given, free)
        start = self._start(near)
        way = self._way(task, target, start)
        away = float(np.abs(way.goal - way.origin).max())
        if away > FURTHEST * k.reach:
            raise UnreachableError(
                f"{k.name} cannot reach {target}: that is {away:.3g} m away, and the robot is {k.reach:.3g} m long",
                target=target.pose.position,
            )
        found: Placed | Stopped | None = self._short(start, way.driver(way.origin, way.goal))
        if found is None:
            found = self._lead_tool(way)
        if isinstance(found, Stopped):
            raise self._not_reached(found, target)
        self._check_rest(task, target, found)
        if respected:
            self._keep_limits(way, found, f"reach {target}", target.pose.position)
        return self._postures.make(found)

    def _start(self, near: Near) -> Placed:
        """The configuration of a posture, or of a home by its name; default home.

        Raises:
            UnknownNameError, ClosureError: no such home, or it cannot be closed.
        """
        if not isinstance(near, str):
            return self._postures.placed(near)
        if near not in self._homes:
            k, own = self._k, self._actuated
            rough, keep = rough_home(k.model, k.description, near)
            start = k.tree.normalised(rough)
            self._homes[near] = assembled(k, start, own.hold(start) if keep else None)
        return self._homes[near]

    @cached_property
    def known_task(self) -> Task | None:
        """The task, or None where there is no tool, or it cannot be told."""
        try:
            return self.task
        except InputError:
            return None

    def _way(self, task: Task, target: Target, start: Placed) -> Way:
        """The way of the tool from a configuration to a target, in the model."""
        foot, goal = start.tool_pose, target.pose.moved(-self._k.origin)
        if set(target.led) <= POINT <= set(target.asked):
            return Way(start, foot.position, goal.position, ToolDriver)
        length = self._k.length
        driver = partial(TaskDriver, task, target.led, foot, length)
        return Way(start, TaskDriver.way(foot, foot, length), TaskDriver.way(foot, goal, length), driver)

    def _short(self, start: Placed, driver: Driver) -> Placed | None:
        """A short way in one go, where that is plainly on the same branch."""
        quick = self._mobility.quick
        return short_way(quick, start, driver) if quick is not None else None

    def _lead_tool(self, way: Way) -> Placed | Stopped:
        """Walk the tool along a way in the model: straight, else along what its point can reach at all."""
        found = self._walker.walk(way.start, way.origin, way.goal, way.driver)
        if not isinstance(found, Stopped) or (found.singular and found.fraction == 0.0):
            return found
        there, beside = way.driver(way.goal, way.goal), None
        if not isinstance(there, ToolDriver):
            return found
        if self._actuated.n == 1:
            beside = self._walker.along_curve(way.start, there)
        elif self._mobility.is_determined and self._mobility.structure.directions == 2:
            beside = self._walker.over_surface(way.start, there)
        return found if beside is None else beside

    def _check_rest(self, task: Task, target: Target, found: Placed) -> None:
        """Raises UnreachableError where the tool has not all of the pose that was asked for."""
        if target.asked == target.led:
            return
        pose = found.tool_pose.moved(self._k.origin)
        distance, angle = task.left(pose, target)
        if distance > tolerances.REACHED.value * self._k.reach or angle > tolerances.REACHED.value:
            raise UnreachableError(
                f"{self._k.name} cannot give its tool {target}: led by {task}, the tool stays {distance:.3g} m "
                f"and {np.degrees(angle):.3g} deg away from it; ask for {task} alone (free=True), or for a pose that "
                "the tool can have",
                target=target.pose.position,
                reached=pose.position,
                progress=1.0,
            )

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

    def _not_reached(self, stopped: Stopped, target: Target) -> UnreachableError | SingularError:
        if stopped.singular:
            return self._crossing(f"reach {target}", stopped, "type-1")
        reached = readonly(stopped.placed.tool_position + self._k.origin)
        return UnreachableError(
            f"{self._k.name} cannot reach {target} on this branch: it got {stopped.fraction:.1%} of the way, to "
            f"{np.round(reached, 6).tolist()} m, where {stopped.why}; choose a target inside the workspace or start "
            "from a posture of another working mode",
            target=target.pose.position,
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
