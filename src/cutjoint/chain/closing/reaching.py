"""Inverse kinematics of one robot: its tool is led along its task, and has all that was asked for in the end."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import readonly
from cutjoint.chain.closing.continuation import Stopped
from cutjoint.chain.closing.drivers import TaskDriver, ToolDriver
from cutjoint.chain.closing.ways import Near, Way, Ways
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.task import all_motions, task_of
from cutjoint.errors import InputError, SingularError, UnreachableError
from cutjoint.mechanism import JointLimits, Posture, Target, TargetLike, Task
from cutjoint.mechanism.interface import are_respected
from cutjoint.mechanism.task import is_pose

POINT = {0, 1, 2}
"""Rows of a tool's pose that are its point."""

FURTHEST = 1e6
"""Targets further away than this, in lengths of the robot, are refused at once."""


class Reaching:
    """Leads the tool of one robot; what it raises is said in `ClosedChain.reach`."""

    def __init__(self, mobility: Mobility, ways: Ways) -> None:
        self._mobility, self._postures, self._ways = mobility, mobility.postures, ways
        self._k, self._actuated = mobility.postures.k, mobility.postures.actuated

    @cached_property
    def task(self) -> Task:
        """The task of the tool, in the world.

        Raises:
            InputError: the robot has no tool, or its task cannot be told, or cannot be done.
        """
        return task_of(self._mobility)

    @cached_property
    def known_task(self) -> Task | None:
        """The task, or None where there is no tool, or it cannot be told."""
        try:
            return self.task
        except InputError:
            return None

    def reach(self, given: TargetLike, near: Near, free: bool, limits: JointLimits) -> Posture:
        """The closed posture with the tool at a target, on the branch of `near`."""
        k, respected = self._k, are_respected(limits)
        k.need_tool()
        # where the task cannot be told, a pose fixes the tool all the same, and what is free needs none
        told = self.known_task is not None or not (free or is_pose(given))
        task = self.task if told else all_motions(self._postures)
        target = task.target(given, free)
        start = self._ways.start(near)
        way = self._way(task, target, start)
        away = float(np.abs(way.goal - way.origin).max())
        if away > FURTHEST * k.reach:
            raise UnreachableError(
                f"{k.name} cannot reach {target}: that is {away:.3g} m away, and the robot is {k.reach:.3g} m long",
                target=target.pose.position,
            )
        found: Placed | Stopped | None = self._ways.short(start, way.driver(way.origin, way.goal))
        if found is None:
            found = self._lead_tool(way)
        if isinstance(found, Stopped):
            raise self._not_reached(found, target)
        self._check_rest(task, target, found)
        if respected and self._ways.limits.exceeded(start.q, found.q):
            raise self._ways.beyond_limits(way, found, f"reach {target}", target.pose.position)
        return self._postures.make(found)

    def _way(self, task: Task, target: Target, start: Placed) -> Way:
        """The way of the tool from a configuration to a target, in the model."""
        foot, goal, origin = start.tool_pose, target.pose, self._k.origin
        if origin.any():
            goal = goal.moved(-origin)
        if set(target.led) <= POINT <= set(target.asked):
            return Way(start, foot.position, goal.position, ToolDriver)
        length = self._k.length
        driver = partial(TaskDriver, task, target.led, foot, length)
        return Way(start, np.concatenate([foot.position, np.zeros(3)]), TaskDriver.way(foot, goal, length), driver)

    def _lead_tool(self, way: Way) -> Placed | Stopped:
        """Walk the tool along a way in the model: straight, else along what its point can reach at all."""
        found = self._ways.walker.walk(way.start, way.origin, way.goal, way.driver)
        if not isinstance(found, Stopped) or (found.singular and found.fraction == 0.0):
            return found
        there, beside = way.driver(way.goal, way.goal), None
        if not isinstance(there, ToolDriver):
            return found
        if self._actuated.n == 1:
            beside = self._ways.walker.along_curve(way.start, there)
        elif self._mobility.is_determined and self._mobility.structure.directions == 2:
            beside = self._ways.walker.over_surface(way.start, there)
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

    def _not_reached(self, stopped: Stopped, target: Target) -> UnreachableError | SingularError:
        if stopped.singular:
            return self._ways.crossing(f"reach {target}", stopped, "type-1")
        reached = readonly(stopped.placed.tool_position + self._k.origin)
        return UnreachableError(
            f"{self._k.name} cannot reach {target} on this branch: it got {stopped.fraction:.1%} of the way, to "
            f"{np.round(reached, 6).tolist()} m, where {stopped.why}; choose a target inside the workspace or start "
            "from a posture of another working mode",
            target=target.pose.position,
            reached=reached,
            progress=stopped.fraction,
        )
