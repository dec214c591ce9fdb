"""A chain that is led by its tool, as equations in its configuration: as many equations as unknowns.

Unknowns are Pinocchio's coordinates: a ball has its quaternion, a body that turns in a plane cosine and sine, with one
equation each for their unit length.  Then there are the equations of the loops, as many as are independent, and for
every led coordinate of the tool

    places:       A' p - t = 0,                  with p the tool's place and t the wanted one along the task's axes A
    rotations:    led parts of (E - E') / 2,     E = exp(-[r]) A' Q A, with Q the rotation since home, r the wanted one

which vanish where the tool is as `cutjoint.mechanism.task` asks: E - E' is 4 w q of its quaternion (q, w).  Idle
freedoms, such as the spin of a rod between two balls, are held by one linear equation each.

Equations of the loops that depend on the others at the start are left out: along the branch of a robot they hold by
themselves, since the closure is analytic.  What they are open by is looked at in the middle of every sub-box.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.factoring import pivots_of
from cutjoint.chain.rank import null_space, rank_of
from cutjoint.compile.equations.cloud import run
from cutjoint.compile.equations.pose import TreePose
from cutjoint.compile.expressions.derivative import tangent
from cutjoint.compile.expressions.graph import Expression, Graph, Number
from cutjoint.compile.expressions.program import Program, interpret
from cutjoint.compile.expressions.straight_line import assemble
from cutjoint.compile.expressions.vectors import Matrix, add, constant_rotation, dot, product, transposed
from cutjoint.compile.sources.chain import ChainSource
from cutjoint.errors import InputError
from cutjoint.mechanism import Posture
from cutjoint.workspace.certified.enclosing import enclose
from cutjoint.workspace.certified.forms import Form, weighted
from cutjoint.workspace.certified.goals import BoxGoals

Indices = npt.NDArray[np.intp]


class Sparse(NamedTuple):
    """A matrix of which a program gives the entries that are not zero.

    Attributes:
        program: gives them.
        rows, columns: where they stand.
        shape: of the matrix.
    """

    program: Program
    rows: Indices
    columns: Indices
    shape: tuple[int, int]

    def dense(self, values: Array) -> Array:
        """Matrices (..., rows, columns) from entries (..., entries)."""
        found = np.zeros((*values.shape[:-1], *self.shape))
        found[..., self.rows, self.columns] = values
        return found


class LedSystem:
    """The equations of one chain that is led along some coordinates of its tool.

    Args:
        source: the chain to be traced.
        goals: the coordinates that are led, as many as there are actuators.
        start: a regular posture of the branch.

    Attributes:
        size: number of unknowns.
        units: of what size every unknown is: 1, or the length of the robot, shape (size,).
        lower, upper: limits of the unknowns with the slack that the chain gives them, infinite where there are none.
        own: how many equations do not depend on what leads the robot: of loops and unit lengths.
        tails: equations after those, constants: of the idle freedoms, and of actuators that are held, (k, size).

    Raises:
        InputError: the robot is singular at the start.
    """

    def __init__(self, source: ChainSource, goals: BoxGoals, start: Posture) -> None:
        self.source, self.goals, self.chain = source, goals, source.chain
        self.size, self.units = source.positions, np.array(source.position_scale)
        lower, upper = source.limits
        slack = tolerances.CLOSURE.value * self.units
        self.lower, self.upper = lower - slack, upper + slack
        graph = Graph()
        q, goal = graph.symbols(self.size), graph.symbols(goals.width)
        pose, self._given = source.pose(q, ()), {"q": q, "goal": goal}
        loops = source.loops.rows(pose)
        lengths = np.array([row.is_length for row in loops], dtype=bool)
        rows: list[Number] = [row.residual for row in loops]
        units: list[Number] = [dot(q[span], q[span]) - 1.0 for span in self._circles()]
        kept = self._chosen(graph, rows, units, np.where(lengths, 1.0 / self.chain.length, 1.0), start)
        own = [*(rows[k] for k in kept), *units]
        self.own = len(own)
        every = [*own, *self._led_rows(pose, goal)]
        self._residual = self._program(graph, every)
        self._slopes = self._sparse(graph, every)
        left = [k for k in range(len(rows)) if k not in kept]
        self._left = self._program(graph, [rows[k] for k in left])
        self._left_scale = np.where(lengths, 1.0 / self.chain.length, 1.0)[left]

    # ---- making ----------------------------------------------------------------------------------------------------

    def _program(self, graph: Graph, results: list[Number]) -> Program:
        name = f"the closure of {self.source.name}"
        return assemble(graph, name, self._given, {"results": results}, fused=False)

    def _sparse(self, graph: Graph, rows: list[Number]) -> Sparse:
        found: list[tuple[int, int, Expression]] = []
        for j, x in enumerate(self._given["q"]):
            column = tangent(graph, rows, {abs(x.ref): 1.0})
            found += [(i, j, entry) for i, entry in enumerate(column) if entry.constant != 0.0]
        at = np.array([(i, j) for i, j, _ in found], dtype=np.intp).reshape(-1, 2)
        return Sparse(self._program(graph, [one for *_, one in found]), at[:, 0], at[:, 1], (len(rows), self.size))

    def _circles(self) -> list[slice]:
        """Coordinates of unit length together: quaternions, and cosines with their sines."""
        steps = [step for step in self.source.tree.steps[1:] if step.kind.coordinates > step.kind.rates]
        return [slice(step.q, step.q + step.kind.coordinates) for step in steps]

    def _led_rows(self, pose: TreePose, goal: list[Expression]) -> list[Number]:
        task = self.goals.task
        step, own, lever = pose.frame("tool", self.source.tool_frame)
        place = add(pose.origin(step), pose.lever(step, lever))
        basis = transposed(constant_rotation(task.basis))
        _, _, _, a, b, c, d, e, f, g, h, i = goal
        wanted: Matrix = ((a, b, c), (d, e, f), (g, h, i))
        at_home = transposed(product(basis, constant_rotation(task.home.rotation)))
        since = product(product(basis, product(pose.rotation[step], own)), at_home)
        left = product(transposed(wanted), since)
        turned = (left[2][1] - left[1][2], left[0][2] - left[2][0], left[1][0] - left[0][1])
        found: list[Number] = []
        for name in self.goals.names:
            axis = "xyz".index(name[-1])
            found.append(0.5 * turned[axis] if name.startswith("r") else dot(basis[axis], place) - goal[axis])
        return found

    def _chosen(
        self, graph: Graph, rows: list[Number], units: list[Number], row_scale: Array, start: Posture
    ) -> list[int]:
        """Which equations of the loops are independent; and what holds idle freedoms and actuators."""
        chain, at = self.chain, np.array(start.q_full)
        sparse = self._sparse(graph, [*rows, *units])
        values = run(sparse.program, np.concatenate([at, np.zeros(self.goals.width)]))
        scale = np.concatenate([row_scale, np.ones(len(units))])
        matrix = sparse.dense(values) * self.units * scale[:, None]
        loops, circles = matrix[: len(rows)], matrix[len(rows) :]
        free = loops @ null_space(circles)
        rank = rank_of(free)
        kept = sorted(pivots_of(free.T)[:rank].tolist()) if rank else []
        actuators = np.eye(self.size)[list(self.source.actuated)]
        idle = null_space(np.concatenate([matrix, actuators])).T
        if len(kept) + len(units) + chain.n + len(idle) != self.size:
            raise InputError(
                f"{chain.name} is singular in the middle of the box, and nothing can be proven around there; choose "
                "another box"
            )
        self._idle, self._actuators = idle / self.units, actuators
        self._held = self._idle @ at
        self.tails = np.concatenate([self._idle, np.zeros((0, self.size))]), np.concatenate([actuators, self._idle])
        return kept

    # ---- numbers ---------------------------------------------------------------------------------------------------

    def residuals(self, q: Array, goals: Array) -> Array:
        """What all equations are open by at configurations (N, size) for goals (N, width), shape (N, size)."""
        open_by = self._run(self._residual, q, goals)
        return np.concatenate([open_by, q @ self._idle.T - self._held], axis=1)

    def matrices(self, q: Array, goals: Array) -> tuple[Array, Array]:
        """Derivatives of the equations by the unknowns, led by tool and by actuators, (N, size, size) each."""
        return self._whole(self._slopes.dense(self._run(self._slopes.program, q, goals)), True)

    def left_open(self, q: Array, goals: Array) -> Array:
        """What the equations that are left out are open by at most, dimensionless, shape (N,)."""
        values = np.abs(self._run(self._left, q, goals)) * self._left_scale
        return np.asarray(values.max(axis=1, initial=0.0))

    def _run(self, program: Program, q: Array, goals: Array) -> Array:
        with np.errstate(all="ignore"):
            found = interpret(program, [*q.T, *goals.T])
        return np.stack([np.broadcast_to(one, len(q)) for one in found], axis=1) if found else np.zeros((len(q), 0))

    def _whole(self, led: Array, tails: bool) -> tuple[Array, Array]:
        """Both square matrices from that of the program; their constant equations are zero in what is no middle."""
        both = []
        for rows, tail in zip((led, led[..., : self.own, :]), self.tails, strict=True):
            last = tail if tails else np.zeros_like(tail)
            both.append(np.concatenate([rows, np.broadcast_to(last, (*rows.shape[:-2], *last.shape))], axis=-2))
        return both[0], both[1]

    # ---- enclosures ------------------------------------------------------------------------------------------------

    def residual_forms(self, q: list[Form], goal: list[Form], boxes: int) -> tuple[Array, Array]:
        """Polynomials (terms, boxes, size) and rest (boxes, size) of what the equations are open by."""
        line, rest = stacked(enclose(self._residual, [*q, *goal]), boxes)
        idle = len(self._idle)
        if idle:
            held = [weighted(q, row, -value) for row, value in zip(self._idle, self._held, strict=True)]
            more, more_rest = stacked(held, boxes)
            return np.concatenate([line, more], axis=-1), np.concatenate([rest, more_rest], axis=-1)
        return line, rest

    def matrix_forms(self, q: list[Form], goal: list[Form], boxes: int) -> tuple[tuple[Array, Array], ...]:
        """Of both matrices, the polynomials (terms, boxes, size, size) and the rest (boxes, size, size)."""
        line, rest = stacked(enclose(self._slopes.program, [*q, *goal]), boxes)
        dense, loose = self._slopes.dense(line), self._slopes.dense(rest)
        middle, slopes = self._whole(dense[0], True), self._whole(dense[1:], False)
        rests = self._whole(loose, False)
        lines = [np.concatenate([m[None], s]) for m, s in zip(middle, slopes, strict=True)]
        return tuple(zip(lines, rests, strict=True))


def stacked(forms: list[Form], boxes: int) -> tuple[Array, Array]:
    """Polynomials (terms, boxes, forms) and rests (boxes, forms)."""
    terms = len(forms[0].line)
    line = np.stack([np.broadcast_to(one.line, (terms, boxes)) for one in forms], axis=-1)
    return line, np.stack([np.broadcast_to(one.rest, (boxes,)) for one in forms], axis=-1)
