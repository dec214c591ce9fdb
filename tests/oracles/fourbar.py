"""Exact dynamics of urdf/fourbar in the crank angle, by influence coefficients; independent of cutjoint and pinocchio.

With a, b, c, g for crank, coupler, rocker and ground, the loop is a e^(i q) + b e^(i f) = g + c e^(i p).  All
velocities are multiples of the crank's, so the kinetic energy is m(q) v^2 / 2 and the motion obeys
m(q) a + m'(q) v^2 / 2 + V'(q) = torque (Eksergian's equation).

With laws in its hinges, x_i their angles and x_i' the derivatives of these by q: rotors add J_i x_i'^2 to m, springs
k_i (x_i - rest_i) x_i' to V', and what is lost asks for the torque sum_i (c_i x_i' v + F_i s(x_i' v / speed_i)) x_i'.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from oracles.physics import Law, smooth_sign
from oracles.tree import Tree

HINGES = {"crank": (1, 0, 0), "coupler": (-1, 1, 0), "rocker": (0, 0, 1), "coupler_to_rocker": (0, -1, 1)}
"""Angle of every hinge, the cut too, in the angles of crank, coupler and rocker."""


@dataclass(frozen=True)
class Place:
    """A point of a body as a complex number in the plane, and its first two derivatives by the crank angle."""

    at: complex
    first: complex
    second: complex


class FourBar:
    """The linkage on the branch of its home posture, with laws (without stops) in some of its hinges."""

    def __init__(self, laws: Mapping[str, Law] | None = None) -> None:
        tree, self.laws = Tree("fourbar"), dict(laws or {})
        self.crank, self.ground = tree.origin("coupler")[0][0], tree.origin("rocker")[0][0]
        self.coupler = tree.cut("coupler_to_rocker", "coupler_link")[0]
        self.rocker = tree.cut("coupler_to_rocker", "rocker_link")[0]
        self.bodies = [tree.body(f"{name}_link") for name in ("crank", "coupler", "rocker")]
        self.tracer = tree.origin("tool_mount")[0]
        self.weight = -tree.gravity[2]
        crank = self.crank * np.exp(1j * tree.home("crank"))
        coupler = np.exp(1j * (tree.home("crank") + tree.home("coupler")))
        self.branch = math.copysign(1.0, (coupler / (self.ground - crank)).imag)

    def angles(self, q: float) -> tuple[float, float]:
        """Angles of coupler and rocker from the x axis."""
        across = self.ground - self.crank * np.exp(1j * q)
        r = abs(across)
        cosine = (r**2 + self.coupler**2 - self.rocker**2) / (2 * self.coupler * r)
        coupler = float(np.angle(across)) + self.branch * math.acos(cosine)
        return coupler, float(np.angle(self.coupler * np.exp(1j * coupler) - across))

    def ratios(self, q: float) -> np.ndarray:
        """First and second derivatives of (crank, coupler, rocker) angle by the crank angle, shape (2, 3)."""
        f, p = self.angles(q)
        a, b, c = self.crank, self.coupler, self.rocker
        top_f, top_p, low = math.sin(q - p), math.sin(q - f), math.sin(p - f)
        df, dp = a / b * top_f / low, a / c * top_p / low
        dlow = math.cos(p - f) * (dp - df)
        ddf = a / b * (math.cos(q - p) * (1 - dp) - top_f * dlow / low) / low
        ddp = a / c * (math.cos(q - f) * (1 - df) - top_p * dlow / low) / low
        return np.array([[1.0, df, dp], [0.0, ddf, ddp]])

    def _point(self, q: float, link: int, at: np.ndarray) -> Place:
        """A point of link 0 crank, 1 coupler, 2 rocker, in the link frame."""
        angles = (q, *self.angles(q))
        first, second = self.ratios(q)
        turned = complex(at[0], at[1]) * np.exp(1j * angles[link])
        place = Place(turned, 1j * first[link] * turned, (1j * second[link] - first[link] ** 2) * turned)
        if link == 0:
            return place
        if link == 2:
            return Place(place.at + self.ground, place.first, place.second)
        tip = self.crank * np.exp(1j * q)
        return Place(place.at + tip, place.first + 1j * tip, place.second - tip)

    def terms(self, q: float, v: float) -> tuple[float, float, float]:
        """Mass m [kg m2], Coriolis m' v^2 / 2 [N m] and gravity V' [N m]."""
        first, second = self.ratios(q)
        mass = slope = gravity = 0.0
        for link, body in enumerate(self.bodies):
            point, turn = self._point(q, link, body.com), body.inertia[2, 2]
            mass += body.mass * abs(point.first) ** 2 + turn * first[link] ** 2
            slope += body.mass * (point.first.conjugate() * point.second).real + turn * first[link] * second[link]
            gravity += body.mass * self.weight * point.first.imag
        return mass, slope * v**2, gravity

    def hinges(self, q: float) -> dict[str, np.ndarray]:
        """Angle of every hinge and its first two derivatives by the crank angle."""
        angles = np.array([(q, *self.angles(q)), *self.ratios(q)])
        return {name: angles @ parts for name, parts in HINGES.items()}

    def physics(self, q: float, v: float) -> tuple[float, float, float, float]:
        """Mass [kg m2] and torques of the rotors, and torques against springs and losses [N m]."""
        mass = slope = springs = losses = 0.0
        hinges = self.hinges(q)
        for name, law in self.laws.items():
            angle, first, second = hinges[name]
            mass += law.armature * first**2
            slope += law.armature * first * second
            springs += law.stiffness * (angle - law.rest) * first
            losses += (law.damping * first * v + law.friction * smooth_sign(first * v, law.speed)) * first
        return mass, slope * v**2, springs, losses

    def inverse_dynamics(self, q: float, v: float, a: float) -> float:
        """Torque of the crank's motor [N m]."""
        (mass, coriolis, gravity), (rotors, turning, springs, losses) = self.terms(q, v), self.physics(q, v)
        return (mass + rotors) * a + coriolis + turning + gravity + springs + losses

    def forward_dynamics(self, q: float, v: float, torque: float) -> float:
        """Acceleration of the crank [rad/s2]."""
        (mass, *_), (rotors, *_) = self.terms(q, v), self.physics(q, v)
        return (torque - self.inverse_dynamics(q, v, 0.0)) / (mass + rotors)

    def potential_energy(self, q: float) -> float:
        """Energy of gravity and springs [J]."""
        hinges, laws = self.hinges(q), self.laws
        sprung = sum(0.5 * law.stiffness * (hinges[name][0] - law.rest) ** 2 for name, law in laws.items())
        points = [self._point(q, link, body.com) for link, body in enumerate(self.bodies)]
        falls = (body.mass * self.weight * point.at.imag for body, point in zip(self.bodies, points, strict=True))
        return sum(falls) + sprung

    def tool(self, q: float) -> np.ndarray:
        """Tracing point, shape (3,) [m]."""
        point = self._point(q, 1, self.tracer)
        return np.array([point.at.real, 0.0, point.at.imag])

    def joints(self, q: float, v: float, a: float) -> dict[str, tuple[float, float, float]]:
        """Coordinate, velocity and acceleration of every joint of the tree."""
        f, p = self.angles(q)
        first, second = self.ratios(q)
        rate, change = first * v, first * a + second * v**2
        return {
            "crank": (q, v, a),
            "coupler": (f - q, rate[1] - v, change[1] - a),
            "rocker": (p, rate[2], change[2]),
        }
