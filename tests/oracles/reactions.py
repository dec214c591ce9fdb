"""What every joint and cut of a motion carries, from the multipliers of all rows at once, and what is not unique.

With G the rows of all joints, cuts and couplings, dimensionless, the bodies want

    G' f = M A + b - W - efforts - physics

Where rows are redundant, f is one of many: f + N z with N a basis of the stresses G' f = 0.  The least one has the
least sum of f^2, that is of L^2 |force|^2 + |moment|^2 over all joints and cuts, each at its own point.  With
stiffnesses, the sum is that of w' C w, with w the wrench that a joint holds and C its compliance; what these leave open
is least again.

    Reactions(motion).of["crank"]                       # force, moment of the parent on the child, world axes
    Reactions(motion, {"pin": 1e6, "crank": [...]}).of  # joints that are not named are rigid
    Reactions(motion).stresses("pin")                   # (6, k): what the stresses do there; zero rows are unique
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from oracles.motion import Motion
from oracles.reading import Array
from oracles.solving import residual


class Reactions:
    """Of a motion; stiffnesses are numbers, [N/m] (moments with L^2), or six along the axes of the child or frame b."""

    def __init__(self, motion: Motion, stiffness: Mapping[str, float | Array] | None = None) -> None:
        self.motion, self.stiffness = motion, dict(stiffness or {})
        self.p = p = motion.state.placed
        tree = zip((joint.name for joint in p.oracle.robot.joints), p._forbidden, strict=True)
        self.rows = dict([*tree, *p._cuts.items()])
        self.own: dict[str, slice] = {}
        count = 0
        for name, rows in self.rows.items():
            self.own[name] = slice(count, count + len(rows.matrix))
            count += len(rows.matrix)
        for gear in p.oracle.robot.couplings:
            self.own[gear.name] = slice(count, count + 1)
            count += 1
        self.count = count

    @cached_property
    def null(self) -> Array:
        """Orthonormal stresses, shape (rows, k)."""
        return self._split[0][:, self.p.rank :]

    @cached_property
    def _split(self) -> tuple[Array, Array, Array]:
        if not self.count:
            return np.zeros((0, 0)), np.zeros(0), np.eye(self.p.oracle.size)
        return self.p._decomposed

    @cached_property
    def multipliers(self) -> Array:
        """f of all rows, shape (rows,)."""
        p, (left, values, right) = self.p, self._split
        rows = np.concatenate([p.tree_rows, p.loop_rows]) * p.column_scale
        wanted, found = p.column_scale * self.motion.reaction, np.zeros(self.count)
        for _ in range(2):
            missing = residual(rows.T, found, wanted)
            found = found + left[:, : p.rank] @ ((right[: p.rank] @ missing) / values[: p.rank])
        if not (self.stiffness and self.null.shape[1]):
            return found
        weights, values, vectors = self._weights, *np.linalg.eigh(self.null.T @ self._weights @ self.null)
        heavy = values > 1e-13 * np.abs(weights).max(initial=0.0)
        decided = self.null @ vectors[:, heavy]
        found = found - decided @ ((decided.T @ weights @ found) / values[heavy])
        left_open = self.null @ vectors[:, ~heavy]
        return found - left_open @ (left_open.T @ found)

    @cached_property
    def _weights(self) -> Array:
        """Compliance of all rows, shape (rows, rows)."""
        weights, length = np.zeros((self.count, self.count)), self.p.oracle.length
        for name, values in self.stiffness.items():
            own, k = self.own[name], np.asarray(values, dtype=float)
            if name not in self.rows:
                gear = next(gear for gear in self.p.oracle.robot.couplings if gear.name == name)
                weights[own, own] = 1.0 / (k * self.p._unit(gear.joint) ** 2)
                continue
            k = k * np.r_[1.0, 1.0, 1.0, [length**2] * 3] if k.ndim == 0 else k
            axes = self._axes(name)
            turned = np.zeros((6, 6))
            turned[:3, :3] = axes @ np.diag(1.0 / k[:3]) @ axes.T
            turned[3:, 3:] = axes @ np.diag(1.0 / k[3:]) @ axes.T
            matrix = self._matrix(name)
            weights[own, own] = matrix @ turned @ matrix.T
        return weights

    def _axes(self, name: str) -> Array:
        for joint in self.p.oracle.robot.joints:
            if joint.name == name:
                return self.p.poses[joint.child].rotation
        frame = next(cut.b for cut in self.p.oracle.robot.cuts if cut.name == name)
        return self.p.poses[frame.link].rotation @ frame.rotation

    def _matrix(self, name: str) -> Array:
        """Wrenches of unit multipliers of a joint's rows, shape (k, 6)."""
        rows = self.rows[name]
        return rows.matrix / np.where(rows.is_length, self.p.oracle.length, 1.0)[:, None]

    def _own_of(self, name: str) -> Array:
        """What a joint or cut does along its free motion: physics less what its rotor asks for, shape (velocities,)."""
        p, state, one = self.p, self.motion.state, self.p.acting[name]
        change = p.relative(one.rows) @ self.motion.accelerations + state.drift(one.rows)
        return sum(state.own_forces[name]) - one.law.armature * change

    @cached_property
    def of(self) -> dict[str, tuple[Array, Array]]:
        """Joint or cut -> force and moment of parent (a) on child (b) at the child's origin (of frame b), world axes:
        all that passes there, efforts, couplings and physics included."""
        p, found, efforts = self.p, {}, self.motion.efforts.copy()
        for gear in p.oracle.robot.couplings:
            force = self.multipliers[self.own[gear.name]] / p._unit(gear.joint)
            for joint, share in p.shares[gear.name].items():
                efforts[p.oracle.velocity[joint]] += share * force
        for name in (*p._measured, *p.points):
            both = self._matrix(name).T @ self.multipliers[self.own[name]] if name in self.rows else np.zeros(6)
            if name in p._measured:
                both = both + p._measured[name].matrix.T @ efforts[p.oracle.velocity[name]]
            if name in p.acting:
                both = both + p.acting[name].rows.matrix.T @ self._own_of(name)
            if name in p.cushions:
                both = both + p.cushions[name].own.T @ p.cushions[name].forces(self.motion.state.twists)
            found[name] = (both[:3], both[3:])
        return found

    def stresses(self, name: str) -> Array:
        """What the stresses do in a joint or cut: forces [N L] and moments [N m], gears included, shape (6, k)."""
        p = self.p
        both = (
            self._matrix(name).T @ self.null[self.own[name]] if name in self.rows else np.zeros((6, self.null.shape[1]))
        )
        for gear in p.oracle.robot.couplings:
            force = self.null[self.own[gear.name]] / p._unit(gear.joint)
            for joint, weight in p.shares[gear.name].items():
                if joint == name:
                    both = both + p._measured[name].matrix.T @ (weight * force)
        return both * np.r_[[p.oracle.length] * 3, [1.0] * 3][:, None]
