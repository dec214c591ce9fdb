"""Robots and states for the tests of the compiler."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import pytest

from cutjoint.arrays import readonly
from cutjoint.chain import ClosedChain
from cutjoint.compile import compiled
from cutjoint.description.model import (
    CutJoint,
    CutType,
    Frame,
    Home,
    Inertial,
    Joint,
    JointType,
    Link,
    RobotDescription,
)
from cutjoint.description.transforms import placement
from cutjoint.errors import ClosureError
from cutjoint.mechanism import Mechanism, Posture
from cutjoint.robots import load, published

FRAME_A = placement((0.2, -0.1, 0.15), (0.4, -0.7, 1.1))
FRAME_B = placement((-0.1, 0.12, 0.05), (-0.9, 0.3, 0.6))


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


def body(mass: float, com: tuple[float, ...], seed: int) -> Inertial:
    """A body with all six moments, which can exist."""
    points = np.random.default_rng(seed).normal(size=(8, 3)) * 0.1
    points -= points.mean(axis=0)
    return Inertial(mass, np.array(com), mass / 8 * sum((p @ p) * np.eye(3) - np.outer(p, p) for p in points))


def two_bodies(kind: str) -> RobotDescription:
    """Two free bodies, a cut of the given type between oblique frames of both."""
    return RobotDescription(
        name=f"two bodies, {kind}",
        links=(
            Link("base"),
            Link("one", body(1.5, (0.05, -0.02, 0.03), 1)),
            Link("two", body(0.8, (0.0, 0.06, -0.03), 2)),
        ),
        joints=(Joint("f1", JointType.FLOATING, "base", "one"), Joint("f2", JointType.FLOATING, "base", "two")),
        cuts=(CutJoint("cut", CutType(kind), Frame("one", FRAME_A), Frame("two", FRAME_B)),),
        homes=(Home("default", {}, {"f1": (0.0, 0.0, 0.0, 0.1, 0.2, 0.3), "f2": (0.3, 0.1, 0.2, -0.2, 0.5, 0.1)}),),
    )


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


@dataclass(frozen=True)
class Kit:
    """The functions above, for the tests (test modules cannot import one another)."""

    model: Callable[..., Any] = model
    machine: Callable[..., Any] = machine
    nearby: Callable[..., Posture] = nearby
    allowed_velocity: Callable[..., np.ndarray] = allowed_velocity
    two_bodies: Callable[..., RobotDescription] = two_bodies
    limb_and_body: Callable[..., RobotDescription] = limb_and_body


@pytest.fixture(scope="session")
def kit() -> Kit:
    """Builders of robots and states."""
    return Kit()
