"""The task of a tool as further rows beside those of the loops, so that one step of Newton's method leads all joints.

With p, Q the place of the tool and its rotation since home, and p_d, Q_d where it shall be, the errors of the task
(`cutjoint.mechanism.task`) are A' (p - p_d) and twice the vector part of the quaternion (q, w) of E = A' Q_d' Q A; they
change by C (v, u), and a step asks C (v, u) = -error.  Where all three places or all three rotations are led, the same
step is asked of v and u themselves, along the axes of the world, which leaves zeros and constants to the elimination:

    v = -(p - p_d),     u = -(2 / w) Q_d A q,    because (w 1 - [q])^-1 q = q / w
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from cutjoint.compile.equations.cut_rows import ConstraintRow, Loops
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions import functions
from cutjoint.compile.expressions.functions import is_zero
from cutjoint.compile.expressions.graph import Number
from cutjoint.compile.expressions.vectors import (
    IDENTITY,
    ZERO,
    Matrix,
    Vector,
    add,
    constant_rotation,
    dot,
    product,
    scale,
    sub,
    transposed,
    turn,
)
from cutjoint.mechanism import Task


@dataclass(frozen=True, eq=False)
class Led:
    """A task at one pose of the tree.

    Attributes:
        rows: what a step must do, beside what the loops ask.
        missed: errors of the task's rows.
        position, rotation: of the tool, in the model.
        strain: how near the tool is to half a turn away, where the rotation that is missed has no direction.
    """

    rows: list[ConstraintRow]
    missed: list[Number]
    position: Vector
    rotation: Matrix
    strain: Number


class LedLoops:
    """Loops, and the task of a tool that they carry.

    Args:
        loops: of the robot.
        tool: step, rotation and lever of the tool.
        task: its task.
        goal: place (3) in the model and rotation (9, row by row) that the tool shall have; default those it has.
    """

    def __init__(
        self, loops: Loops, tool: tuple[int, Matrix, Vector], task: Task, goal: Sequence[Number] | None = None
    ) -> None:
        self._loops, self._tool, self._task, self._goal = loops, tool, task, goal

    def rows(self, pose: TreePose) -> list[ConstraintRow]:
        """Those of the loops, then those of the task."""
        return [*self._loops.rows(pose), *self.led(pose).rows]

    def led(self, pose: TreePose) -> Led:
        """The task at a pose of the tree."""
        step, own, lever = pose.frame("tool", self._tool)
        position = add(pose.origin(step), pose.lever(step, lever))
        rotation = product(pose.rotation[step], own)
        columns = pose.columns(step, lever)
        velocity = {u: one for u, one, _ in columns}
        angular = {u: one for u, _, one in columns}
        rows = self._task.rows
        places, turns = [row for row in rows if row < 3], [row - 3 for row in rows if row >= 3]
        goal = [*position, *(x for row in rotation for x in row)] if self._goal is None else self._goal
        basis = transposed(constant_rotation(self._task.basis))
        away = sub(position, (goal[0], goal[1], goal[2]))
        missed = [dot(basis[k], away) for k in places]
        if len(places) == 3:
            found = [_row(velocity, axis, part, True) for axis, part in zip(IDENTITY, away, strict=True)]
        else:
            found = [_row(velocity, basis[k], part, True) for k, part in zip(places, missed, strict=True)]
        strain: Number = 1.0
        if turns:
            at_home = constant_rotation(self._task.home.rotation)
            wanted: Matrix = ((goal[3], goal[4], goal[5]), (goal[6], goal[7], goal[8]), (goal[9], goal[10], goal[11]))
            into = product(product(basis, at_home), transposed(wanted))
            q: Vector = ZERO
            w: Number = 1.0
            if self._goal is not None:
                q, w = _quaternion(product(product(into, rotation), transposed(product(basis, at_home))))
                strain = 1.0 / (w * w)
            errors = [2.0 * q[k] for k in turns]
            missed += errors
            if len(turns) == 3:
                step_back = turn(transposed(into), scale(2.0 / w, q))
                found += [_row(angular, axis, part, False) for axis, part in zip(IDENTITY, step_back, strict=True)]
            else:
                x, y, z = q
                condition = product(((w, z, -y), (-z, w, x), (y, -x, w)), into)
                found += [_row(angular, condition[k], part, False) for k, part in zip(turns, errors, strict=True)]
        return Led(found, missed, position, rotation, strain)


def _row(rates: dict[int, Vector], axis: Vector, error: Number, is_length: bool) -> ConstraintRow:
    coefficients = {u: dot(axis, one) for u, one in rates.items()}
    return ConstraintRow({u: c for u, c in coefficients.items() if not is_zero(c)}, 0.0, error, is_length)


def _quaternion(rotation: Matrix) -> tuple[Vector, Number]:
    """Vector part and real part >= 0 of a rotation by less than half a turn."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    w = 0.5 * functions.sqrt(1.0 + (a + e + i))
    return scale(0.25 / w, (h - f, c - g, d - b)), w
