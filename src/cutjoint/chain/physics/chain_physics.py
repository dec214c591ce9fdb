"""What the joints and cuts of a chain do by themselves, as generalised forces of its tree.

The forces are told in `cutjoint.mechanism.physics`.  Here they are efforts: what it takes to overcome them, so they
stand on the side of the inertia, M a + h + springs + friction = effort + K' f.

- joints: along their coordinates; a ball by its rotation vector and its angular velocity
- the free motion of a cut: along the coordinates that it leaves free, from the world axes of both frames
- bushings: K' (k r + c K v) with the rows K and the residual r of the cut's equations.  K is the exact gradient of
  r' r / 2 however far the frames are apart, so energy is kept: k r' r / 2 is the potential.

Springs are what depends on the posture alone and has a potential; friction is the rest, and friction @ v >= 0 is lost.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.bound import BoundCut
from cutjoint.chain.closure import Closure, CutFrames
from cutjoint.chain.physics.free_motion import FreeMotion
from cutjoint.chain.physics.joint_forces import JointForces, balls, resisted
from cutjoint.description.model import CutJoint, RobotDescription
from cutjoint.errors import DynamicsError
from cutjoint.mechanism.physics import Bushing
from cutjoint.reprs import line

MEETING = 1e-9
"""Ends of a spring that are nearer than this part of its length are one point."""

DRAGGED = 1e-9
"""A motion whose part along a coordinate is below this part of its largest does not move it."""


@dataclass(frozen=True, eq=False)
class Elastic:
    """Where the frames of the cuts that do something by themselves are, and what moves them.

    Attributes:
        frames: a and b of the bushings, then of the cuts with a free motion that is held or damped.
        twists: joint Jacobians about the origin, shape (6, nv).
    """

    frames: CutFrames
    twists: Array

    __repr__ = line()


class ChainPhysics:
    """Dampers, dry friction, springs, stops and bushings of one robot.

    Attributes:
        acts: whether there is any of it.
        cuts: the bushings, then the other cuts that do something: those whose frames are needed.
        sticking: velocities whose friction holds what rests (stiction), and by how much: index -> [N] or [N m].
    """

    __repr__ = line("acts")

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        bushings = tuple(cut for cut in description.cuts if cut.bushing is not None)
        free = tuple(cut for cut in description.closing if cut.physics.acts)
        self.cuts: tuple[CutJoint, ...] = (*bushings, *free)
        self._joints = JointForces(model, description)
        self._balls = balls(model, description)
        self._free = [FreeMotion(cut, BoundCut.of(model, cut)) for cut in free]
        rigid = tuple(replace(cut, bushing=None) for cut in bushings)
        self._closure = Closure(model, replace(description, cuts=rigid, couplings=()))
        self._count = len(bushings)
        by_row = [(cut.bushing, one.is_length) for cut in bushings for one in cut.type.equations for _ in one.labels]
        self._stiff = np.array([_of_row(one, length, "stiffness") for one, length in by_row])
        self._viscous = np.array([_of_row(one, length, "damping") for one, length in by_row])
        self.acts = bool(self.cuts or self._balls or self._joints.acts)
        self.sticking = self._joints.sticking

    def springs(self, q: Array, elastic: Elastic | None = None) -> Array:
        """Effort that holds springs, bushings and stops at a configuration (nq,), shape (nv,)."""
        held = self._joints.springs(q)
        for ball in self._balls:
            held[ball.at] += ball.spring(q)
        if elastic is not None:
            rows, residual = self._bushings(elastic, q)
            held += rows.T @ (self._stiff * residual)
            for cut, row, coordinate in self._coordinates(elastic):
                held += row.T @ cut.spring(coordinate)
        return held

    def friction(self, q: Array, v: Array, elastic: Elastic | None = None) -> Array:
        """Effort that overcomes dampers and friction at a velocity (nv,), shape (nv,)."""
        lost = self._joints.friction(q, v)
        for ball in self._balls:
            lost[ball.at] += ball.friction(v)
        if elastic is not None:
            rows, _ = self._bushings(elastic, q)
            lost += rows.T @ (self._viscous * (rows @ v))
            for cut, row, _ in self._coordinates(elastic):
                lost += row.T @ resisted(cut.physics, row @ v)
        return lost

    def potential(self, q: Array, elastic: Elastic | None = None) -> float:
        """Energy in springs, bushings and stops [J]."""
        energy = self._joints.potential(q) + sum(ball.potential(q) for ball in self._balls)
        if elastic is not None:
            _, residual = self._bushings(elastic, q)
            energy += 0.5 * float(self._stiff @ residual**2)
            for cut, _, coordinate in self._coordinates(elastic):
                energy += cut.potential(coordinate)
        return energy

    def wrenches(self, q: Array, v: Array, elastic: Elastic) -> list[tuple[Array, Array]]:
        """What every one of `cuts` does by itself to its bodies A and B, about the origin, shape (6,) each."""
        frames, count = elastic.frames, self._count
        gather = self._closure.gather(_part(frames, slice(0, count)))
        rows, residual = self._bushings(elastic, q)
        pulls = -(gather.T @ (self._stiff * residual + self._viscous * (rows @ v))).reshape(2, count, 6)
        found = [(pulls[0, index], pulls[1, index]) for index in range(count)]
        for index, cut in enumerate(self._free, start=count):
            on_b = cut.wrench(_part(frames, slice(index, index + 1)), elastic.twists, v)
            found.append((-on_b, on_b))
        return found

    def drags(self, motion: Array, elastic: Elastic | None = None) -> bool:
        """Whether any of it acts along a motion (nv,)."""
        moved = np.abs(motion) > DRAGGED * np.abs(motion).max(initial=0.0)
        if moved[self._joints.held].any() or any(moved[ball.at].any() for ball in self._balls):
            return True
        if elastic is None:
            return False
        rows = [self._bushings(elastic, None)[0], *(row for _, row, _ in self._coordinates(elastic))]
        size = np.abs(np.concatenate([row.reshape(-1, motion.size) for row in rows]))
        along = np.abs(np.concatenate([row @ motion for row in rows]))
        return bool((along > DRAGGED * (size @ np.abs(motion))).any())

    def _bushings(self, elastic: Elastic, q: Array | None) -> tuple[Array, Array]:
        """Rows (rows, nv) and residual (rows,) of the bushings; the residual is nothing without a configuration."""
        closure, frames = self._closure, _part(elastic.frames, slice(0, self._count))
        self._refuse_meeting(frames)
        rows = closure.jacobian(closure.gather(frames), elastic.twists, np.zeros(0))
        return rows, np.zeros(0) if q is None else closure.residual(frames, q)

    def _refuse_meeting(self, frames: CutFrames) -> None:
        """Raises DynamicsError where the ends of a spring of some length meet, so that it has no direction."""
        for cut, a, b in zip(self.cuts, frames.at_a, frames.at_b, strict=False):
            if cut.type.has_length and not float(np.linalg.norm(b - a)) > MEETING * cut.length:
                raise DynamicsError(
                    f"the ends of cut '{cut.name}' meet, so its bushing, {cut.length:g} m long at rest, has no "
                    "direction to push in; start where they are apart, or make it a spherical cut, whose length is 0",
                    residual=np.inf,
                )

    def _coordinates(self, elastic: Elastic) -> list[tuple[FreeMotion, Array, Array]]:
        """Of every freedom of every other cut: its rows (k, nv) and its values (k,)."""
        found = []
        for index, cut in enumerate(self._free, start=self._count):
            frames = _part(elastic.frames, slice(index, index + 1))
            found += [(cut, row, value) for row, value in cut.coordinates(frames, elastic.twists)]
        return found


def _of_row(bushing: Bushing | None, is_length: bool, what: str) -> float:
    return float(getattr(bushing, what if is_length else f"turning_{what}"))


def _part(frames: CutFrames, which: slice) -> CutFrames:
    return CutFrames(frames.axes_a[which], frames.axes_b[which], frames.at_a[which], frames.at_b[which])
