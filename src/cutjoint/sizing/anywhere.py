"""The worst case anywhere: what actuators must do wherever the tool is, at bounded speeds and accelerations of it.

Postures are found by a random walk on the branch of home, within joint limits and away from singular postures.  With B
the inverse of the task's Jacobian (rows of the point and of the turns apart), the fastest that actuator i must be is

    |v_i| = |B_i,point| V + |B_i,turns| W

and of all accelerations of the tool up to A and alpha the worst adds exactly |(M B)_i,point| A + |(M B)_i,turns| alpha
to what the actuator must do without one.  Directions of the speed, on which that depends, are drawn.  What is found is
a worst case among the postures that were looked at; with more of them it can only grow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cutjoint.arrays import Array, Frozen, positive
from cutjoint.doors import door
from cutjoint.errors import ClosureError, DynamicsError, InputError, SingularError, UnreachableError
from cutjoint.mechanism import NO_LOADS, Actuator, Mechanism, Posture, Task, Tool
from cutjoint.reprs import line
from cutjoint.sizing.moving import Mover, SizingLoads

REFUSED = (UnreachableError, ClosureError, SingularError, DynamicsError)
STEPS = (0.02, 1.0)
"""Least and largest step of the walk, in radians or lengths of the robot."""
TRIES = 40
"""Steps that are tried for a posture that is found, on average, until the walk is given up."""
DIRECTIONS = 12
"""Directions of the tool's speed that are drawn at every posture."""


@dataclass(frozen=True, eq=False)
class Anywhere(Frozen):
    """The worst case among postures, shape (n,) each.

    Attributes:
        actuators: which.
        effort: largest size [N] or [N m].
        speed: largest size [m/s] or [rad/s].
        power: largest effort times largest speed at one posture [W]: a bound.
        holding: largest size of the effort at rest.
        at_effort: actuated coordinates at which each effort is largest, shape (n, n), [m] or [rad].
        reach: least and largest of every actuated coordinate that was looked at, shape (2, n).
        postures: how many were looked at.
    """

    actuators: tuple[Actuator, ...]
    effort: Array
    speed: Array
    power: Array
    holding: Array
    at_effort: Array
    reach: Array
    postures: int

    __repr__ = line("effort", "speed", "power", "postures", effort="N or N m", speed="m/s or rad/s", power="W")


class ToolBounds(NamedTuple):
    """Of the tool: speed [m/s], acceleration [m/s2], and of its turning [rad/s], [rad/s2]."""

    speed: float
    acceleration: float
    turning: float
    turning_rate: float


@door
def size_anywhere(
    robot: Mechanism,
    tool_speed: float,
    tool_acceleration: float,
    *,
    turn_speed: float | None = None,
    turn_acceleration: float | None = None,
    payload: float = 0.0,
    loads: SizingLoads = NO_LOADS,
    condition: float = 10.0,
    samples: int = 300,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> Anywhere:
    """The worst case over so many postures of the workspace.

    Args:
        robot: any robot with a task.
        tool_speed: largest of the tool point [m/s].
        tool_acceleration: largest of the tool point [m/s2].
        turn_speed: largest of the tool's turning [rad/s]; needed where rotations are led, elsewhere there is none.
        turn_acceleration: largest of the tool's turning [rad/s2], likewise.
        payload: mass at the tool [kg].
        loads: from outside, the same everywhere.
        condition: worst condition of the task's Jacobian, in the robot's own units; nearer to singular postures, where
            efforts and speeds grow beyond bounds, nothing is looked at.
        samples: number of postures.
        seed: of the walk and of the directions.
        progress: called with the number of postures that were found.

    Raises:
        InputError: bounds that are not > 0, missing, or of what is not led; no tool; hardly a posture was found.
    """
    task = robot.task
    bounds = _bounds(task, tool_speed, tool_acceleration, turn_speed, turn_acceleration)
    if samples < 1 or seed < 0:
        raise InputError(f"samples must be at least 1 and the seed at least 0, found {samples} and {seed}")
    if callable(loads):
        raise InputError("loads that change with time have no time here; give constant ones")
    if not 1.0 < condition < float("inf"):
        raise InputError(f"condition must be finite and > 1, found {condition:g}")
    mover, random = Mover(robot, payload, loads), np.random.default_rng(seed)
    found = _Walker(mover, task, condition).walk(samples, random, progress)
    effort, speed, holding, power = (np.zeros((len(found), robot.n)) for _ in range(4))
    for k, (at, inverse, tool) in enumerate(found):
        effort[k], speed[k], holding[k] = _worst(mover, task, bounds, at, inverse, tool, random)
        power[k] = effort[k] * speed[k]
    q = np.array([at.q for at, _, _ in found])
    return Anywhere(
        robot.actuators,
        effort.max(axis=0),
        speed.max(axis=0),
        power.max(axis=0),
        holding.max(axis=0),
        q[np.argmax(effort, axis=0)],
        np.array([q.min(axis=0), q.max(axis=0)]),
        len(found),
    )


def _bounds(
    task: Task, speed: float, acceleration: float, turning: float | None, turning_rate: float | None
) -> ToolBounds:  # fmt: skip
    turns = any(row >= 3 for row in task.rows)
    given = {"turn_speed": turning, "turn_acceleration": turning_rate}
    for name, value in given.items():
        if turns and value is None:
            raise InputError(f"{task.robot} leads {task}, so its turning needs a bound: give {name}")
        if not turns and value is not None:
            raise InputError(f"{task.robot} leads {task} and turns nothing by itself; leave out {name}")
    positive("tool_speed", speed, "m/s")
    positive("tool_acceleration", acceleration, "m/s2")
    for name, value in given.items():
        if value is not None:
            positive(name, value, "rad/s" if name == "turn_speed" else "rad/s2")
    return ToolBounds(speed, acceleration, turning or 0.0, turning_rate or 0.0)


Found = tuple[Posture, Array, Tool]
"""A posture, the inverse of the task's Jacobian there (n, rows), and the tool."""


class _Walker:
    """Walks from posture to posture, home the first."""

    def __init__(self, mover: Mover, task: Task, condition: float) -> None:
        self._robot, self._task, self._condition = mover.robot, task, condition
        length = getattr(self._robot, "length", None) or getattr(mover.plain, "length", None)
        self._length = float(length or 1.0)
        sizes = [self._length if one.kind == "translation" else 1.0 for one in self._robot.actuators]
        self._units = np.array(sizes)

    def walk(
        self, samples: int, random: np.random.Generator, progress: Callable[[float], None] | None
    ) -> list[Found]:  # fmt: skip
        """So many postures.

        Raises:
            InputError: hardly any was found.
        """
        robot = self._robot
        start = self._seen(robot.home)
        if start is None:
            raise InputError(
                f"{robot.name} stands near a singular posture at home; take another home, or a larger condition"
            )
        found = [start]
        least, most = np.log(STEPS[0]), np.log(STEPS[1])
        for _ in range(TRIES * samples):
            if len(found) >= samples:
                return found
            near = found[int(random.integers(len(found)))][0]
            step = float(np.exp(random.uniform(least, most))) * random.normal(size=robot.n)
            try:
                one = self._seen(robot.close(near.q + self._units * step, near))
            except REFUSED:
                continue
            if one is not None:
                found.append(one)
                if progress is not None:
                    progress(len(found))
        raise InputError(
            f"of {TRIES * samples} steps {robot.name} could follow only {len(found) - 1}; {samples} postures were "
            "asked for: ask for fewer, or for a larger condition"
        )

    def _seen(self, at: Posture) -> Found | None:
        """The posture with what is known of it; None where it is near a singular one."""
        task, tool = self._task, self._robot.tool(at)
        jacobian = task.towards(tool.pose, task.rows).matrix(tool.rotation) @ tool.frame_jacobian
        rows = np.array([1.0 / self._length if row < 3 else 1.0 for row in task.rows])
        scaled = rows[:, None] * jacobian * self._units
        values = np.linalg.svd(scaled, compute_uv=False)
        if not values[-1] * self._condition >= values[0] > 0.0:
            return None
        return at, self._units[:, None] * np.linalg.pinv(scaled) * rows, tool


def _worst(
    mover: Mover,
    task: Task,
    bounds: ToolBounds,
    at: Posture,
    inverse: Array,
    tool: Tool,
    random: np.random.Generator,
) -> tuple[Array, Array, Array]:
    """Largest efforts, speeds and holding efforts at a posture, shape (n,) each."""
    robot = mover.robot
    turns = np.array([row >= 3 for row in task.rows])
    condition = task.towards(tool.pose, task.rows).matrix(tool.rotation)

    def largest(rows: Array, of_point: float, of_turn: float) -> Array:
        found = np.linalg.norm(rows[:, ~turns], axis=1) * of_point + np.linalg.norm(rows[:, turns], axis=1) * of_turn
        return np.asarray(found)

    twists = random.normal(size=(DIRECTIONS, len(turns)))
    for own, most in ((~turns, bounds.speed), (turns, bounds.turning)):
        if own.any():
            twists[:, own] *= most / np.linalg.norm(twists[:, own], axis=1, keepdims=True)
    speeds = np.vstack([np.zeros(robot.n), twists @ inverse.T])
    mass, coriolis, gravity, springs, friction = mover.terms([at] * len(speeds), speeds)
    push = mover.pushed(at, mover.loads(0.0)) if mover.is_pushed else 0.0
    holding = gravity + springs - push
    drifts = np.array([condition @ robot.tool(at, v).frame_drift for v in speeds])
    carried = -np.einsum("kij,kj->ki", mass @ inverse, drifts)
    most = np.abs(carried + coriolis + holding + friction).max(axis=0)
    most = most + largest(mass[0] @ inverse, bounds.acceleration, bounds.turning_rate)
    return most, largest(inverse, bounds.speed, bounds.turning), np.abs(holding[0])
