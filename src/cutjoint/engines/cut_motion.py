"""Dampers, friction and springs of cuts, from where MuJoCo has the frames of the cut: it has no joint there itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import ModuleType
from typing import TYPE_CHECKING

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.cuts import Freedom
from cutjoint.description.model import CutJoint
from cutjoint.errors import InputError

if TYPE_CHECKING:
    import mujoco


@dataclass(frozen=True, eq=False)
class CutMotion:
    """The motion that a rigid cut leaves free, in MuJoCo.

    Raises:
        InputError: it is no turn about an axis and no ball.
    """

    engine: ModuleType
    model: mujoco.MjModel
    cut: CutJoint

    def __post_init__(self) -> None:
        if self.cut.bushing is not None or self.cut.type.freedoms not in _COORDINATES:
            what = "a bushing" if self.cut.bushing is not None else "dampers, friction or a spring"
            raise InputError(f"cut '{self.cut.name}' has {what}, which is not mapped to MuJoCo")

    def _moved(self, data: mujoco.MjData) -> tuple[Array, Array, Array]:
        """Axes of both frames (3, 3) in the world, and rows (3, nv) of the angular velocity of b against a."""
        sides = []
        for frame in (self.cut.a, self.cut.b):
            body = self.engine.mj_name2id(self.model, self.engine.mjtObj.mjOBJ_BODY, frame.link)
            rows = np.zeros((3, self.model.nv))
            self.engine.mj_jacBody(self.model, data, None, rows, body)
            sides.append((data.xmat[body].reshape(3, 3) @ frame.placement[:3, :3], rows))
        (a, rows_a), (b, rows_b) = sides
        return a, b, rows_b - rows_a

    def effort(self, data: mujoco.MjData) -> Array:
        """What it takes against it at the state whose positions are computed in `data`, shape (nv,)."""
        a, b, turning = self._moved(data)
        rows, value = _COORDINATES[self.cut.type.freedoms](a, b, turning)
        physics, rate = self.cut.physics, rows @ data.qvel
        speed = float(np.linalg.norm(rate))
        against = physics.damping * rate + physics.stiffness * (value - (physics.rest or 0.0))
        if speed > 0.0:
            rubbed = physics.friction * smooth_sign(np.array([speed]), np.array([physics.speed]))[0]
            against = against + rubbed / speed * rate
        return np.asarray(rows.T @ against)

    def energy(self, data: mujoco.MjData) -> float:
        """In its spring."""
        _, value = _COORDINATES[self.cut.type.freedoms](*self._moved(data))
        return 0.5 * self.cut.physics.stiffness * float(np.sum((value - (self.cut.physics.rest or 0.0)) ** 2))


def smooth_sign(speed: Array, full: Array) -> Array:
    """The sign of a speed from `full` on; below it 15/8 of the integral of (1 - x^2)^2 from 0 to speed / full."""
    steps = np.divide(speed, full, out=np.sign(speed), where=full > 0.0).clip(-1.0, 1.0)
    return np.asarray(np.polynomial.Polynomial([1.0, 0.0, -2.0, 0.0, 1.0]).integ()(steps) * 15.0 / 8.0)


def _turn(a: Array, b: Array, turning: Array) -> tuple[Array, Array]:
    """About z of A: the angle from x to x."""
    relative = a.T @ b
    return a[:, 2:].T @ turning, np.array(
        [np.arctan2(relative[1, 0] - relative[0, 1], relative[0, 0] + relative[1, 1])]
    )


def _ball(a: Array, b: Array, turning: Array) -> tuple[Array, Array]:
    """The rotation vector, in the axes of A: along the eigenvector of the turn that stays."""
    relative = a.T @ b
    skew = relative - relative.T
    twice = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    sine, cosine = 0.5 * float(np.linalg.norm(twice)), 0.5 * (float(np.trace(relative)) - 1.0)
    angle = float(np.arctan2(sine, cosine))
    return a.T @ turning, 0.5 * twice * (angle / sine if sine > 1e-9 else 1.0)


_COORDINATES: Mapping[tuple[Freedom, ...], Callable[[Array, Array, Array], tuple[Array, Array]]] = {
    (Freedom.TURN,): _turn,
    (Freedom.BALL,): _ball,
}
"""Freedoms of a cut -> rows (k, nv) and values (k,) of its coordinates."""
