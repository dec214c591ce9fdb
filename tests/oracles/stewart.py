"""Inverse dynamics of urdf/stewart by Newton and Euler, leg by leg; independent of cutjoint and pinocchio.

Given the platform's motion, each leg's follows: with e1 the base hinge, s the leg's direction and e2 along s x e1 the
second hinge, the leg turns with alpha' e1 + beta' e2.  Moments of the leg about e2 and of leg and cross about e1
give the two components of the ball's force across the leg.  The platform's six balances give the six components along
the legs, and each piston's balance along its leg the motor's force.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from oracles.tree import Body, Tree


@dataclass(frozen=True)
class Motion:
    """The platform in world axes: position, rotation (3, 3), velocity, angular velocity and their derivatives."""

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray
    acceleration: np.ndarray
    spin_rate: np.ndarray

    def point(self, at: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Position, velocity and acceleration of the platform's point `at`."""
        r = self.rotation @ at
        velocity = self.velocity + np.cross(self.spin, r)
        turning = np.cross(self.spin_rate, r) + np.cross(self.spin, np.cross(self.spin, r))
        return self.position + r, velocity, self.acceleration + turning


@dataclass(frozen=True)
class Leg:
    """A leg's hinge axes and coordinates; swing, tilt and slide are (coordinate, velocity, acceleration)."""

    e1: np.ndarray
    e2: np.ndarray
    direction: np.ndarray
    swing: tuple[float, float, float]
    tilt: tuple[float, float, float]
    slide: tuple[float, float, float]

    @property
    def across(self) -> np.ndarray:
        """Third axis of the leg's frame (across, e2, direction)."""
        return np.cross(self.e2, self.direction)


class Stewart:
    """The platform with the masses of its URDF."""

    def __init__(self) -> None:
        tree = Tree("stewart")
        self.gravity = tree.gravity
        self.platform = tree.body("platform_link")
        self.balls = [tree.cut(f"ball{i}", "platform_link") for i in range(1, 7)]
        origins = [tree.origin(f"leg{i}_swing") for i in range(1, 7)]
        self.feet = [xyz for xyz, _ in origins]
        self.radial = [np.array([np.cos(rpy[2]), np.sin(rpy[2]), 0.0]) for _, rpy in origins]
        self.parts = [[tree.body(f"leg{i}_{part}") for part in ("cross", "cylinder", "piston")] for i in range(1, 7)]

    def leg(self, i: int, motion: Motion) -> Leg:
        """Motion of leg `i` (0 to 5)."""
        at, velocity, acceleration = motion.point(self.balls[i])
        e1 = self.radial[i]
        span = at - self.feet[i]
        length = float(np.linalg.norm(span))
        s = span / length
        n = float(np.linalg.norm(np.cross(s, e1)))
        e2 = np.cross(s, e1) / n
        across = np.cross(e2, s)
        # the ball's velocity: length' s + alpha' length e1 x s + beta' length e2 x s, with e1 x s = -n e2
        slide, swing, tilt = s @ velocity, -(e2 @ velocity) / (n * length), (across @ velocity) / length
        spin = swing * e1 + tilt * e2
        known = 2.0 * slide * np.cross(spin, s) + np.cross(spin, np.cross(spin, span))
        known = known + swing * tilt * np.cross(np.cross(e1, e2), span)
        rest = acceleration - known
        up = np.array([0.0, 0.0, 1.0])
        angle = np.arctan2(e2 @ up, e2 @ np.cross(up, e1))
        lean = np.arctan2(s @ e1, n)
        return Leg(
            e1,
            e2,
            s,
            (float(angle), float(swing), float(-(e2 @ rest) / (n * length))),
            (float(lean), float(tilt), float((across @ rest) / length)),
            (length, float(slide), float(s @ rest)),
        )

    def inverse_dynamics(self, motion: Motion) -> np.ndarray:
        """Forces of the six motors [N], shape (6,), positive where they push the legs longer."""
        balance = np.zeros((6, 6))
        known = np.zeros(6)
        pistons = np.zeros(6)
        for i in range(6):
            leg = self.leg(i, motion)
            across, pistons[i] = self._ball_force(i, leg)
            arm = motion.rotation @ self.balls[i]
            balance[:, i] = np.r_[leg.direction, np.cross(arm, leg.direction)]
            known += np.r_[across, np.cross(arm, across)]
        wanted = self._platform(motion)
        # the platform feels the opposite of the balls' forces on the pistons
        along = np.linalg.solve(balance, -wanted - known)
        return pistons - along

    def _platform(self, motion: Motion) -> np.ndarray:
        """Force and moment about the platform's origin that its motion asks for, weight included."""
        body = self.platform
        arm = motion.rotation @ body.com
        force = body.mass * (motion.point(body.com)[2] - self.gravity)
        inertia = motion.rotation @ body.inertia @ motion.rotation.T
        moment = inertia @ motion.spin_rate + np.cross(motion.spin, inertia @ motion.spin)
        return np.r_[force, moment + np.cross(arm, force)]

    def _ball_force(self, i: int, leg: Leg) -> tuple[np.ndarray, float]:
        """Force of the ball on the piston across the leg (3,), and what the piston asks for along the leg."""
        cross, cylinder, piston = self.parts[i]
        e1, e2, s, third = leg.e1, leg.e2, leg.direction, leg.across
        (length, slide, slide_rate), (_, swing, swing_rate), (_, tilt, tilt_rate) = leg.slide, leg.swing, leg.tilt
        spin = swing * e1 + tilt * e2
        spin_rate = swing_rate * e1 + tilt_rate * e2 + swing * tilt * np.cross(e1, e2)
        frame = np.column_stack([third, e2, s])
        on_cross = np.column_stack([e1, e2, np.cross(e1, e2)])
        zero = np.zeros(3)
        cross_moment, _ = self._demand(cross, on_cross, zero, zero, swing * e1, swing_rate * e1)
        drive = slide_rate * s + 2.0 * slide * np.cross(spin, s)
        moment, _ = self._demand(cylinder, frame, zero, zero, spin, spin_rate)
        more, force = self._demand(piston, frame, length * s, drive, spin, spin_rate)
        moment = moment + more
        n = float(np.linalg.norm(np.cross(s, e1)))
        sideways = (e2 @ moment) / length * third - (e1 @ (moment + cross_moment)) / (n * length) * e2
        return sideways, float(s @ force)

    def _demand(
        self, body: Body, frame: np.ndarray, origin: np.ndarray, drive: np.ndarray, spin: np.ndarray, rate: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Moment about the leg's foot and force that a part's motion asks for, weight included.

        The part turns about the foot with `spin`; `origin` is its frame from the foot and `drive` the acceleration
        that sliding adds.
        """
        arm = origin + frame @ body.com
        acceleration = np.cross(rate, arm) + np.cross(spin, np.cross(spin, arm)) + drive
        force = body.mass * (acceleration - self.gravity)
        inertia = frame @ body.inertia @ frame.T
        return inertia @ rate + np.cross(spin, inertia @ spin) + np.cross(arm, force), force
