"""Inverse kinematics of led robots in closed form: from the pose of the tool to the actuators.

Neither Pinocchio nor cutjoint is in here.  Each robot stands in the axes of its base; its tool is at `centre` at home,
and unturned.  `pose` says where the tool is after the freedoms of the robot have moved by `x` from home, parasitic
motions included; `joints` gives the actuated coordinates for a position (3,) [m] and a rotation (3, 3) of the tool.

A crank of radius r about u x v that a rod of length l ties to a point d stands at the angle t with

    |d - r (cos t u + sin t v)| = l,    so    (d . u) cos t + (d . v) sin t = (d . d + r^2 - l^2) / (2 r)

which has two solutions, the two elbows.  Spherical limbs and the parasitic turn of a tripod lead to the same equation.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, cos, hypot, sin, sqrt
from typing import Protocol

import numpy as np
from oracles.connections import turn

Array = np.ndarray
X, Y, Z = np.eye(3)


class OutOfReachError(Exception):
    """No angle of a crank leads there."""


class ClosedForm(Protocol):
    """What every robot here offers.

    Attributes:
        freedoms: which of x y z rx ry rz `x` holds; for the pan-tilt head its two angles.
    """

    centre: Array
    freedoms: tuple[str, ...]

    def pose(self, x: Array) -> tuple[Array, Array]:
        """Position (3,) [m] and rotation (3, 3) of the tool."""

    def joints(self, position: Array, rotation: Array) -> Array:
        """Actuated coordinates, [m] or [rad]."""


def angle_with(a: float, b: float, c: float, branch: float) -> float:
    """The angle t with a cos t + b sin t = c: the one ahead of (a, b) for branch 1, the one behind for -1."""
    rest = a * a + b * b - c * c
    if rest < 0.0:
        raise OutOfReachError(f"{c} > {hypot(a, b)}")
    return atan2(b, a) + branch * atan2(sqrt(rest), c)


def crank(d: Array, u: Array, v: Array, radius: float, rod: float, branch: float) -> float:
    """Angle of a crank, see the head of the module."""
    return angle_with(d @ u, d @ v, (d @ d + radius**2 - rod**2) / (2.0 * radius), branch)


def rotation_of(vector: Array) -> Array:
    """Rotation (3, 3) of a rotation vector (3,) [rad]."""
    angle = float(np.linalg.norm(vector))
    return turn(vector / angle, angle) if angle > 0.0 else np.eye(3)


@dataclass(frozen=True)
class Free:
    """A tool whose freedoms are some of x y z rx ry rz, without parasitic motion."""

    centre: Array
    freedoms: tuple[str, ...]

    def pose(self, x: Array) -> tuple[Array, Array]:
        moved = dict(zip(self.freedoms, x, strict=True))
        values = np.array([moved.get(name, 0.0) for name in ("x", "y", "z", "rx", "ry", "rz")])
        return self.centre + values[:3], rotation_of(values[3:])


@dataclass(frozen=True)
class Legs(Free):
    """Legs between points of the base and of the platform (6, 3) each, as lengths: the Stewart platform."""

    feet: Array
    tops: Array

    def joints(self, position: Array, rotation: Array) -> Array:
        return np.linalg.norm(position + self.tops @ rotation.T - self.feet, axis=1)


@dataclass(frozen=True)
class Cranks(Free):
    """Limbs of a crank and a rod each, between points of the base and of the platform: planar 3-RRR, Delta, 4-RUU.

    Attributes:
        feet: axes of the cranks, shape (n, 3).
        tops: ends of the rods on the platform, from the tool, shape (n, 3).
        u, v: directions of the cranks at angles 0 and a quarter turn, shape (n, 3).
        radii, rods: lengths, shape (n,).
        elbows: branches, 1 or -1, shape (n,).
    """

    feet: Array
    tops: Array
    u: Array
    v: Array
    radii: Array
    rods: Array
    elbows: Array

    def joints(self, position: Array, rotation: Array) -> Array:
        spans = position + self.tops @ rotation.T - self.feet
        return np.array(list(map(crank, spans, self.u, self.v, self.radii, self.rods, self.elbows)))

    def bends(self, position: Array, rotation: Array) -> Array:
        """Where the elbows are, shape (n, 3)."""
        angles = self.joints(position, rotation)[:, None]
        return self.feet + self.radii[:, None] * (np.cos(angles) * self.u + np.sin(angles) * self.v)


@dataclass(frozen=True)
class FiveBar(Cranks):
    """Two cranks whose rods meet in the tool, which the first rod carries."""

    def pose(self, x: Array) -> tuple[Array, Array]:
        still = np.eye(3)
        position = self.centre + np.array([x[0], x[1], 0.0])
        before, now = (at - self.bends(at, still)[0] for at in (self.centre, position))
        return position, turn(Z, atan2(now[1], now[0]) - atan2(before[1], before[0]))


@dataclass(frozen=True)
class SphericalLimbs(Free):
    """Three limbs of three hinges that all meet in the tool point: the spherical 3-RRR.

    Attributes:
        first, last: axes in base and platform at home, shape (3, 3), a row each.
        u, v: middle axes at angles 0 and a quarter turn are cos(b) first + sin(b) u, the same with v, shape (3, 3).
        cranks, rods: angles b between first and middle, and between middle and last axes [rad], shape (3,).
        elbows: branches, shape (3,).
    """

    first: Array
    last: Array
    u: Array
    v: Array
    cranks: Array
    rods: Array
    elbows: Array

    def joints(self, position: Array, rotation: Array) -> Array:
        found = []
        for k, last in enumerate(self.last @ rotation.T):
            c, s = cos(self.cranks[k]), sin(self.cranks[k])
            rest = cos(self.rods[k]) - c * (self.first[k] @ last)
            found.append(angle_with(s * (self.u[k] @ last), s * (self.v[k] @ last), rest, self.elbows[k]))
        return np.array(found)

    def middles(self) -> Array:
        """Middle axes at home, shape (3, 3)."""
        angles = self.joints(self.centre, np.eye(3))[:, None]
        around = np.cos(angles) * self.u + np.sin(angles) * self.v
        return np.cos(self.cranks)[:, None] * self.first + np.sin(self.cranks)[:, None] * around


@dataclass(frozen=True)
class SerialWrist(Free):
    """Three hinges one after another whose axes meet in the tool point, square to each other at zero (z, y, x).

    Attributes:
        axes: their axes at zero as columns, x, y, z, shape (3, 3).
        start: their angles at home, shape (3,).
    """

    axes: Array
    start: Array

    def turned(self, angles: Array) -> Array:
        """Rotation (3, 3) at these angles from zero."""
        return self.axes @ turn(Z, angles[0]) @ turn(Y, angles[1]) @ turn(X, angles[2]) @ self.axes.T

    def joints(self, position: Array, rotation: Array) -> Array:
        r = self.axes.T @ rotation @ self.turned(self.start) @ self.axes
        return np.array([atan2(r[1, 0], r[0, 0]), atan2(-r[2, 0], hypot(r[0, 0], r[1, 0])), atan2(r[2, 1], r[2, 2])])


@dataclass(frozen=True)
class PanTilt(Free):
    """A head on two crossing hinges: pan about z, tilt about -y; the tool at the end of an arm along x.

    Attributes:
        arm: its length [m].
        start: pan and tilt at home, shape (2,).
    """

    arm: float
    start: Array

    def at(self, angles: Array) -> tuple[Array, Array]:
        """The tool from the crossing of the hinges (3,), and how it is turned from zero (3, 3)."""
        rotation = turn(Z, angles[0]) @ turn(-Y, angles[1])
        return self.arm * rotation[:, 0], rotation

    def pose(self, x: Array) -> tuple[Array, Array]:
        (before, home), (point, now) = self.at(self.start), self.at(self.start + x)
        return self.centre + point - before, now @ home.T

    def joints(self, position: Array, rotation: Array) -> Array:
        x, y, z = position - self.centre + self.at(self.start)[0]
        return np.array([atan2(y, x), atan2(z, hypot(x, y))])


@dataclass(frozen=True)
class Tripod(Free):
    """3-RPS: three legs from tangential hinges to balls, each in a plane through the middle of the base.

    With t_k the hinges' axes, the balls stay in the legs' planes: t_k . (p + R b_k - a_k) = 0.  Weights n_k with
    n_1 t_1 + n_2 t_2 + n_3 t_3 = 0 take x and y of p out; what is left is an equation for the turn of the plate about
    its own normal.  (The symmetric tripod, Hunt 1983, turns by none: tilt and torsion, Bonev 2002.)

    Attributes:
        feet, tops: a_k and b_k, from the tool, shape (3, 3).
        hinges: t_k, horizontal, shape (3, 3).
    """

    feet: Array
    tops: Array
    hinges: Array

    def joints(self, position: Array, rotation: Array) -> Array:
        return np.linalg.norm(position + self.tops @ rotation.T - self.feet, axis=1)

    def pose(self, x: Array) -> tuple[Array, Array]:
        height, tilt = self.centre[2] + x[0], rotation_of(np.array([x[1], x[2], 0.0]))
        weights = np.linalg.svd(self.hinges[:, :2].T)[2][2]
        a = b = c = 0.0
        for n, t, foot, top in zip(weights, self.hinges, self.feet, self.tops, strict=True):
            along, across = tilt @ (top * (1, 1, 0)), tilt @ np.array([-top[1], top[0], 0.0])
            a, b, c = a + n * (t @ along), b + n * (t @ across), c - n * (t @ (tilt @ (top * Z) - foot))
        turns = (angle_with(a, b, c, branch) for branch in (1.0, -1.0))
        own = min((atan2(sin(one), cos(one)) for one in turns), key=abs)
        rotation = tilt @ turn(Z, own)
        away = np.sum(self.hinges * (self.feet - self.tops @ rotation.T), axis=1)
        place = np.linalg.lstsq(self.hinges[:, :2], away, rcond=None)[0]
        return np.array([*place, height]), rotation
