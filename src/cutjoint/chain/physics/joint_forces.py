"""What joints do by themselves, along their coordinates; see `cutjoint.mechanism.physics` for the forces."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from cutjoint.arrays import Array
from cutjoint.chain.build import UNBOUNDED
from cutjoint.chain.joints import is_ball
from cutjoint.description.model import RobotDescription
from cutjoint.mechanism.physics import JointPhysics
from cutjoint.mechanism.rotations import matrix_of


def smooth_sign(speed: Array, full: Array) -> Array:
    """The sign of a speed, from `full` on; below it the odd quintic that joins it; where that is 0 it jumps."""
    x = np.clip(np.divide(speed, full, out=np.sign(speed), where=full > 0.0), -1.0, 1.0)
    square = x * x
    return np.asarray(x * (15.0 - square * (10.0 - 3.0 * square)) / 8.0)


def resisted(physics: JointPhysics, speed: Array) -> Array:
    """Damping and friction against the speed of one coordinate (1,), of each of two (2,), or of a ball (3,)."""
    if speed.size < 3:
        rubbed = smooth_sign(speed, np.full(speed.size, physics.speed))
        return np.asarray(physics.damping * speed + physics.friction * rubbed)
    size = float(np.linalg.norm(speed))
    if size == 0.0:
        return np.zeros(3)
    rubbed = physics.friction * smooth_sign(np.array([size]), np.array([physics.speed]))[0]
    return np.asarray((physics.damping + rubbed / size) * speed)


class JointForces:
    """What acts along single coordinates: of all joints but balls.

    Attributes:
        held: velocities along which anything but a rotor acts, shape (k,).
    """

    def __init__(self, model: pin.Model, description: RobotDescription) -> None:
        numbers = np.zeros((8, model.nv))
        numbers[6], numbers[7] = -UNBOUNDED, UNBOUNDED
        where = np.zeros(model.nv, dtype=int)
        self.sticking: dict[int, float] = {}
        for joint in range(1, model.njoints):
            one = description.joint(model.names[joint])
            physics, start, count = one.physics, int(model.idx_vs[joint]), int(model.nvs[joint])
            if is_ball(model, joint) or not physics.acts:
                continue
            rates = slice(start, start + count)
            numbers[0, rates] = physics.damping
            if count != model.nqs[joint]:
                continue  # planar and floating: only dampers act on them
            where[rates] = int(model.idx_qs[joint]) + np.arange(count)
            given = physics.friction, physics.speed, physics.stiffness, physics.rest or 0.0
            numbers[1:5, rates] = np.array(given)[:, None]
            if physics.sticks:
                self.sticking |= dict.fromkeys(range(start, start + count), physics.friction)
            if count == 1 and physics.stop_stiffness > 0.0:
                numbers[5, start] = physics.stop_stiffness
                numbers[6, start] = model.lowerPositionLimit[where[start]]
                numbers[7, start] = model.upperPositionLimit[where[start]]
        self._where = where
        self._damping, self._friction, self._full, self._stiff, self._rest, self._stop = numbers[:6]
        self._lower, self._upper = numbers[6:]
        self._bounce = np.zeros(model.nv)
        for joint in range(1, model.njoints):
            if numbers[5, at := int(model.idx_vs[joint])] > 0.0:
                self._bounce[at] = description.joint(model.names[joint]).physics.stop_damping
        self._rubs, self._springs, self._stops = (
            bool(self._friction.any()),
            bool(self._stiff.any()),
            bool(self._stop.any()),
        )
        self.held = np.flatnonzero(self._damping + self._friction + self._stiff + self._stop)
        self.acts = bool(self.held.size)

    def _beyond(self, q: Array) -> Array:
        """How far every coordinate is beyond its stops, negative below the lower one, shape (nv,)."""
        at = q[self._where]
        return np.where(self._stop > 0.0, np.maximum(at - self._upper, 0.0) + np.minimum(at - self._lower, 0.0), 0.0)

    def springs(self, q: Array) -> Array:
        held = self._stiff * (q[self._where] - self._rest) if self._springs else np.zeros(len(self._where))
        return held + self._stop * self._beyond(q) if self._stops else held

    def friction(self, q: Array, v: Array) -> Array:
        lost = self._damping * v
        if self._rubs:
            lost += self._friction * smooth_sign(v, self._full)
        if self._stops:
            beyond = self._beyond(q)
            side = np.sign(beyond)
            pressed = self._stop * np.abs(beyond)
            # a stop pushes and never pulls
            lost += side * (np.maximum(pressed + self._bounce * side * v, 0.0) - pressed)
        return np.asarray(lost)

    def potential(self, q: Array) -> float:
        energy = 0.5 * float(self._stiff @ (q[self._where] - self._rest) ** 2) if self._springs else 0.0
        return energy + 0.5 * float(self._stop @ self._beyond(q) ** 2) if self._stops else energy


class BallForces:
    """A ball joint: spring towards its zero, damper and friction about the axis that it turns about."""

    def __init__(self, model: pin.Model, joint: int, physics: JointPhysics) -> None:
        self.physics = physics
        self.at = slice(int(model.idx_vs[joint]), int(model.idx_vs[joint]) + 3)
        self._q = slice(int(model.idx_qs[joint]), int(model.idx_qs[joint]) + 4)

    def _turn(self, q: Array) -> Array:
        return np.asarray(pin.log3(matrix_of(q[self._q])))

    def spring(self, q: Array) -> Array:
        return self.physics.stiffness * self._turn(q)

    def friction(self, v: Array) -> Array:
        return resisted(self.physics, v[self.at])

    def potential(self, q: Array) -> float:
        turn = self._turn(q)
        return 0.5 * self.physics.stiffness * float(turn @ turn)


def balls(model: pin.Model, description: RobotDescription) -> list[BallForces]:
    """The ball joints of a model that do something by themselves."""
    found = []
    for joint in range(1, model.njoints):
        physics = description.joint(model.names[joint]).physics
        if is_ball(model, joint) and physics.acts:
            found.append(BallForces(model, joint, physics))
    return found
