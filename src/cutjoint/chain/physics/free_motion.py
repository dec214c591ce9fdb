"""The motion that a rigid cut leaves free: its coordinates and what moves them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.bound import BoundCut
from cutjoint.chain.closure import CutFrames
from cutjoint.chain.physics.joint_forces import resisted
from cutjoint.description.cuts import Freedom
from cutjoint.description.model import CutJoint
from cutjoint.mechanism.physics import JointPhysics


@dataclass(frozen=True, eq=False)
class FreeMotion:
    """The motion that a rigid cut leaves free."""

    cut: CutJoint
    bound: BoundCut

    @property
    def physics(self) -> JointPhysics:
        """What acts along it."""
        return self.cut.physics

    def spring(self, coordinates: Array) -> Array:
        """Effort that holds its spring, (k,)."""
        return self.physics.stiffness * self._stretched(coordinates)

    def potential(self, coordinates: Array) -> float:
        """Energy in its spring [J]."""
        stretched = self._stretched(coordinates)
        return 0.5 * self.physics.stiffness * float(stretched @ stretched)

    def _stretched(self, coordinates: Array) -> Array:
        return np.asarray(coordinates - (self.physics.rest or 0.0))

    def wrench(self, frames: CutFrames, twists: Array, v: Array) -> Array:
        """What it does to body B at a velocity `v` (nv,), about the origin, shape (6,); the opposite it does to A."""
        end = End(frames.axes_a[0], frames.axes_b[0], frames.at_a[0], frames.at_b[0])
        apart = twists @ ((self.bound.support_b - self.bound.support_a) * v)
        found = np.zeros(6)
        for freedom in self.cut.type.freedoms:
            row, value = COORDINATES[freedom](end, np.eye(6))
            found -= row.T @ (self.spring(value) + resisted(self.physics, row @ apart))
        return found

    def coordinates(self, frames: CutFrames, twists: Array) -> list[tuple[Array, Array]]:
        """Of every freedom of its type: rows (k, nv) and values (k,), [m] or [rad], at its own frames; k is 3 for a
        ball (angular velocity and rotation vector of B against A, in world axes), else 1."""
        relative = twists * self.bound.support_b - twists * self.bound.support_a
        end = End(frames.axes_a[0], frames.axes_b[0], frames.at_a[0], frames.at_b[0])
        return [COORDINATES[freedom](end, relative) for freedom in self.cut.type.freedoms]


class End(NamedTuple):
    """Axes as columns (3, 3) and origins (3,) of the two frames of a cut, in the world."""

    a: Array
    b: Array
    at_a: Array
    at_b: Array


Coordinate = tuple[Array, Array]


def _slide(at: End, relative: Array) -> Coordinate:
    z = at.a[:, 2]
    row = z @ relative[:3] + np.cross(at.at_b, z) @ relative[3:]
    return row[None, :], np.array([z @ (at.at_b - at.at_a)])


def _turn(at: End, relative: Array) -> Coordinate:
    return at.a[:, 2:].T @ relative[3:], np.array([np.arctan2(at.a[:, 1] @ at.b[:, 0], at.a[:, 0] @ at.b[:, 0])])


def _turn_of_a(at: End, relative: Array) -> Coordinate:
    return at.a[:, :1].T @ relative[3:], np.array([np.arctan2(at.a[:, 2] @ at.b[:, 1], at.a[:, 1] @ at.b[:, 1])])


def _turn_of_b(at: End, relative: Array) -> Coordinate:
    normal = np.cross(at.a[:, 0], at.b[:, 1])
    return at.b[:, 1:2].T @ relative[3:], np.array([np.arctan2(-normal @ at.b[:, 0], at.a[:, 0] @ at.b[:, 0])])


def _ball(at: End, relative: Array) -> Coordinate:
    return relative[3:], np.asarray(pin.log3(at.b @ at.a.T))


COORDINATES: dict[Freedom, Callable[[End, Array], Coordinate]] = {
    Freedom.SLIDE: _slide,
    Freedom.TURN: _turn,
    Freedom.TURN_OF_A: _turn_of_a,
    Freedom.TURN_OF_B: _turn_of_b,
    Freedom.BALL: _ball,
}
"""Rows and values of every freedom, from the relative twists (6, nv) of the bodies about the origin."""
