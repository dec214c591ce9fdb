"""Exact dynamics of urdf/fivebar in its two motor angles, in closed form; independent of cutjoint and pinocchio.

With l, r for the motor angles and f, h for the angles of the distal links, the loop is
A + p1 e^(i l) + d1 e^(i f) = B + p2 e^(i r) + d2 e^(i h).  Its first two derivatives give the distal links' velocities
and accelerations; M = sum J' diag(m, m, I) J over the bodies, C v the same with the bodies' accelerations at rest of
the motors' accelerations.
"""

from __future__ import annotations

import math

import numpy as np
from oracles.tree import Tree


class FiveBar:
    """The linkage on the branch of its home posture."""

    def __init__(self) -> None:
        tree = Tree("fivebar")
        sides = ("left", "right")
        self.motors = [complex(tree.origin(f"{side}_shoulder")[0][0], 0.0) for side in sides]
        self.proximal = [tree.origin(f"{side}_elbow")[0][0] for side in sides]
        self.distal = [tree.cut("tip", f"{side}_distal")[0] for side in sides]
        links = ("left_proximal", "right_proximal", "left_distal", "right_distal")
        self.bodies = [(k, tree.body(name)) for k, name in enumerate(links)]
        self.mount = tree.origin("tool_mount")[0]
        tool = tree.body("tool")
        self.tool_body = (tool.mass, tool.com + self.mount, tool.inertia[2, 2])
        self.weight = -tree.gravity[2]
        left, right = tree.home("left_shoulder"), tree.home("right_shoulder")
        distal = np.exp(1j * (left + tree.home("left_elbow")))
        self.branch = math.copysign(1.0, (distal / self._across(left, right)).imag)

    def _across(self, left: float, right: float) -> complex:
        """From the left elbow to the right one."""
        elbows = [a + p * np.exp(1j * q) for a, p, q in zip(self.motors, self.proximal, (left, right), strict=True)]
        return elbows[1] - elbows[0]

    def angles(self, q: np.ndarray) -> np.ndarray:
        """Angles from the x axis of left and right proximal, left and right distal link, shape (4,)."""
        across = self._across(*q)
        r, (d1, d2) = abs(across), self.distal
        left = float(np.angle(across)) + self.branch * math.acos((r**2 + d1**2 - d2**2) / (2 * d1 * r))
        return np.array([*q, left, float(np.angle(d1 * np.exp(1j * left) - across))])

    def ratios(self, q: np.ndarray) -> np.ndarray:
        """Derivatives of the four angles by the two motor angles, shape (4, 2)."""
        l, r, f, h = self.angles(q)  # noqa: E741
        (p1, p2), (d1, d2), s = self.proximal, self.distal, math.sin
        low = s(f - h)
        left = np.array([-p1 * s(l - h), p2 * s(r - h)]) / (d1 * low)
        right = np.array([-p1 * s(l - f), p2 * s(r - f)]) / (d2 * low)
        return np.vstack([np.eye(2), left, right])

    def drift(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Accelerations of the four angles while the motors turn evenly, shape (4,)."""
        l, r, f, h = self.angles(q)  # noqa: E741
        vl, vr, vf, vh = self.ratios(q) @ v
        (p1, p2), (d1, d2), c = self.proximal, self.distal, math.cos
        low = math.sin(f - h)
        left = p2 * vr**2 * c(r - h) + d2 * vh**2 - p1 * vl**2 * c(l - h) - d1 * vf**2 * c(f - h)
        right = p2 * vr**2 * c(r - f) + d2 * vh**2 * c(h - f) - p1 * vl**2 * c(l - f) - d1 * vf**2
        return np.array([0.0, 0.0, left / (d1 * low), right / (d2 * low)])

    def _point(self, q: np.ndarray, v: np.ndarray, link: int, at: np.ndarray) -> tuple[complex, np.ndarray, complex]:
        """Position, derivative (2,) by the motor angles and drift of a point of a link, as complex numbers."""
        angles, ratios, drift = self.angles(q), self.ratios(q), self.drift(q, v)
        side = link % 2
        position = self.motors[side]
        slope, even = np.zeros(2, dtype=complex), 0j
        arms = [(link, complex(at[0], at[1]))] if link < 2 else [(side, self.proximal[side]), (link, complex(*at[:2]))]
        for k, arm in arms:
            turned = arm * np.exp(1j * angles[k])
            rate = ratios[k] @ v
            position += turned
            slope += 1j * turned * ratios[k]
            even += (1j * drift[k] - rate**2) * turned
        return position, slope, even

    def terms(self, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Mass matrix (2, 2), Coriolis vector (2,) and gravity (2,)."""
        ratios, drift = self.ratios(q), self.drift(q, v)
        mass, coriolis, gravity = np.zeros((2, 2)), np.zeros(2), np.zeros(2)
        bodies = [(k, body.mass, body.com, body.inertia[2, 2]) for k, body in self.bodies]
        for k, m, com, turn in [*bodies, (2, *self.tool_body)]:
            _, slope, even = self._point(q, v, k, com)
            mass += m * np.outer(slope, slope.conjugate()).real + turn * np.outer(ratios[k], ratios[k])
            coriolis += m * (slope.conjugate() * even).real + turn * ratios[k] * drift[k]
            gravity += m * self.weight * slope.imag
        return mass, coriolis, gravity

    def inverse_dynamics(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Torques of the two motors [N m], shape (2,)."""
        mass, coriolis, gravity = self.terms(q, v)
        return mass @ a + coriolis + gravity

    def forward_dynamics(self, q: np.ndarray, v: np.ndarray, torque: np.ndarray) -> np.ndarray:
        """Accelerations of the two motors [rad/s2], shape (2,)."""
        mass, coriolis, gravity = self.terms(q, v)
        return np.linalg.solve(mass, torque - coriolis - gravity)

    def potential_energy(self, q: np.ndarray) -> float:
        """Energy of gravity [J]."""
        bodies = [(k, body.mass, body.com) for k, body in self.bodies] + [(2, *self.tool_body[:2])]
        return sum(m * self.weight * self._point(q, np.zeros(2), k, com)[0].imag for k, m, com in bodies)

    def tool(self, q: np.ndarray) -> np.ndarray:
        """Tool point, shape (3,) [m]."""
        point = self._point(q, np.zeros(2), 2, self.mount)[0]
        return np.array([point.real, 0.0, point.imag])

    def joints(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> dict[str, tuple[float, float, float]]:
        """Coordinate, velocity and acceleration of every joint of the tree."""
        angles, ratios = self.angles(q), self.ratios(q)
        rates, changes = ratios @ v, ratios @ a + self.drift(q, v)
        found = {}
        for k, side in enumerate(("left", "right")):
            found[f"{side}_shoulder"] = (angles[k], rates[k], changes[k])
            found[f"{side}_elbow"] = (
                angles[k + 2] - angles[k],
                rates[k + 2] - rates[k],
                changes[k + 2] - changes[k],
            )
        return found
