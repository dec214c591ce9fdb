"""Robots and states for the tests of the compiler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from kit.two_bodies import FRAME_A, FRAME_B, body, two_bodies

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.description.model import (
    CutJoint,
    CutType,
    Frame,
    Home,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement
from cutjoint.errors import ClosureError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.robots import load, published


@cache
def model(name: str) -> Any:
    """A robot under urdf/, or `paper NAME` for its published model, built once."""
    return published(name.removeprefix("paper ")) if name.startswith("paper ") else load(name)


@cache
def machine(name: str) -> Any:
    """The same, compiled once."""
    return compiled(model(name))


def nearby(mechanism: Mechanism, rng: np.random.Generator, reach: float = 0.1) -> Posture:
    """A random posture around home."""
    for _ in range(30):
        try:
            return mechanism.close(mechanism.home.q + reach * rng.uniform(-1, 1, mechanism.n))
        except ClosureError:
            reach *= 0.8
    raise AssertionError(f"{mechanism.name} cannot move at all")


def allowed_velocity(chain: ClosedChain, q_full: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A random velocity of all joints that respects the loops."""
    jacobian = chain.constraint_jacobian(q_full)
    v = rng.normal(size=chain.nv)
    return v - np.linalg.lstsq(jacobian, jacobian @ v, rcond=1e-9)[0]


def limb_and_body(kind: str) -> RobotDescription:
    """An oblique limb of turn, joint of the given type, turn, whose end is pinned to a free body by a ball."""
    slanted = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    across = np.cross(slanted, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    start: dict[str, Any] = {
        "revolute": 0.4,
        "continuous": -0.7,
        "prismatic": 0.05,
        "universal": (0.3, -0.2),
        "spherical": (0.3, -0.4, 0.5),
        "planar": (0.1, -0.05, 0.6),
        "floating": (0.1, -0.1, 0.05, 0.2, 0.3, -0.4),
    }
    return RobotDescription(
        name=f"limb with {kind}",
        links=(
            Link("base"),
            Link("upper", body(0.9, (0.1, 0.02, -0.03), 3)),
            Link("middle", body(0.7, (-0.02, 0.08, 0.01), 4)),
            Link("lower", body(0.5, (0.03, 0.01, 0.07), 5)),
            Link("free", body(1.1, (0.02, -0.03, 0.04), 6)),
        ),
        joints=(
            Joint(
                "shoulder", JointType.REVOLUTE, "base", "upper", placement((0.1, 0, 0.2), (0.3, 0, 0.1)), axis=slanted
            ),
            Joint("joint", JointType(kind), "upper", "middle", FRAME_A, axis=readonly(slanted), axis2=readonly(across)),
            Joint("wrist", JointType.CONTINUOUS, "middle", "lower", FRAME_B, axis=readonly([0.0, 1.0, 0.0])),
            Joint("free", JointType.FLOATING, "base", "free"),
        ),
        cuts=(CutJoint("ball", CutType.SPHERICAL, Frame("lower", FRAME_B), Frame("free", FRAME_A)),),
        homes=(
            Home(
                "default",
                {},
                {"shoulder": 0.5, "joint": start[kind], "wrist": -0.3, "free": (0.2, 0.1, 0.4, 0.1, 0.2, 0.3)},
            ),
        ),
    )


class Numbers:
    """A closed chain by variational principles alone: Pinocchio's mass matrix and forces of the open tree, the chain's
    constraint Jacobian, null spaces by numpy.  It knows nothing of passive columns, tangents or orders of elimination.

    - Kelvin: of all velocities that the loops allow with given actuated rates, the robot has the one of least kinetic
      energy, where what its actuators leave free was never pushed.
    - Gauss: of all accelerations that the loops allow, it has the one nearest to that of the open tree, in its mass
      matrix.
    """

    def __init__(self, chain: ClosedChain) -> None:
        self.chain, self.model, self.length = chain, chain.model, chain.length
        self.data = chain.model.createData()
        rows = []
        for cut in chain.description.cuts:
            lengths = 2 if cut.type is CutType.PRISMATIC else 3
            rows += [self.length] * lengths + [1.0] * (cut.type.rows - lengths)
        sliding = {joint.name for joint in chain.description.joints if joint.type is JointType.PRISMATIC}
        rows += [self.length if coupling.joint in sliding else 1.0 for coupling in chain.description.couplings]
        self.rows, self.scale = np.array(rows), np.ones(chain.nv)
        for joint in chain.description.joints:
            if joint.type is not JointType.FIXED:
                first = chain.model.joints[chain.model.getJointId(joint.name)].idx_v
                count = {JointType.PRISMATIC: 1, JointType.PLANAR: 2, JointType.FLOATING: 3}.get(joint.type, 0)
                self.scale[first : first + count] = self.length
        self.driven = [int(i) for i in chain.actuated_velocity(np.arange(float(chain.nv)))]

    def constraints(self, q: np.ndarray) -> np.ndarray:
        """Dimensionless constraint Jacobian."""
        given = np.reshape(self.chain.constraint_jacobian(q), (-1, self.chain.nv))
        return given * self.scale / self.rows[:, None]

    def allowed(self, q: np.ndarray) -> np.ndarray:
        """Basis of the motions that the loops allow, (nv, mobility)."""
        matrix = self.constraints(q)
        if not len(matrix):
            return np.diag(self.scale)
        _, values, basis = np.linalg.svd(matrix)
        rank = int(np.sum(values > 1e-7 * max(values.max(initial=0.0), 1.0)))
        return self.scale[:, None] * basis[rank:].T

    def mass(self, q: np.ndarray) -> np.ndarray:
        """Of the open tree."""
        upper = np.triu(np.reshape(pin.crba(self.model, self.data, q), (self.chain.nv, self.chain.nv)))
        return upper + np.triu(upper, 1).T

    def forces(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Of the open tree."""
        return np.array(pin.rnea(self.model, self.data, q, v, a))

    def bent(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """An acceleration that the loops allow at the velocity v: least squares of the Jacobian's change along it."""
        size = float(np.abs(v / self.scale).max(initial=0.0))
        if size == 0.0 or not len(self.rows):
            return np.zeros(self.chain.nv)
        h = 3e-3 / size
        ahead = [self.constraints(pin.integrate(self.model, q, k * h * v)) for k in (-3, -2, -1, 1, 2, 3)]
        rate = sum(w * one for w, one in zip((-1, 9, -45, 45, -9, 1), ahead, strict=True)) / (60.0 * h)
        matrix = self.constraints(q)
        left, values, right = np.linalg.svd(matrix, full_matrices=False)
        rank = int(np.sum(values > 1e-7 * max(values.max(initial=0.0), 1.0)))
        return -self.scale * (right[:rank].T @ (left[:, :rank].T @ (rate @ (v / self.scale)) / values[:rank]))

    def tangent(self, q: np.ndarray) -> np.ndarray:
        """(nv, n): by Kelvin's principle."""
        basis, mass = self.allowed(q), self.mass(q)
        _, values, right = np.linalg.svd(basis[self.driven])
        rank = len(self.driven)
        assert values[-1] > 1e-7 * values[0], "the actuators do not move independently"
        some = basis @ np.linalg.pinv(basis[self.driven])
        idle = basis @ right[rank:].T
        if not idle.shape[1]:
            return some
        return some - idle @ np.linalg.solve(idle.T @ mass @ idle, idle.T @ mass @ some)

    def accelerations(self, q: np.ndarray, v_full: np.ndarray, effort: np.ndarray) -> np.ndarray:
        """Of all joints, (nv,), by Gauss's principle, for efforts of the actuators."""
        basis, start = self.allowed(q), self.bent(q, v_full)
        push = np.zeros(self.chain.nv)
        push[self.driven] = effort
        energy = basis.T @ self.mass(q) @ basis
        return start + basis @ np.linalg.solve(energy, basis.T @ (push - self.forces(q, v_full, start)))

    def effort(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """(n,): the one that gives this acceleration; forward dynamics are linear in it."""
        v_full, n = self.tangent(q) @ v, len(self.driven)
        none = self.accelerations(q, v_full, np.zeros(n))[self.driven]
        # a push of the size of those that are there, or the difference loses digits
        unit = float(np.abs(np.diag(self.mass(q))).max() * np.abs(np.concatenate([a, none])).max())
        columns = [self.accelerations(q, v_full, unit * one)[self.driven] - none for one in np.eye(n)]
        return unit * np.linalg.solve(np.stack(columns, axis=1), a - none)


@dataclass(frozen=True)
class Kit:
    """The functions above, for the tests (test modules cannot import one another)."""

    model: Callable[..., Any] = model
    machine: Callable[..., Any] = machine
    nearby: Callable[..., Posture] = nearby
    allowed_velocity: Callable[..., np.ndarray] = allowed_velocity
    two_bodies: Callable[..., RobotDescription] = two_bodies
    limb_and_body: Callable[..., RobotDescription] = limb_and_body
    numbers: type[Numbers] = Numbers


@pytest.fixture(scope="session")
def kit() -> Kit:
    """Builders of robots and states."""
    return Kit()
