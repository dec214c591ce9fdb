"""Placements in a USD stage: turns, scales, and units of length."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.formats.usd.facts import Prim
from cutjoint.description.transforms import from_rotation, rotation_from_quaternion

ROUNDING = 1e-5
"""Orientations are often in single precision: so much may a matrix of turns and scales be askew, and a scale off 1."""


@dataclass(frozen=True, eq=False)
class Stand:
    """Where a prim stands: a rigid placement (4, 4) in the world in metres, and its scale (3,) along its own axes."""

    world: Array
    scale: Array

    @property
    def uniform(self) -> bool:
        """Whether it is scaled alike along all axes."""
        return float(np.ptp(self.scale)) <= ROUNDING * float(self.scale.max())


def stand(prim: Prim, length: float) -> Stand | None:
    """Where a prim stands, in a stage with `length` metres a unit; None where it is placed askew or nowhere."""
    if prim.world is None:
        return None
    matrix = np.array(prim.world, dtype=float)
    axes = matrix[:3, :3]
    scale = np.linalg.norm(axes, axis=0)
    if not np.isfinite(matrix).all() or scale.min() <= 1e-12:
        return None
    turn = axes / scale
    if np.abs(turn.T @ turn - np.eye(3)).max() > ROUNDING:
        return None
    if np.linalg.det(turn) < 0.0:
        turn, scale = turn * [1.0, 1.0, -1.0], scale * [1.0, 1.0, -1.0]
    scale = np.where(np.abs(scale - 1.0) <= ROUNDING, 1.0, scale)
    return Stand(from_rotation(_rotation(turn), length * matrix[:3, 3]), scale)


def _rotation(turn: Array) -> Array:
    """The rotation (3, 3) nearest to a matrix; the matrix itself where it is one to rounding."""
    if np.abs(turn.T @ turn - np.eye(3)).max() < 4e-16:
        return turn
    left, _, right = np.linalg.svd(turn)
    nearest: Array = left @ right
    return nearest


def local(position: tuple[float, ...], quaternion: tuple[float, ...], scale: Array, length: float) -> Array:
    """A placement (4, 4) in metres of a position in a scaled frame and a quaternion (w, x, y, z)."""
    return from_rotation(rotation_from_quaternion(quaternion), length * np.array(position) * scale)
