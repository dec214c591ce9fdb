"""A robot in maximal coordinates at one configuration: its matrices, its mobility, its masses.

See `oracles.maximal` for the equations and for what is dimensionless.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from oracles.connections import Pose, Rows, cut_gap, cut_rows, joint_rows, placed_child, skew
from oracles.motion import State
from oracles.physics import Acting, Cushion, cut_motion, joint_coordinates
from oracles.reading import Array, Coupling
from oracles.solving import saddle

if TYPE_CHECKING:
    from oracles.maximal import Maximal

RANK = 1e-9
"""Singular values of the dimensionless constraints below this part of the largest are none."""


class Placed:
    """A robot at a configuration.

    Attributes:
        poses: link -> its pose in the world, from the oracle's origin.
        gaps: cut or coupling -> by how much it is open, ([m], [rad]).
        points: cut -> origin of its frame b.
        shares: coupling -> joint -> derivative of what the coupling says is zero by its coordinate.
        bends: coupling -> driver -> second derivative of its curve.
        acting, cushions: laws and bushings there (`oracles.physics`).
    """

    def __init__(self, oracle: Maximal, coordinates: Mapping[str, Array | float]) -> None:
        self.oracle, robot = oracle, oracle.robot
        self.poses = {robot.root: Pose(np.eye(3), -oracle.origin)}
        self._forbidden: list[Rows] = []
        self._measured: dict[str, Rows] = {}
        self.acting: dict[str, Acting] = {}
        for joint in robot.joints:
            value = coordinates[joint.name] if joint.kind != "fixed" else 0.0
            parent = self.poses[joint.parent]
            child = self.poses[joint.child] = placed_child(joint, parent, value)
            forbidden, self._measured[joint.name] = joint_rows(joint, parent, child)
            self._forbidden.append(forbidden)
            if (law := oracle.laws.get(joint.name)) is not None:
                own = joint_coordinates(joint.kind, value)
                self.acting[joint.name] = Acting(law, own, self._measured[joint.name], joint.kind == "spherical")
        self.gaps: dict[str, tuple[float, float]] = {}
        self._cuts: dict[str, Rows] = {}
        self.cushions: dict[str, Cushion] = {}
        self.points: dict[str, Array] = {}
        for cut in robot.cuts:
            a, b = (self.poses[frame.link].of(frame.rotation, frame.position) for frame in (cut.a, cut.b))
            self.points[cut.name] = b.position
            if (law := oracle.laws.get(cut.name)) is not None:
                self.acting[cut.name] = Acting(law, *cut_motion(cut, a, b), cut.kind == "spherical")
            if (bush := oracle.bushings.get(cut.name)) is not None:
                self.cushions[cut.name] = Cushion.of(bush, cut, a, b, self.poses, oracle.column)
                continue
            self._cuts[cut.name] = cut_rows(cut, a, b)
            self.gaps[cut.name] = cut_gap(cut, a, b)
        self.shares: dict[str, dict[str, float]] = {}
        self.bends: dict[str, dict[str, float]] = {}
        for gear in robot.couplings:
            curves = {name: curve(float(coordinates[name])) for name, curve in gear.curves.items()}
            self.shares[gear.name] = {gear.joint: 1.0, **{name: -slope for name, (_, slope, _) in curves.items()}}
            self.bends[gear.name] = {name: bend for name, (_, _, bend) in curves.items()}
            sum_of_all = sum(value for value, _, _ in curves.values()) + gear.offset
            apart = abs(float(coordinates[gear.joint]) - sum_of_all)
            self.gaps[gear.name] = (apart, 0.0) if self._slides(gear.joint) else (0.0, apart)

    @property
    def gap(self) -> float:
        """The widest gap, lengths as parts of the robot's."""
        return max((max(distance / self.oracle.length, angle) for distance, angle in self.gaps.values()), default=0.0)

    # ---- matrices --------------------------------------------------------------------------------------------------

    @cached_property
    def column_scale(self) -> Array:
        """What makes a twist of dimensionless components one in [m/s] and [rad/s], shape (6 bodies,)."""
        return np.tile(np.r_[np.full(3, self.oracle.length), np.ones(3)], self.oracle.size // 6)

    def relative(self, rows: Rows) -> Array:
        """Rows on relative twists as rows on the twists of all bodies, shape (k, 6 bodies)."""
        matrix = np.zeros((len(rows.matrix), self.oracle.size))
        for link, sign in ((rows.a, -1.0), (rows.b, 1.0)):
            if link in self.oracle.column:
                shift = np.eye(6)
                shift[:3, 3:] = -skew(rows.point - self.poses[link].position)
                matrix[:, self.oracle.column[link] :][:, :6] += sign * rows.matrix @ shift
        return matrix

    @cached_property
    def speeds(self) -> Array:
        """Joint velocities from twists, shape (velocities, 6 bodies)."""
        return np.concatenate([self.relative(rows) for rows in self._measured.values()])

    @cached_property
    def tree_rows(self) -> Array:
        """What the joints of the tree forbid, dimensionless rows on twists in [m/s], [rad/s]."""
        return np.concatenate([self._weighed(rows) for rows in self._forbidden])

    @cached_property
    def loop_rows(self) -> Array:
        """What cuts and couplings forbid, in their order, likewise dimensionless."""
        gears = [self._gear(gear, self.speeds) / self._unit(gear.joint) for gear in self.oracle.robot.couplings]
        cuts = [self._weighed(rows) for rows in self._cuts.values()]
        return np.concatenate([np.zeros((0, self.oracle.size)), *cuts, *gears])

    def _weighed(self, rows: Rows) -> Array:
        return self.relative(rows) / np.where(rows.is_length, self.oracle.length, 1.0)[:, None]

    def _gear(self, gear: Coupling, of: Array) -> Array:
        """The row of a coupling out of the rows (or accelerations) of all joint velocities, shape (1, ...)."""
        velocity = self.oracle.velocity
        return sum(share * of[velocity[name]] for name, share in self.shares[gear.name].items())

    def _slides(self, joint: str) -> bool:
        return next(one.kind for one in self.oracle.robot.joints if one.name == joint) == "prismatic"

    def _unit(self, joint: str) -> float:
        return self.oracle.length if self._slides(joint) else 1.0

    @cached_property
    def tree(self) -> Array:
        """Twists that unit velocities of the joints make, from the root outwards, shape (6 bodies, velocities)."""
        oracle = self.oracle
        twists = np.zeros((oracle.size, oracle.velocities))
        for joint in oracle.robot.joints:
            column, own = oracle.column[joint.child], oracle.velocity[joint.name]
            if joint.parent in oracle.column:
                shift = np.eye(6)
                shift[:3, 3:] = -skew(self.poses[joint.child].position - self.poses[joint.parent].position)
                twists[column : column + 6] = shift @ twists[oracle.column[joint.parent] :][:6]
            twists[column : column + 6, own] += self._measured[joint.name].matrix.T
        return twists

    # ---- mobility --------------------------------------------------------------------------------------------------

    @cached_property
    def _decomposed(self) -> tuple[Array, Array, Array]:
        rows = np.concatenate([self.tree_rows, self.loop_rows]) * self.column_scale
        return np.linalg.svd(rows)

    @property
    def singular_values(self) -> Array:
        """Of all constraints, dimensionless, the largest first, shape (6 bodies,) with zeros where there are fewer."""
        values = self._decomposed[1]
        return np.r_[values, np.zeros(self.oracle.size - len(values))] if len(values) < self.oracle.size else values

    @cached_property
    def rank(self) -> int:
        """Of all constraints."""
        values = self.singular_values
        return int(np.sum(values > RANK * values.max(initial=1.0)))

    @property
    def mobility(self) -> int:
        """Degrees of freedom left."""
        return self.oracle.size - self.rank

    @property
    def loop_rank(self) -> int:
        """How many of the loops' rows are independent."""
        return self.oracle.velocities - self.mobility

    @property
    def margin(self) -> tuple[float, float]:
        """The smallest singular value that counts and the largest that does not, as parts of the largest of all."""
        values = self.singular_values / max(self.singular_values.max(initial=0.0), 1e-300)
        kept, dropped = values[: self.rank], values[self.rank :]
        return float(kept.min(initial=1.0)), float(dropped.max(initial=0.0))

    @cached_property
    def motions(self) -> Array:
        """Orthonormal basis, in dimensionless twists, of the motions that are left, in [m/s], (6 bodies, mobility)."""
        return self.column_scale[:, None] * self._decomposed[2][self.rank :].T

    def joint_motions(self, basis: Array | None = None) -> Array:
        """The same as joint velocities, shape (velocities, mobility)."""
        return self.speeds @ (self.motions if basis is None else basis)

    @cached_property
    def locked(self) -> Array:
        """Basis of the motions that are left with all actuators locked, shape (6 bodies, k)."""
        held = self.joint_motions()[self._actuated] / self._velocity_scale[self._actuated, None]
        if not len(held) or not held.shape[1]:
            return self.motions
        _, values, right = np.linalg.svd(held)
        return self.motions @ right[int(np.sum(values > RANK)) :].T

    @property
    def idle(self) -> bool:
        """Whether all motions that are left with the actuators locked leave the tool where it is."""
        tool = self.oracle.robot.tool
        assert tool is not None, "idle is what does not move the tool"
        if tool.link not in self.oracle.column:
            return True
        pose = self.poses[tool.link]
        shift = np.eye(6)
        shift[:3, 3:] = -skew(pose.rotation @ tool.position)
        twists = shift @ self.locked[self.oracle.column[tool.link] :][:6]
        twists[:3] /= self.oracle.length
        return bool(np.abs(twists).max(initial=0.0) < RANK)

    @cached_property
    def _actuated(self) -> Array:
        own = [np.arange(self.oracle.velocities)[self.oracle.velocity[name]] for name in self.oracle.robot.actuators]
        return np.concatenate([np.zeros(0, dtype=int), *own])

    @cached_property
    def _velocity_scale(self) -> Array:
        rows = self._measured.values()
        flags = np.concatenate([np.zeros(0, dtype=bool), *(one.is_length for one in rows)])
        return np.where(flags, self.oracle.length, 1.0)

    # ---- masses ----------------------------------------------------------------------------------------------------

    def centre(self, link: str) -> Array:
        """Centre of mass of a link from its origin, world axes."""
        return self.poses[link].rotation @ self.oracle.robot.bodies[link].com

    def inertia(self, link: str) -> Array:
        """Inertia about the link's origin, world axes, shape (3, 3)."""
        body, rotation, c = self.oracle.robot.bodies[link], self.poses[link].rotation, self.centre(link)
        return rotation @ body.inertia @ rotation.T + body.mass * ((c @ c) * np.eye(3) - np.outer(c, c))

    @cached_property
    def mass(self) -> Array:
        """Mass matrix of all bodies and of the rotors between them, shape (6 bodies, 6 bodies)."""
        return self.bodies + sum(
            (rows.T @ rows * weight for rows, weight, _ in self.rotors), np.zeros_like(self.bodies)
        )

    @cached_property
    def rotors(self) -> list[tuple[Array, float, Rows]]:
        """Rows of velocities that a rotor adds to, on the twists of all bodies, with its weight there [kg m2, kg]."""
        heavy = [one for one in self.acting.values() if one.law.armature]
        return [(self.relative(one.rows), one.law.armature, one.rows) for one in heavy]

    @cached_property
    def bodies(self) -> Array:
        """Mass matrix of the bodies alone, shape (6 bodies, 6 bodies)."""
        mass = np.zeros((self.oracle.size, self.oracle.size))
        for link, start in self.oracle.column.items():
            m = self.oracle.robot.bodies[link].mass
            arm = m * skew(self.centre(link))
            mass[start : start + 6, start : start + 6] = np.block([[m * np.eye(3), -arm], [arm, self.inertia(link)]])
        return mass

    @cached_property
    def heaviest(self) -> float:
        """Largest entry of the mass matrix for dimensionless twists; 1 where nothing has mass."""
        return float((np.diag(self.mass) * self.column_scale**2).max(initial=0.0)) or 1.0

    @cached_property
    def weight(self) -> Array:
        """Wrenches of gravity at the links' origins, shape (6 bodies,)."""
        weight = np.zeros(self.oracle.size)
        for link, start in self.oracle.column.items():
            force = self.oracle.robot.bodies[link].mass * self.oracle.robot.gravity
            weight[start : start + 6] = np.r_[force, np.cross(self.centre(link), force)]
        return weight

    @cached_property
    def potential_energy(self) -> float:
        """Energy [J] of gravity of all links that joints can move, zero at the world's origin, and of all springs."""
        fixed = {self.oracle.robot.root}
        energy = float(sum(one.energy for one in (*self.acting.values(), *self.cushions.values())))
        for joint in self.oracle.robot.joints:
            if joint.kind == "fixed" and joint.parent in fixed:
                fixed.add(joint.child)
                continue
            at = self.oracle.origin + self.poses[joint.child].position + self.centre(joint.child)
            energy -= self.oracle.robot.bodies[joint.child].mass * float(self.oracle.robot.gravity @ at)
        return energy

    def wrench(self, link: str, force: Array, moment: Array, point: Array) -> Array:
        """A force at a point of a link (in its frame) and a moment, world axes: wrenches of all bodies, (6 bodies,)."""
        found = np.zeros(self.oracle.size)
        if (start := self.oracle.column.get(link)) is not None:
            arm = self.poses[link].rotation @ point
            found[start : start + 6] = np.r_[force, moment + np.cross(arm, force)]
        return found

    def moving(self, velocities: Mapping[str, Array | float], outside: Array | float = 0.0) -> State:
        """The robot moving with velocities of all joints, by name; those left out stand still.  `outside` are wrenches
        on the bodies, shape (6 bodies,)."""
        return State(self, self.tree @ self.oracle.flat(velocities), outside)

    def with_actuators(self, velocities: Mapping[str, float], outside: Array | float = 0.0) -> State:
        """The motion of least kinetic energy in which the actuators have these velocities.

        Where the actuators determine the motion it is the only one; else the freedoms that are left get no momentum.
        """
        wanted = self.oracle.flat(velocities)[self._actuated]
        basis = self.motions
        held = self.joint_motions()[self._actuated]
        y = saddle(basis.T @ self.mass @ basis, held, np.zeros(basis.shape[1]), wanted, self.heaviest)[0]
        return State(self, basis @ y, outside)
