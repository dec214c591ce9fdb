"""What joints and cuts do by themselves, as wrenches on free bodies: the oracle's own reading of joint physics.

A law acts along the rows that measure a joint's velocities (`oracles.connections`), or those of the free motion of a
cut: revolute, the angle from x of a to x of b about z of a; prismatic, the way of b along z of a; universal, R_a' R_b =
Rx(first) Ry(second); spherical, the rotation vector of R_a' R_b.

    force on a velocity u:   - damping u - friction s(u / speed) - stiffness (q - rest) - stop
    rotor:                   kinetic energy gear^2 rotor u^2 / 2

A ball's spring pulls back about the axis it has turned about, its friction is against the axis it turns about.  With a
speed of 0, friction is its sign, and 0 at rest.  The bushing of a cut has an energy of k r^2 / 2 for each of its
equations r, as they are while it is open (hinges: the angle between the axes), and damps what r is the gradient of.
A cut with a bushing has no other law.

    oracle = Maximal(path, laws={"crank": Law(damping=0.1)}, bushings={"pin": Bush(1e5)})

`laws_of(description)` reads both from anything with the attributes of a description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from oracles.connections import NONE, Pose, Rows, _rows, skew
from oracles.reading import Array, Cut


@dataclass(frozen=True)
class Law:
    """Joint physics in plain numbers; `armature` is gear^2 rotor, `rest` of every coordinate alike."""

    damping: float = 0.0
    friction: float = 0.0
    speed: float = 0.01
    stiffness: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    stop_stiffness: float = 0.0
    stop_damping: float = 0.0
    lower: float = -np.inf
    upper: float = np.inf

    def spring(self, q: Array, ball: bool) -> tuple[Array, float]:
        """Force on coordinates, and the energy; a ball is at rest unturned."""
        away = q if ball else q - self.rest
        return -self.stiffness * away, 0.5 * self.stiffness * float(away @ away)

    def stop(self, q: Array, u: Array) -> tuple[Array, float]:
        """Force of the stops on coordinates, and their energy."""
        force, energy = np.zeros(len(u)), 0.0
        if self.stop_stiffness <= 0.0 or not np.isfinite([self.lower, self.upper]).any():
            return force, energy
        for i, (at, speed) in enumerate(zip(q, u, strict=True)):
            for beyond, outwards in ((at - self.upper, 1.0), (self.lower - at, -1.0)):
                if beyond > 0.0:
                    push = self.stop_stiffness * beyond + self.stop_damping * outwards * speed
                    force[i] -= outwards * max(push, 0.0)
                    energy += 0.5 * self.stop_stiffness * beyond**2
        return force, energy

    def losses(self, u: Array, ball: bool) -> Array:
        """Force of damping and friction on velocities."""
        if not ball:
            return -self.damping * u - self.friction * np.array([smooth_sign(one, self.speed) for one in u])
        size = float(np.linalg.norm(u))
        along = u / size if size else np.zeros(len(u))
        return -self.damping * u - self.friction * smooth_sign(size, self.speed) * along


@dataclass(frozen=True)
class Bush:
    """A bushing: stiffness and damping of the equations that are lengths, then of the others."""

    stiffness: float
    damping: float = 0.0
    turning_stiffness: float = 0.0
    turning_damping: float = 0.0


def smooth_sign(u: float, speed: float) -> float:
    """sign(u) from `speed` on, below it the quintic in u / speed that meets it with slope and curvature 0."""
    if speed == 0.0 or abs(u) >= speed:
        return float(np.sign(u))
    x = u / speed
    return 1.875 * x - 1.25 * x**3 + 0.375 * x**5


def laws_of(description: Any) -> tuple[dict[str, Law], dict[str, Bush]]:
    """Laws and bushings of whatever has joints and cuts with `physics`, `limits` and `bushing`."""
    laws, bushings = {}, {}
    for one in (*description.joints, *description.cuts):
        if (b := getattr(one, "bushing", None)) is not None:
            bushings[one.name] = Bush(b.stiffness, b.damping, b.turning_stiffness, b.turning_damping)
            continue
        p, limits = one.physics, getattr(one, "limits", None)
        ends = [getattr(limits, end, None) for end in ("lower", "upper")]
        laws[one.name] = Law(
            p.damping, p.friction, 0.01 if p.friction_speed is None else p.friction_speed, p.stiffness, p.rest or 0.0,
            p.gear**2 * p.rotor, p.stop_stiffness, p.stop_damping,
            -np.inf if ends[0] is None else ends[0], np.inf if ends[1] is None else ends[1],
        )  # fmt: skip
    return laws, bushings


def rotation_vector(rotation: Array) -> Array:
    """Axis times angle (3,), the angle below pi."""
    twice = np.array(
        [rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]]
    )
    sine, cosine = 0.5 * float(np.linalg.norm(twice)), 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = float(np.arctan2(sine, cosine))
    return 0.5 * twice if sine < 1e-9 and cosine > 0.0 else twice * (0.5 * angle / sine)


def joint_coordinates(kind: str, value: Any) -> Array:
    """Coordinates that springs and stops of a joint of the tree act on; those of a ball along the child's axes."""
    if kind == "spherical":
        return rotation_vector(np.asarray(value))
    if kind in ("fixed", "planar", "floating"):
        return np.zeros({"fixed": 0, "planar": 3, "floating": 6}[kind])
    return np.atleast_1d(np.asarray(value, dtype=float))


def cut_motion(cut: Cut, a: Pose, b: Pose) -> tuple[Array, Rows]:
    """Coordinates of the free motion of a cut, and the rows that measure their rates where it is closed."""
    names, x, relative = (cut.a.link, cut.b.link), b.position, a.rotation.T @ b.rotation
    match cut.kind:
        case "revolute":
            angle = float(np.arctan2(relative[1, 0], relative[0, 0]))
            return np.array([angle]), _rows(*names, x, NONE, a.rotation[:, 2:].T, "a")
        case "prismatic":
            along = a.rotation[:, 2]
            return np.array([along @ (x - a.position)]), _rows(*names, x, along[None], NONE, "a")
        case "universal":
            angles = [np.arctan2(relative[2, 1], relative[1, 1]), np.arctan2(relative[0, 2], relative[0, 0])]
            matrix = np.zeros((2, 6))
            matrix[:, 3:] = a.rotation[:, 0], b.rotation[:, 1]
            return np.array(angles), Rows(*names, x, matrix, ("a", "b"))
        case "spherical":
            return rotation_vector(relative), _rows(*names, x, NONE, b.rotation.T, "b")
    return np.zeros(0), _rows(*names, x, NONE, NONE, "a")


def bushing_rows(cut: Cut, a: Pose, b: Pose) -> tuple[Array, Array, Array]:
    """Equations of a cut while it is open: values (k,), their rates as rows (k, 12) on the twists of a and of b at the
    origins of frames a and b, and which are lengths (k,)."""
    apart, axes, kind = b.position - a.position, a.rotation.T, cut.kind
    values, rows, lengths = [], [], []

    def add(value: float, *parts: Array, length: bool) -> None:
        values.append(value)
        rows.append(np.concatenate(parts))
        lengths.append(length)

    def turning(value: float, normal: Array) -> None:
        add(value, np.zeros(3), -normal, np.zeros(3), normal, length=False)

    if kind == "prismatic":
        for axis in axes[:2]:
            add(float(axis @ apart), -axis, -np.cross(apart, axis), axis, np.zeros(3), length=True)
    else:
        for k, axis in enumerate(np.eye(3)):
            add(apart[k], -axis, np.zeros(3), axis, np.zeros(3), length=True)
    if kind in ("fixed", "prismatic"):
        for value, axis in zip(rotation_vector(b.rotation @ a.rotation.T), np.eye(3), strict=True):
            turning(value, axis)
    if kind == "revolute":  # the turn that brings z of a to z of b, about y of a and against x of a
        normal = np.cross(a.rotation[:, 2], b.rotation[:, 2])
        sine, cosine = float(np.linalg.norm(normal)), float(a.rotation[:, 2] @ b.rotation[:, 2])
        tilt = normal * (float(np.arctan2(sine, cosine)) / sine if sine > 1e-12 else 1.0)
        for axis in (a.rotation[:, 1], -a.rotation[:, 0]):
            turning(float(axis @ tilt), axis)
    elif kind == "universal":
        first, second = a.rotation[:, 0], b.rotation[:, 1]
        turning(float(first @ second), np.cross(second, first))
    return np.array(values), np.array(rows), np.array(lengths)


@dataclass(frozen=True)
class Cushion:
    """A bushing at a configuration.

    Attributes:
        values: its equations, shape (k,).
        rows: their rates on the twists of all bodies, shape (k, 6 bodies).
        own: on those of b at the origin of frame b, shape (k, 6).
        stiffness, damping: of each, shape (k,).
        point: origin of frame b.
    """

    values: Array
    rows: Array
    own: Array
    stiffness: Array
    damping: Array
    point: Array

    @staticmethod
    def of(bush: Bush, cut: Cut, a: Pose, b: Pose, poses: Mapping[str, Pose], columns: Mapping[str, int]) -> Cushion:
        values, rows, lengths = bushing_rows(cut, a, b)
        spread = np.zeros((len(values), 6 * len(columns)))
        for link, frame, own in ((cut.a.link, a, rows[:, :6]), (cut.b.link, b, rows[:, 6:])):
            if link in columns:
                shift = np.eye(6)
                shift[:3, 3:] = -skew(frame.position - poses[link].position)
                spread[:, columns[link] : columns[link] + 6] += own @ shift
        stiffness = np.where(lengths, bush.stiffness, bush.turning_stiffness)
        damping = np.where(lengths, bush.damping, bush.turning_damping)
        return Cushion(values, spread, rows[:, 6:], stiffness, damping, b.position)

    @property
    def energy(self) -> float:
        return 0.5 * float(self.stiffness @ self.values**2)

    def forces(self, twists: Array) -> Array:
        """On its equations, shape (k,)."""
        return -self.stiffness * self.values - self.damping * (self.rows @ twists)


@dataclass(frozen=True)
class Acting:
    """A law at a configuration: coordinates of a joint or of a cut's free motion, and the rows of its velocities."""

    law: Law
    values: Array
    rows: Rows
    ball: bool

    @property
    def energy(self) -> float:
        """Of springs and stops [J]."""
        return self.law.spring(self.values, self.ball)[1] + self.law.stop(self.values, np.zeros(len(self.values)))[1]

    def forces(self, u: Array) -> tuple[Array, Array]:
        """What stores energy (springs, stops without their damping) and what wastes it, on velocities u, shape (k,)."""
        still = self.law.stop(self.values, np.zeros(len(u)))[0]
        wasted = self.law.losses(u, self.ball) + self.law.stop(self.values, u)[0] - still
        return self.law.spring(self.values, self.ball)[0] + still, wasted
