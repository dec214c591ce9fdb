"""The task of a chain: as its description says, else as the motions of its tool at home tell.

With J the six rows of the tool's Jacobian on all motions that the loops allow, dimensionless, at home (or around it,
where home is singular), and r its rank, the task is

1. all six, where r is six;
2. the rows that are not zero, where there are r of them, in the axes of the world, else of the tool at home;
3. the point, where it tells where the robot is: its rows alone have the rank r.  A row that is zero at home and around
   it is left out where r stay, in the axes of the world, else of the tool (the plane of a planar robot); otherwise the
   point is on a curve or a surface;
4. the rows that are not small, where there are r of them: a tripod moves its point sideways a little while it tilts;
5. the rotations, where their rows have the rank r, and there are r of them.

Rows that tell the motion do so well: their least singular value is not small beside that of all six.  Otherwise the
task must be said.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np

from cutjoint.arrays import Array
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility import Mobility
from cutjoint.chain.postures import Postures
from cutjoint.chain.rank import null_space, rank_of
from cutjoint.chain.structure import scaled_tool
from cutjoint.errors import InputError
from cutjoint.mechanism import Task
from cutjoint.mechanism.task import NAMES, Axes

STILL = 1e-6
"""Rows smaller than this beside the largest do not move."""
WELL = 0.1
"""Rows smaller than this beside the largest are side effects; and rows tell a motion well where their least singular
value is not smaller than this beside that of all."""


def task_of(mobility: Mobility) -> Task:
    """The task of a chain with a tool.

    Raises:
        InputError: there is no tool, or the task cannot be told, or the one that is declared cannot be done.
    """
    postures = mobility.postures
    k, said = postures.k, postures.k.description
    k.need_tool()
    whole = all_motions(postures)
    usual = mobility.structure.rank
    around = [_motions(postures, placed) for placed in mobility.regular if rank_of(placed.scaled) == usual]
    if said.task:
        task = Task(said.task, whole.home, k.name, said.task_axes)
        _check_declared(task, around)
        return task
    found = _found(around, whole)
    if found is None:
        raise InputError(
            f"the task of {k.name} cannot be told from its tool's motions at home: {_how_to_choose(around)}"
        )
    return found


def all_motions(postures: Postures) -> Task:
    """All six, in the axes of the world."""
    home = postures.at_home.tool_pose.moved(postures.k.origin)
    return Task(NAMES, home, postures.k.name)


def _motions(postures: Postures, placed: Placed) -> Array:
    """Motions of the tool that the loops allow, dimensionless, shape (6, k)."""
    return np.asarray(scaled_tool(postures.k, placed) @ null_space(placed.scaled))


def _found(around: list[Array], whole: Task) -> Task | None:
    rank = max(map(rank_of, around))
    if rank == 6:
        return whole
    if rank == 0:
        return _task(whole, (0, 1, 2), "world")
    home = next(motions for motions in around if rank_of(motions) == rank)
    views: dict[Axes, list[Array]] = {
        "world": [home, *around],
        "tool": [_in_axes(motions, whole.home.rotation) for motions in (home, *around)],
    }
    for axes, seen in views.items():
        rows = _active(seen[:1])
        if len(rows) == rank:
            return _task(whole, rows, axes)
    if _tells(home, home, (0, 1, 2)):
        for axes, seen in views.items():
            rows = tuple(row for row in _active(seen) if row < 3)
            if len(rows) == rank:
                return _task(whole, rows, axes)
        return _task(whole, (0, 1, 2), "world")
    for axes, seen in views.items():
        rows = _active(seen[:1], WELL)
        if len(rows) == rank and _tells(home, seen[0], rows):
            return _task(whole, rows, axes)
    rows = tuple(row for row in _active([home]) if row >= 3)
    if len(rows) == rank and _tells(home, home, rows):
        return _task(whole, rows, "world")
    return None


def _tells(home: Array, seen: Array, rows: tuple[int, ...]) -> bool:
    """Whether rows of the motions `seen` in some axes tell the motions at home, and well."""
    return _least(seen[list(rows)], rank_of(home)) >= WELL * _least(home, rank_of(home))


def _least(motions: Array, rank: int) -> float:
    values = np.linalg.svd(motions, compute_uv=False)
    return float(values[rank - 1]) if len(values) >= rank else 0.0


def _task(whole: Task, rows: tuple[int, ...], axes: Axes) -> Task:
    return Task(tuple(NAMES[row] for row in rows), whole.home, whole.robot, axes)


def _in_axes(motions: Array, axes: Array) -> Array:
    return np.concatenate([axes.T @ motions[:3], axes.T @ motions[3:]])


def _active(several: list[Array], least: float = STILL) -> tuple[int, ...]:
    """Rows that move at any of some postures."""
    size = np.max([np.linalg.norm(motions, axis=1) for motions in several], axis=0)
    return tuple(np.flatnonzero(size > least * size.max(initial=1e-300)).tolist())


def _check_declared(task: Task, around: list[Array]) -> None:
    rows, rank = list(task.rows), max(map(rank_of, around))
    led = [_in_axes(motions, task.basis)[rows] for motions in around]
    still = [name for i, name in enumerate(task.names) if i not in _active(led)]
    if still:
        raise InputError(
            f"the task {task} of {task.robot} cannot be done: its tool does not move along {', '.join(still)}; "
            f"{_how_to_choose(around)}"
        )
    most = max(map(rank_of, led))
    if most < len(rows) and not task.is_of_point:
        raise InputError(
            f"the task {task} of {task.robot} cannot be done: of its {len(rows)} motions {most} are independent (the "
            f"tool has {rank}); {_how_to_choose(around)}"
        )


def _how_to_choose(around: list[Array]) -> str:
    """Which tasks a declaration may name."""
    rank = max(map(rank_of, around))
    home = next(motions for motions in around if rank_of(motions) == rank)
    active = _active([home])
    choices = [rows for rows in combinations(active, rank) if _tells(home, home, rows)]
    fitting = [" ".join(NAMES[row] for row in rows) for rows in choices]
    return (
        f"it has {rank} independent motions in {' '.join(NAMES[row] for row in active)}; say {rank} of them under "
        f"[tool], such as task = {_as_list(fitting[0] if fitting else 'x y z')} (possible: {', '.join(fitting[:8])})"
    )


def _as_list(names: str) -> str:
    return "[" + ", ".join(f'"{name}"' for name in names.split()) + "]"
