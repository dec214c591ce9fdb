"""A workspace that is being found: who is asked, over which coordinates, and what was chosen unasked.

A chain is led from cell to cell by its compiled functions, a published model is asked of every cell at once, and
any other mechanism is led posture by posture.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain import ClosedChain
from cutjoint.chain.collisions import SelfCollisions
from cutjoint.compile import CompiledChain, CompiledPaper, compiled
from cutjoint.errors import CutjointError, InputError
from cutjoint.mechanism import JointLimits, Mechanism, Pose, Posture, Task
from cutjoint.mechanism.interface import are_respected
from cutjoint.papers.reduced_model import ClosedFormModel
from cutjoint.reprs import line
from cutjoint.workspace.bounding import Filler, Range, bounded
from cutjoint.workspace.filling import Filled, Told, fill
from cutjoint.workspace.goals import Goals, chosen_axes, pose_of
from cutjoint.workspace.lattice import Lattice
from cutjoint.workspace.published import ClosedForm
from cutjoint.workspace.walking import CellWalker, ChainWalker, SlowWalker, Watch

Assembly = Literal["home", "any"]
"""Which assembly modes: that of the start alone, or any, through type-2 singularities."""
TURN = 0.25
"""Breadth of the first cells over turns [rad]."""
LENGTHS = 0.25
"""Breadth of the first cells over places, in lengths of the robot."""


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked for.

    Attributes:
        axes: coordinates that the grid is over, if they are said.
        region: coordinate -> range.
        held: coordinate -> where it is held.
        near: the posture to start from, if not home.
        assembly: which assembly modes.
        limits: whether joint limits are respected.
        collisions: whether postures in which links touch are left out.
    """

    axes: tuple[str, ...] | None = None
    region: Mapping[str, Sequence[float]] = field(default_factory=dict)
    held: Mapping[str, float] = field(default_factory=dict)
    near: Posture | None = None
    assembly: Assembly = "home"
    limits: JointLimits = "respect"
    collisions: bool = False

    __repr__ = line("axes", "region", "held", "assembly", "limits", "collisions")


@dataclass(frozen=True, eq=False)
class Exploring:
    """A workspace that is being found.

    Attributes:
        robot: who is asked.
        goals: coordinates of the grid, and those that are held.
        start: the posture that all is joined with.
        filler: fills lattices.
        limits: what bounds the grid from outside.
        stride: breadth of the first cells, shape (axes,), [m] or [rad].
        walker: who leads the tool; None where a published model is asked.
        told: what was chosen unasked, in sentences.
    """

    robot: Mechanism
    goals: Goals
    start: Posture
    filler: Filler
    limits: Mapping[str, Range]
    stride: Array
    walker: CellWalker | None
    told: tuple[str, ...]

    __repr__ = line("robot", "goals", "limits")

    @property
    def length(self) -> float:
        """Length of the robot [m]."""
        return _length(self.robot, self.start)

    @property
    def is_slow(self) -> bool:
        """Whether it is asked posture by posture."""
        return isinstance(self.walker, SlowWalker)

    def actuated(self, states: Array) -> Array:
        """Actuated coordinates of states, shape (N, n)."""
        return states if self.walker is None else self.walker.actuated(states)

    def posture(self, state: Array) -> Posture:
        """The posture of a state."""
        return self.robot.close(state) if self.walker is None else self.walker.posture(state)


class _Walked:
    """Fills lattices by walks from one posture."""

    def __init__(self, walker: CellWalker, told: Told | None) -> None:
        self.walker, self.at, self._told = walker, walker.at, told
        self.size = 8 * (len(walker.start) + 4 * len(walker.at) + 8)

    def fill(self, lattice: Lattice, *, coarse: bool, begun: Filled | None = None) -> Filled:
        return fill(self.walker, lattice, 2 if coarse else 5, None if coarse else self._told, begun)


class _Calculated:
    """Fills lattices by asking a published model."""

    def __init__(self, form: ClosedForm) -> None:
        self.form, self.at, self.size = form, form.at, 300

    def fill(self, lattice: Lattice, *, coarse: bool, begun: Filled | None = None) -> Filled:
        return self.form.fill(lattice, edges=not coarse)


def surveyed(robot: Mechanism, asked: Question, told: Told | None = None) -> Exploring:
    """A workspace that is about to be found; errors as `workspace`."""
    respected, across = are_respected(asked.limits), asked.assembly == "any"
    if asked.assembly not in ("home", "any"):
        raise InputError(f'assembly must be "home" or "any", found {asked.assembly!r}')
    if isinstance(robot, ClosedChain | ClosedFormModel):
        robot = compiled(robot)
    task = robot.task
    free, words = _freedoms(robot, task)
    said = _said_axes(task, asked)
    start = robot.home if asked.near is None else asked.near
    axes = _best_axes(robot, start, task, free) if free < len(task.names) and said is None else said
    axes = chosen_axes(task, axes, asked.held)
    if free < len(task.names):
        if len(axes) + len(asked.held) > free:
            raise InputError(
                f"the tool of {robot.name} has {free} freedoms, though its task is {task}: a grid can be over "
                f"{free} of its coordinates, found {', '.join((*axes, *asked.held))}"
            )
        words += (f"the grid is over {', '.join(axes)}; the other coordinates of the tool follow",)
    for name in asked.region:
        if name not in axes:
            chosen_axes(task, (name,), {})
            raise InputError(f"a range is given for {name}, which the grid is not over; leave one of them out")
    start = _held_start(robot, start, asked, axes, respected)
    held = dict(asked.held) if free < len(task.names) else _others(robot, task, start, axes, asked.held)
    origin = np.array(robot.source.origin) if isinstance(robot, CompiledChain) else np.zeros(3)
    goals = Goals(task, axes, held, origin, free < len(task.names))
    walker: CellWalker | None = None
    if isinstance(robot, CompiledPaper):
        filler: Filler = _Calculated(ClosedForm(robot, goals, start, across=across))
        words += ("a published model has no limits of joints, and its links no shapes",)
        if asked.collisions:
            raise InputError(f"{robot.name} has no shapes that could touch; take the robot's closed chain")
    else:
        watch = _collision_watch(robot, start) if asked.collisions else None
        walker = _walker(robot, goals, start, across, respected, watch)
        filler = _Walked(walker, told)
    ranges = {name: _pair(name, one) for name, one in asked.region.items()}
    stride = np.array([TURN if unit == "rad" else LENGTHS * _length(robot, start) for unit in goals.units])
    return Exploring(robot, goals, start, filler, bounded(goals, ranges, filler.at), stride, walker, words)


def _said_axes(task: Task, asked: Question) -> tuple[str, ...] | None:
    """The axes that are said: by themselves, or by ranges of what is not an axis as a rule."""
    if asked.axes is not None or not asked.region:
        return asked.axes
    usual = chosen_axes(task, None, {name: value for name, value in asked.held.items() if name in task.names})
    return None if set(asked.region) <= set(usual) else tuple(asked.region)


def _freedoms(robot: Mechanism, task: Task) -> tuple[int, tuple[str, ...]]:
    """How many coordinates of the task can be chosen, and what is odd about it.

    Raises:
        ActuationError: the actuators do not determine the motion.
    """
    if not isinstance(robot, CompiledChain):
        return min(robot.n, len(task.names)), ()
    report = robot.chain.mobility()
    moves = report.mobility - report.idle_mobility
    if moves < report.actuators:
        told = f"{report.actuators} actuators drive {moves} freedoms; type-2 singularities are not looked for"
        return min(moves, len(task.names)), (told,)
    robot.chain.tangent(robot.home)
    if not report.idle_mobility:
        return min(robot.n, len(task.names)), ()
    idle = (
        f"{report.idle_mobility} idle freedoms: led posture by posture; singularities at which the tool turns while "
        "its point rests are not looked for"
    )
    return min(robot.n, len(task.names)), (idle,)


def _best_axes(robot: Mechanism, start: Posture, task: Task, free: int) -> tuple[str, ...]:
    """The coordinates of the task that tell best where the tool is, at the start."""
    jacobian, left = led_jacobian(robot, task, start), list(range(len(task.names)))
    taken: list[int] = []
    for _ in range(min(free, 3)):
        base = np.linalg.qr(jacobian[taken].T)[0] if taken else np.zeros((robot.n, 0))
        rest = jacobian - jacobian @ base @ base.T
        best = max(left, key=lambda row: (round(float(np.linalg.norm(rest[row])), 12), -row))
        taken.append(best)
        left.remove(best)
    return tuple(task.names[row] for row in sorted(taken))


def led_jacobian(robot: Mechanism, task: Task, at: Posture) -> Array:
    """Rates of all coordinates of a task by the actuators, shape (rows, n)."""
    tool = robot.tool(at)
    condition = task.towards(Pose(tool.position, tool.rotation), task.rows)
    return np.asarray(condition.matrix(tool.rotation) @ tool.frame_jacobian)


def _held_start(robot: Mechanism, start: Posture, asked: Question, axes: Sequence[str], respected: bool) -> Posture:
    """The start, with what is held there."""
    if not asked.held:
        return start
    task = robot.task
    here = dict(zip(task.names, task.coordinates(pose_of(robot, start)).tolist(), strict=True))
    try:
        wanted = {**here, **asked.held}
        return robot.reach(wanted, start, limits="respect" if respected else "ignore")
    except CutjointError as error:
        held = ", ".join(f"{name} {value:g}" for name, value in asked.held.items())
        error.add_note(
            f"{held} is to be held; the tool is led there from the start, its other coordinates as they are: start "
            "from another posture where it cannot come there"
        )
        raise


def _others(
    robot: Mechanism, task: Task, start: Posture, axes: Sequence[str], held: Mapping[str, float]
) -> dict[str, float]:
    """All coordinates that the grid is not over."""
    here = dict(zip(task.names, task.coordinates(pose_of(robot, start)).tolist(), strict=True))
    return {name: float(held.get(name, value)) for name, value in here.items() if name not in axes}


def _walker(
    robot: Mechanism, goals: Goals, start: Posture, across: bool, respected: bool, watch: Watch | None
) -> CellWalker:
    # compiled functions hold one coordinate for every idle freedom, such as the spin of a rod between balls; where that
    # one comes to stand across the spin, their rates have no bound, and a workspace would end there that does not
    determined = not goals.free and len(goals.task.names) == robot.n
    if isinstance(robot, CompiledChain) and determined and not robot.chain.mobility().idle_mobility:
        try:
            return ChainWalker(robot, goals, start, across=across, limits=respected, watch=watch)
        except CutjointError:
            pass
    return SlowWalker(robot, goals, start, across=across, limits=respected, watch=watch)


def _collision_watch(robot: Mechanism, start: Posture) -> Watch:
    if not isinstance(robot, CompiledChain):
        raise InputError(f"{robot.name} has no shapes that could touch; take the robot's closed chain")
    looked = SelfCollisions(robot.chain, start)
    return lambda q: np.array([not looked.touch(one) for one in q], dtype=bool)


def _length(robot: Mechanism, start: Posture) -> float:
    """A length of the robot [m]."""
    if isinstance(robot, CompiledChain):
        return float(robot.chain.length)
    tool = robot.tool(start)
    turning = [one.kind == "rotation" for one in robot.actuators]
    levers = np.linalg.norm(tool.frame_jacobian[:3], axis=0)[turning]
    found = float(levers.max(initial=0.0)) or float(np.abs(tool.position).max())
    return found or 1.0


def _pair(name: str, given: Sequence[float]) -> Range:
    try:
        low, high = given
        return float(low), float(high)
    except (TypeError, ValueError) as error:
        raise InputError(f"the range of {name} must be two numbers, found {given!r}") from error
