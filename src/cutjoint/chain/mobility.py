"""Mobility of a closed robot at a posture: rank of its constraints, what the actuators determine, how near it is to a
singularity.

All matrices are scaled by the characteristic length, so singular values are dimensionless.  With K the constraint
Jacobian, split into actuated and passive columns K_a and K_p:

- mobility = velocities - rank K; rows beyond the rank are redundant.
- type-2 (parallel) singularity: K_p loses rank, so the robot moves with all actuators locked.
- type-1 (serial) singularity: the rows of the tool's Jacobian that are led lose rank, so the tool cannot move in some
  direction of its task.

Idle motions, such as a rod between two balls that spins about itself, are counted in the mobility; the actuators need
not determine them.  In actuated coordinates they are given no momentum (`cutjoint.chain.tangent`), at every single
state exactly.  That it stays so while the robot moves needs more: neither the reduced mass matrix nor gravity may
depend on where the idle motions are, as for a round rod between two balls; their coordinates are then cyclic.  A bent
rod that spins gains momentum from the motion of the others, and a link that merely hangs is a pendulum.

After Gosselin and Angeles, Singularity analysis of closed-loop kinematic chains, IEEE T. Robot. Autom. 6(3), 1990; and
Routh's elimination of cyclic coordinates, Stability of Motion, 1877.
"""

from __future__ import annotations

from functools import cached_property
from typing import Protocol

import numpy as np

from cutjoint import tolerances
from cutjoint.arrays import Array
from cutjoint.chain.closing.assembling import around
from cutjoint.chain.closing.drivers import Driver
from cutjoint.chain.closing.newton import settle
from cutjoint.chain.joints import joints_of
from cutjoint.chain.kinematics import Placed
from cutjoint.chain.mobility_report import MobilityReport
from cutjoint.chain.postures import Postures
from cutjoint.chain.rank import dependent_rows, rank_of
from cutjoint.chain.structure import AROUND, SHIFT, Structure, idle_motions, is_steady, locked_motions, scaled_tool
from cutjoint.chain.tangent import QuickTangent, QuickTangents, TangentMap, tangent_map
from cutjoint.errors import ActuationError, SingularError
from cutjoint.mechanism import Task

TURN = 0.3
"""By how much the robot is moved along its idle motions, in radians or characteristic lengths."""


class Chosen(Protocol):
    """The velocities that are taken as independent: those of the actuators (`cutjoint.chain.postures.Actuated`), or
    minimal coordinates (`cutjoint.chain.minimal.independent.Independent`)."""

    told: str
    n: int
    v_index: Array
    passive: Array
    lengths: Array

    def of(self, q: Array) -> Array:
        """What a configuration (nq,) has of them."""

    def hold(self, q: Array) -> Driver:
        """Keeps them as a configuration (nq,) has them."""

    def show(self, values: Array) -> str:
        """What `of` gives, in words."""


class Mobility:
    """Mobility of one robot: what is true of it at nearly every posture of its branch, and at single ones.

    Args:
        postures: of the robot.
        chosen: the velocities that are taken as independent; default those of the actuators, which are meant wherever
            actuators are spoken of.
    """

    def __init__(self, postures: Postures, chosen: Chosen | None = None) -> None:
        self.postures, self._k = postures, postures.k
        self.chosen: Chosen = postures.actuated if chosen is None else chosen

    def report(self, placed: Placed, task: Task | None = None) -> MobilityReport:
        """Mobility at one closed configuration; the tool is judged by a task, default its point."""
        k, nv = self._k, self._k.model.nv
        actuated, n, structure = self.chosen.v_index, self.chosen.n, self.structure
        matrix = placed.scaled
        rank = rank_of(matrix)
        locked = locked_motions(k, actuated, placed)
        idle = idle_motions(k, actuated, placed, locked)
        tangent = self._map(placed)
        regular = tangent.type2 > tolerances.RANK.value
        determined = regular and tangent.consistent and locked.shape[1] == structure.idle
        type1 = condition = float("nan")
        type2 = tangent.type2 if determined or self.is_determined else float("nan")
        if determined and k.tool_support is not None:
            jacobian = scaled_tool(k, placed) / k.column_scale @ tangent.map * k.column_scale[actuated]
            type1, condition = self._type1(placed, jacobian, task)
        return MobilityReport(
            velocities=nv,
            rows=k.closure.all_rows,
            rank=rank,
            mobility=nv - rank,
            redundant_rows=(*k.closure.left_out, *(k.closure.row_names[i] for i in dependent_rows(matrix))),
            dropped_rows=k.closure.left_out,
            actuators=n,
            determined=determined,
            idle_mobility=idle.shape[1],
            free=joints_of(k.model, locked),
            idle=joints_of(k.model, idle),
            type1=type1,
            type2=type2,
            condition=condition,
            gap=placed.gap[:2],
        )

    def _type1(self, placed: Placed, jacobian: Array, task: Task | None) -> tuple[float, float]:
        """Distance to a type-1 singularity and condition by the rows of a task, of the tool's Jacobian in actuated
        coordinates, dimensionless, shape (6, n)."""
        if task is None or task.is_of_point:
            jacobian, count = jacobian[:3], self.structure.directions
        else:
            pose = placed.tool_pose.moved(self._k.origin)
            jacobian, count = task.towards(pose, task.rows).matrix(pose.rotation) @ jacobian, len(task.rows)
        if not count:
            return float("nan"), float("nan")
        values = np.linalg.svd(jacobian, compute_uv=False)
        type1 = float(values[count - 1]) if len(values) >= count else 0.0
        return type1, float(values[0] / type1) if type1 > 0.0 else float("inf")

    # ---- at nearly every posture -----------------------------------------------------------------------------------

    @cached_property
    def regular(self) -> tuple[Placed, ...]:
        """Home and closed postures around it, home first."""
        found = [self.postures.at_home]
        for start in around(self._k, found[0].q, np.full(2 * AROUND, SHIFT)):
            closed = settle(self._k, start, None, 3.0 * SHIFT) if len(found) <= AROUND else None
            if closed is not None:
                found.append(closed)
        return tuple(found)

    @cached_property
    def structure(self) -> Structure:
        """Rank and freedoms at nearly every posture."""
        return Structure.of(self._k, self.chosen.v_index, list(self.regular))

    @cached_property
    def is_determined(self) -> bool:
        """Whether the actuators determine the motion at nearly every posture, but for idle motions."""
        usual = self.structure
        return usual.locked == usual.idle and usual.rank + usual.idle + self.chosen.n == self._k.model.nv

    @cached_property
    def idle_is_cyclic(self) -> bool:
        """Whether mass matrix and gravity in actuated coordinates are the same after a motion along any idle direction,
        and no spring or friction acts along it, at those of the regular postures that are not singular."""
        if not self.structure.idle:
            return True
        k, looked = self._k, False
        for placed in self.regular:
            try:
                here = self.tangent(placed)
            except SingularError:
                continue
            looked = True
            mass, gravity, weights = self._reduced(here, here, placed)
            for motion in here.idle.T:
                if k.physics.drags(motion, placed.elastic):
                    return False
                q = k.tree.integrate(placed.q, motion * (TURN / float(np.abs(motion / k.column_scale).max())))
                moved = settle(k, q, self.chosen.hold(q), 1.0)
                if moved is None:
                    return False
                mass_there, gravity_there, weights_there = self._reduced(self.tangent(moved), here, moved)
                size = np.sqrt(np.outer(np.diag(mass), np.diag(mass)))
                heavier = np.abs(mass_there - mass) > tolerances.DYNAMICS.value * size
                largest = np.maximum(weights, weights_there)
                if heavier.any() or (np.abs(gravity_there - gravity) > tolerances.DYNAMICS.value * largest).any():
                    return False
        return looked

    def _reduced(self, tangent: TangentMap, home: TangentMap, placed: Placed) -> tuple[Array, Array, Array]:
        """Mass matrix (n, n) and gravity (n,) in actuated coordinates, and of what size the terms of gravity are."""
        mass, gravity = self._k.tree.mass_matrix(placed.q), self._k.tree.gravity(placed.q)
        return tangent.map.T @ mass @ tangent.map, tangent.map.T @ gravity, np.abs(home.map.T) @ np.abs(gravity)

    # ---- tangent maps ----------------------------------------------------------------------------------------------

    @cached_property
    def quick(self) -> QuickTangents | None:
        """Quick tangent maps, where the actuators determine all of the motion."""
        own = self.chosen
        if not self.is_determined or self.structure.idle or not (own.n and len(own.passive)):
            return None
        steady = [placed for placed in self.regular if is_steady(self._k, placed)]
        if not steady:
            return None
        regular = max(steady, key=self.type2)
        return QuickTangents(self._k, own.v_index, own.passive, regular)

    def quick_tangent(self, placed: Placed) -> QuickTangent | None:
        """The quick tangent map at a closed configuration, where there is one."""
        return self.quick.at(placed) if self.quick is not None else None

    def tangent(self, placed: Placed) -> TangentMap:
        """Tangent map at a configuration where the actuators determine the motion.

        Raises:
            SingularError: type-2 singularity.
            ActuationError: the actuators do not determine the motion, here or anywhere.
        """
        usual, found, limit = self.structure, self._map(placed), tolerances.SINGULAR.value
        if usual.locked > usual.idle and not found.type2 > limit:
            raise self._not_determined(placed)
        if found.type2 < limit:
            raise SingularError(
                f"{self._k.name} at {self.chosen.show(self.chosen.of(placed.q))} is in a type-2 singularity: "
                f"with the {self.chosen.told} locked it still moves (singular value {found.type2:.2g}, limit "
                f"{limit:.0e})",
                kind="type-2",
                measure=found.type2,
                limit=limit,
            )
        if not found.consistent:
            raise self._not_determined(placed)
        return found

    def type2(self, placed: Placed) -> float:
        """Distance to a type-2 singularity."""
        return self._map(placed).type2

    def _map(self, placed: Placed) -> TangentMap:
        """Tangent map at any configuration, also where it means nothing."""
        return tangent_map(self._k, self.chosen.v_index, self.chosen.passive, placed, self.structure.idle)

    def _not_determined(self, placed: Placed) -> ActuationError:
        report, told = self.report(placed), self.chosen.told
        moving = [joint for joint in report.free if joint not in report.idle]
        if moving:
            why = f"with all {told} locked these joints still move: {', '.join(moving)}"
        else:
            needed = report.mobility - report.idle_mobility
            why = f"{report.actuators - needed} {told} more than the mobility depend on the others"
        return ActuationError(
            f"the {told} of {self._k.name} do not determine its motion: mobility {report.mobility}, {told} "
            f"{report.actuators}; {why}. Full coordinates still work",
            mobility=report.mobility,
            actuators=report.actuators,
            free=report.free,
        )
