"""How the tool follows small changes of numbers of a robot, its actuators held and its loops closed.

With R what a change opens the loops by and D how it moves the tool while no joint moves (`displacing`), the passive
joints follow by J u = -R, the tool by D + T u.  Where the loops are redundant, some changes cannot be followed by the
joints alone: one rod of a pair longer, an elbow out of the plane.  They need what every machine has, joints that give a
little:

    J u + E e = -R,     e the play of all joints and cuts, of all solutions the least:  e' K e

with K equal for all, a robot length of play against a radian, or the springs that are stated.  What the joints can
follow needs no play, so then this is the exact derivative.  Each joint and cut counts at its own frame, so it does not
matter which joint of a loop was cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cutjoint import tolerances
from cutjoint.accuracy.deviations import ErrorSource, sources
from cutjoint.accuracy.displacing import Displacements
from cutjoint.arrays import Array, Frozen
from cutjoint.chain import ClosedChain
from cutjoint.chain.joints import type_of
from cutjoint.chain.kinematics import Kinematics
from cutjoint.chain.rank import Split
from cutjoint.doors import door
from cutjoint.errors import ActuationError, InputError
from cutjoint.mechanism import Posture
from cutjoint.reprs import line, listed
from cutjoint.stiffness import ElasticRobot, Springs
from cutjoint.stiffness.rounding import rounding, trusted

PLAYS = 1e-9
"""Play smaller than this part of what the loops open by is rounding: the joints follow by themselves."""


@dataclass(frozen=True, eq=False)
class Sensitivity(Frozen):
    """How the tool follows numbers of a robot, in one posture.

    Attributes:
        sources: the numbers.
        matrix: displacement [m] and small rotation [rad] of the tool, world axes, per unit of each, shape (6, k).
        play: how far the joint that gives most must give to let it be, per unit, shape (k,) [m]; 0 where the joints
            follow by themselves.
        turn: the same of rotations, shape (k,) [rad].
        strained: the joint or cut that gives most, of every number; empty where none need give.
    """

    sources: tuple[ErrorSource, ...]
    matrix: Array
    play: Array
    turn: Array
    strained: tuple[str, ...]

    __repr__ = line("names", "matrix", matrix="m or rad")

    @property
    def names(self) -> tuple[str, ...]:
        """Of the numbers."""
        return tuple(source.name for source in self.sources)


class LoopFollower:
    """Follows changes of one robot in one posture.

    Args:
        chain: the robot.
        at: the posture; default home.
        springs: what gives where the joints alone cannot follow; default all joints and cuts alike.

    Raises:
        InputError: no tool, no posture of this robot, or springs that do nothing.
        ActuationError: the tool can move while the actuators hold.
    """

    __repr__ = line("chain")

    def __init__(self, chain: ClosedChain, at: Posture | None, springs: Springs | None) -> None:
        self.chain, self.displaced = chain, Displacements(chain, at)
        self._k, placed = self.displaced.kinematics, self.displaced.placed
        tool, actuated = placed.tool_jacobian, np.flatnonzero(chain.actuation.any(axis=1))
        self._passive = np.setdiff1d(np.arange(chain.nv), actuated)
        scale = self._k.column_scale
        rows, moves = placed.scaled[:, self._passive], (tool * scale)[:, self._passive]
        if springs is None:
            self._even_play(moves, rows)
        else:
            self._by_springs(ElasticRobot(chain, springs), at)
        self._split = Split.of(trusted(self._k, placed, self._rows))
        seen = self._tool @ self._split.null
        seen[:3] /= self._length
        if np.abs(seen).max(initial=0.0) > tolerances.RANK.value:
            report = chain.mobility(at)
            raise ActuationError(
                f"the tool of {chain.name} moves while its actuators hold, by {listed(report.free)}, so nobody can "
                "tell where it is; take a posture, or actuators, that hold it",
                mobility=report.mobility,
                actuators=chain.n,
                free=report.free,
            )

    def follow(self, opened: Array, moved: Array) -> tuple[Array, Array, Array, tuple[str, ...]]:
        """Motion of the tool, shape (6, k), play [m] and turn [rad] needed, shape (k,), and where most.

        Args:
            opened: what the loops open by, shape (rows, k).
            moved: how the tool moves while no joint moves, shape (6, k).

        Raises:
            InputError: what gives cannot let it be.
        """
        wanted = -self._row_scale[:, None] * opened
        split = self._split
        left = wanted - split.left @ (split.left.T @ wanted)
        size = np.maximum(np.abs(wanted).max(axis=0, initial=0.0), np.finfo(float).tiny)
        gap = rounding(self._k, self.displaced.placed)
        left[:, np.abs(left).max(axis=0, initial=0.0) <= (PLAYS + gap) * size] = 0.0
        give = np.zeros((self._gives.shape[1], wanted.shape[1]))
        strained = np.flatnonzero(left.any(axis=0))
        if len(strained):
            across = self._gives - split.left @ (split.left.T @ self._gives)
            soft = across / self._roots
            give[:, strained] = Split.of(soft).solve(left[:, strained]) / self._roots[:, None]
            unmet = np.abs(across @ give[:, strained] - left[:, strained]).max()
            if unmet > 1e-6 * size[strained].max():
                raise InputError(
                    f"{self.chain.name} cannot be put together with such tolerances by what the springs let give; let "
                    "more joints give way, or leave the springs out: all joints then give alike"
                )
        motion = split.solve(wanted - self._gives @ give)
        tool = moved + self._tool @ motion + self._give_tool @ give
        play, turn, where = self._strains(give)
        return tool, play, turn, where

    def columns(self, of: Sequence[ErrorSource]) -> tuple[Array, Array]:
        """What numbers open the loops by, shape (rows, k), and how they move the tool, shape (6, k)."""
        opened, moved = np.zeros((self.displaced.rows, len(of))), np.zeros((6, len(of)))
        for number, source in enumerate(of):
            for path in source.places:
                rows, tool = self.displaced.of(path)
                opened[:, number] += rows
                moved[:, number] += tool
        return opened, moved

    def sensitivity(self, of: Sequence[ErrorSource]) -> Sensitivity:
        """Of numbers of the robot; errors as of `follow`."""
        tool, play, turn, where = self.follow(*self.columns(of))
        return Sensitivity(tuple(of), tool, play, turn, where)

    # ---- inside ----------------------------------------------------------------------------------------------------

    def _even_play(self, moves: Array, rows: Array) -> None:
        """All joints and cuts give alike."""
        found, length = self.displaced.gives(), self._k.length
        scale = np.array([length] * 3 + [1.0] * 3)
        self._rows, self._tool, self._row_scale, self._length = rows, moves, self._k.row_scale, length
        count = len(found)
        opened = [self._k.row_scale[:, None] * one * scale for _, one, _ in found]
        self._gives = np.concatenate(opened, axis=1) if count else np.zeros((len(rows), 0))
        self._give_tool = np.concatenate([one * scale for _, _, one in found], axis=1) if count else np.zeros((6, 0))
        self._roots = np.ones(self._gives.shape[1])
        self._give_names = [name for name, _, _ in found for _ in range(6)]
        self._give_lengths = np.tile([True] * 3 + [False] * 3, count)

    def _by_springs(self, robot: ElasticRobot, at: Posture | None) -> None:
        """What is stated gives, as hard as it is."""
        k, placed = robot.kinematics, robot.placed(at)
        own = [int(k.model.idx_vs[k.model.getJointId(name)]) for name in self.chain.description.actuators]
        stiff, roots, names = list[int](), list[float](), list[str]()
        ways = np.zeros((k.model.nv, 0))
        for give in robot.gives:
            where = [int(k.model.idx_vs[k.model.getJointId(name)]) for name in give.joints]
            values, axes = np.linalg.eigh(k.column_scale[where][:, None] * give.matrix * k.column_scale[where])
            hard = values > 0.0
            columns = np.zeros((k.model.nv, int(hard.sum())))
            columns[where] = axes[:, hard]
            ways = np.concatenate([ways, columns], axis=1)
            roots += np.sqrt(values[hard]).tolist()
            names += [give.name] * int(hard.sum())
            stiff += [index for index, k_own in zip(where, np.diag(give.matrix), strict=True) if k_own > 0.0]
        slack = np.setdiff1d(np.arange(k.model.nv), [*stiff, *own])
        tool = placed.tool_jacobian * k.column_scale
        self._rows, self._tool, self._row_scale = placed.scaled[:, slack], tool[:, slack], k.row_scale
        self._length = k.length
        self._gives, self._give_tool = placed.scaled @ ways, tool @ ways
        self._roots, self._give_names = np.array(roots) / max(roots, default=1.0), names
        lengths = _lengths(k)
        self._give_lengths = np.array([np.abs(way[lengths]).max(initial=0.0) > 0.5 for way in ways.T], dtype=bool)

    def _strains(self, give: Array) -> tuple[Array, Array, tuple[str, ...]]:
        sizes = np.abs(give)
        lengths = sizes * self._give_lengths[:, None] * self._length
        turns = sizes * ~self._give_lengths[:, None]
        names = []
        for column in sizes.T:
            names.append(self._give_names[int(column.argmax())] if column.any() else "")
        return lengths.max(axis=0, initial=0.0), turns.max(axis=0, initial=0.0), tuple(names)


def _lengths(k: Kinematics) -> Array:
    """Whether velocities are lengths, of which `column_scale` is the robot's length."""
    kinds = [one for joint in range(1, k.model.njoints) for one in type_of(k.model, joint).lengths]
    return np.array(kinds, dtype=bool)


@door
def sensitivity(
    chain: ClosedChain, names: Sequence[str], at: Posture | None = None, springs: Springs | None = None
) -> Sensitivity:
    """How the tool follows numbers of a robot, its actuators held, in a posture (default home).

    Args:
        names: paths, patterns, joined paths or `actuators.NAME`, see `cutjoint.accuracy.deviations`.
        springs: what gives where the joints alone cannot follow; default all joints and cuts alike.

    Raises:
        UnknownNameError: nothing is called so.
        InputError: a number that does not say where the tool is, no tool, or no posture of this robot.
        ActuationError: the tool can move while the actuators hold.
    """
    found = sources(chain.description, list(names))
    return LoopFollower(chain, at, springs).sensitivity(found)
