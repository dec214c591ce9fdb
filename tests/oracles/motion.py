"""Newton's and Euler's equations of a robot in maximal coordinates, solved for accelerations, forces and efforts.

See `oracles.maximal` for the equations.  With N a basis of the motions that are left and A = A0 + N y,

    N' M N y = N' (W - b + efforts - M A0)

is the projected equation; the multipliers of the tree's joints follow exactly, those of cuts and couplings are the
least ones in the dimensionless rows (only their sum acts where rows are redundant).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from oracles.connections import Rows
from oracles.reading import Array
from oracles.solving import MASSLESS, MOVED, residual, saddle

if TYPE_CHECKING:
    from oracles.placed import Placed


class State:
    """A placed robot with twists of all bodies (6 bodies,), and wrenches from outside on them."""

    def __init__(self, placed: Placed, twists: Array, outside: Array | float = 0.0) -> None:
        self.placed, self.twists = placed, twists
        self.outside = outside + np.zeros(placed.oracle.size)

    @property
    def unmet(self) -> float:
        """Largest dimensionless rate at which the twists would break a constraint."""
        p = self.placed
        return float(np.abs(np.concatenate([p.tree_rows, p.loop_rows]) @ self.twists).max(initial=0.0))

    @property
    def speeds(self) -> dict[str, Array]:
        """Velocities of the joints."""
        return self._by_joint(self.placed.speeds @ self.twists)

    @property
    def kinetic_energy(self) -> float:
        """[J]."""
        return 0.5 * float(self.twists @ self.placed.mass @ self.twists)

    def twist(self, link: str) -> tuple[Array, Array]:
        """Velocity of a link's origin and angular velocity, world axes."""
        start = self.placed.oracle.column.get(link)
        both = np.zeros(6) if start is None else self.twists[start : start + 6]
        return both[:3], both[3:]

    def momentum(self) -> tuple[Array, Array]:
        """Momentum and angular momentum about the world's origin of all bodies."""
        linear, angular = np.zeros(3), np.zeros(3)
        wrench = self.placed.mass @ self.twists
        for link, start in self.placed.oracle.column.items():
            linear += wrench[start : start + 3]
            angular += wrench[start + 3 : start + 6]
            angular += np.cross(self.placed.poses[link].position, wrench[start : start + 3])
        return linear, angular

    # ---- what velocities make --------------------------------------------------------------------------------------

    def drift(self, rows: Rows) -> Array:
        """Time derivative of rows . relative twist where no body accelerates, shape (k,)."""
        (v_a, w_a), (v_b, w_b) = self.twist(rows.a), self.twist(rows.b)
        r_a, r_b = (rows.point - self.placed.poses[link].position for link in (rows.a, rows.b))
        point = v_b + np.cross(w_b, r_b)
        relative = np.r_[point - v_a - np.cross(w_a, r_a), w_b - w_a]
        bias = np.cross(w_b, np.cross(w_b, r_b)) - np.cross(w_a, point - v_a)
        return rows.matrix[:, :3] @ bias + rows.rates(w_a, w_b, relative) @ relative

    @cached_property
    def joint_drift(self) -> Array:
        """Accelerations of the joints where no body accelerates, shape (velocities,)."""
        return np.concatenate([self.drift(rows) for rows in self.placed._measured.values()])

    @cached_property
    def constraint_drift(self) -> Array:
        """Time derivative of all dimensionless constraints where no body accelerates."""
        p = self.placed
        scaled = [
            self.drift(rows) / np.where(rows.is_length, p.oracle.length, 1.0)
            for rows in (*p._forbidden, *p._cuts.values())
        ]
        gears = [
            (p._gear(gear, self.joint_drift) - self._curving(gear.name)) / p._unit(gear.joint)
            for gear in p.oracle.robot.couplings
        ]
        return np.concatenate([np.zeros(0), *scaled, *gears])

    def _curving(self, gear: str) -> float:
        """What the curves of a coupling add to the acceleration of its joint at these velocities."""
        p, speeds = self.placed, self.placed.speeds @ self.twists
        return sum(bend * float(speeds[p.oracle.velocity[name]][0]) ** 2 for name, bend in p.bends[gear].items())

    @cached_property
    def gyroscopic(self) -> Array:
        """b of M A + b: wrenches that the velocities ask for, of bodies and rotors, shape (6 bodies,)."""
        rotors = (weight * (matrix.T @ self.drift(rows)) for matrix, weight, rows in self.placed.rotors)
        return sum(rotors, self.gyroscopic_of_bodies.copy())

    @cached_property
    def gyroscopic_of_bodies(self) -> Array:
        """Those of the bodies alone, shape (6 bodies,)."""
        wrench = np.zeros(self.placed.oracle.size)
        for link, start in self.placed.oracle.column.items():
            w, c = self.twist(link)[1], self.placed.centre(link)
            mass = self.placed.oracle.robot.bodies[link].mass
            wrench[start : start + 3] = mass * np.cross(w, np.cross(w, c))
            wrench[start + 3 : start + 6] = np.cross(w, self.placed.inertia(link) @ w)
        return wrench

    @cached_property
    def start(self) -> Array:
        """A0: the least accelerations that the constraints ask for, shape (6 bodies,)."""
        p = self.placed
        left, values, right = p._decomposed
        rank = p.rank
        wanted = -self.constraint_drift
        scaled = np.concatenate([p.tree_rows, p.loop_rows]) * p.column_scale
        found = np.zeros(p.oracle.size)
        for _ in range(2):
            missing = residual(scaled, found, wanted)
            found = found + right[:rank].T @ ((left[:, :rank].T @ missing) / values[:rank])
        return p.column_scale * found

    # ---- what joints and cuts do by themselves ---------------------------------------------------------------------

    @cached_property
    def own_forces(self) -> dict[str, tuple[Array, Array]]:
        """Joint or cut with a law -> forces that store energy and that waste it, on its velocities."""
        p = self.placed
        return {name: one.forces(p.relative(one.rows) @ self.twists) for name, one in p.acting.items()}

    @cached_property
    def physics(self) -> Array:
        """Springs, dampers, friction, stops and bushings as wrenches on the bodies, shape (6 bodies,)."""
        p, found = self.placed, np.zeros(self.placed.oracle.size)
        for name, (stored, wasted) in self.own_forces.items():
            found += p.relative(p.acting[name].rows).T @ (stored + wasted)
        for one in p.cushions.values():
            found += one.rows.T @ one.forces(self.twists)
        return found

    @property
    def wasted(self) -> float:
        """Power that dampers and friction take [W]."""
        p = self.placed
        power = sum(
            float(one[1] @ p.relative(p.acting[name].rows) @ self.twists) for name, one in self.own_forces.items()
        )
        for one in p.cushions.values():
            power -= float(one.damping @ (one.rows @ self.twists) ** 2)
        return -power

    @property
    def load(self) -> Array:
        """All wrenches on the bodies that are neither reactions nor motors', less what the velocities ask for."""
        return self.placed.weight + self.outside + self.physics - self.gyroscopic

    # ---- dynamics --------------------------------------------------------------------------------------------------

    @cached_property
    def _energy(self) -> Array:
        return self.placed.motions.T @ self.placed.mass @ self.placed.motions

    @cached_property
    def massless(self) -> Array:
        """Basis of the motions that are left and move no mass, as joint velocities, shape (velocities, k)."""
        values, vectors = np.linalg.eigh(self._energy)
        return self.placed.joint_motions(self.placed.motions @ vectors[:, values <= MASSLESS * self.placed.heaviest])

    def driven(self, efforts: Mapping[str, Array | float]) -> Motion:
        """The motion that efforts of joints give, by name; joints left out have none."""
        p, basis = self.placed, self.placed.motions
        effort = p.oracle.flat(efforts)
        load = self.load + p.speeds.T @ effort
        force = basis.T @ residual(p.mass, self.start, load)
        y = saddle(self._energy, np.zeros((0, len(force))), force, np.zeros(0), p.heaviest)[0]
        return Motion(self, self.start + basis @ y, load, effort)

    def led(self, accelerations: Mapping[str, float]) -> tuple[dict[str, float], Motion]:
        """The efforts with which the actuators have these accelerations, and the motion.

        Freedoms that the actuators leave accelerate as no effort drives them.  Where there are more actuators than
        freedoms, the efforts are some that do it; `efforts_for` gives the least ones.
        """
        p, basis = self.placed, self.placed.motions
        own = p._actuated
        held = p.joint_motions()[own]
        wanted = p.oracle.flat(accelerations)[own] - self.joint_drift[own] - p.speeds[own] @ self.start
        load = self.load
        force = basis.T @ residual(p.mass, self.start, load)
        y, effort = saddle(self._energy, held, force, wanted, p.heaviest)
        named = dict(zip(p.oracle.robot.actuators, map(float, effort), strict=True))
        return named, Motion(self, self.start + basis @ y, load + p.speeds[own].T @ effort, p.oracle.flat(named))

    def efforts_for(self, accelerations: Mapping[str, Array | float]) -> tuple[dict[str, float], float]:
        """Least efforts of the actuators for accelerations of all joints, and what part of the need they cannot meet.

        The part is the largest generalised force that stays, against the largest of the terms that make up the need.
        """
        p, basis = self.placed, self.placed.motions
        twists = p.tree @ p.oracle.flat(accelerations)
        wrenches = p.mass @ (twists + self._tree_start), -self.load
        needed = basis.T @ sum(wrenches)
        acting = p.joint_motions()[p._actuated].T
        # which motions the actuators act on at all is decided on dimensionless rows
        directions, values = np.linalg.svd(acting / p._velocity_scale[p._actuated])[:2]
        served = directions[:, : int(np.sum(values > MOVED))].T
        effort = np.linalg.pinv(served @ acting, rcond=0.0) @ (served @ needed)
        left = needed - acting @ effort
        terms = np.abs(basis.T) @ sum(map(np.abs, wrenches))
        part = float(np.abs(left).max(initial=0.0) / max(terms.max(initial=0.0), 1e-300))
        return dict(zip(p.oracle.robot.actuators, map(float, effort), strict=True)), part

    @cached_property
    def _tree_start(self) -> Array:
        """Accelerations of the bodies where all joints keep their velocities, shape (6 bodies,)."""
        p = self.placed
        square = np.concatenate([p.tree_rows, p.speeds])
        count = len(p.tree_rows)
        right = np.r_[-self.constraint_drift[:count], -self.joint_drift]
        found = np.zeros(p.oracle.size)
        for _ in range(2):
            found = found + np.linalg.solve(square, residual(square, found, right))
        return found

    def _by_joint(self, flat: Array) -> dict[str, Array]:
        return {name: flat[own] for name, own in self.placed.oracle.velocity.items()}


@dataclass(frozen=True)
class Motion:
    """Accelerations (6 bodies,) of a state, the wrenches (6 bodies,) on the bodies that are no reactions, and the
    efforts (velocities,) of the joints among them."""

    state: State
    accelerations: Array
    load: Array
    efforts: Array

    @cached_property
    def flat(self) -> Array:
        """Accelerations of all joints, shape (velocities,)."""
        return self.state.placed.speeds @ self.accelerations + self.state.joint_drift

    @property
    def joints(self) -> dict[str, Array]:
        """The same by joint."""
        return self.state._by_joint(self.flat)

    @cached_property
    def reaction(self) -> Array:
        """What all constraints together do to the bodies, shape (6 bodies,)."""
        return -residual(self.state.placed.mass, self.accelerations, self.load)

    @cached_property
    def _loops(self) -> Array:
        """Multipliers of the dimensionless rows of cuts and couplings, the least ones that do the work."""
        p = self.state.placed
        scale = p._velocity_scale
        rows = (p.loop_rows @ p.tree) * scale
        if not len(rows):
            return np.zeros(0)
        left, values, right = np.linalg.svd(rows)
        rank = p.loop_rank
        wanted, found = scale * (p.tree.T @ self.reaction), np.zeros(len(rows))
        for _ in range(2):
            missing = residual(rows.T, found, wanted)
            found = found + left[:, :rank] @ ((right[:rank] @ missing) / values[:rank])
        return found

    @cached_property
    def wrenches(self) -> dict[str, tuple[Array, Array]]:
        """Cut -> force and moment of a on b at the origin of frame b, world axes."""
        found, start = {}, 0
        for name, rows in self.state.placed._cuts.items():
            count = len(rows.matrix)
            weights = np.where(rows.is_length, self.state.placed.oracle.length, 1.0)
            wrench = rows.matrix.T @ (self._loops[start : start + count] / weights)
            found[name] = (wrench[:3], wrench[3:])
            start += count
        return found

    @cached_property
    def couplings(self) -> dict[str, float]:
        """Coupling -> generalised force on its joint."""
        p = self.state.placed
        gears = p.oracle.robot.couplings
        values = self._loops[len(self._loops) - len(gears) :]
        return {gear.name: float(f / p._unit(gear.joint)) for gear, f in zip(gears, values, strict=True)}

    @cached_property
    def unmet(self) -> tuple[float, float]:
        """What is left of the two equations: of the constraints (dimensionless), and of the momenta along the motions
        of the tree that the loops' forces leave, against the largest of their terms."""
        p = self.state.placed
        rows = np.concatenate([p.tree_rows, p.loop_rows])
        kinematic = float(np.abs(rows @ self.accelerations + self.state.constraint_drift).max(initial=0.0))
        along = p.tree.T @ self.reaction - p.tree.T @ (p.loop_rows.T @ self._loops)
        terms = np.abs(p.tree.T) @ (np.abs(p.mass) @ np.abs(self.accelerations) + np.abs(self.load))
        return kinematic, float(np.abs(along).max(initial=0.0) / max(terms.max(initial=0.0), 1e-300))
