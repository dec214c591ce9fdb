"""Two free bodies with a cut of any type between oblique frames of both, and bodies that can exist."""

from __future__ import annotations

import numpy as np

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

FRAME_A = placement((0.2, -0.1, 0.15), (0.4, -0.7, 1.1))
FRAME_B = placement((-0.1, 0.12, 0.05), (-0.9, 0.3, 0.6))
LENGTH = 0.25
"""Of a distance [m]."""


def body(mass: float = 1.5, com: tuple[float, ...] = (0.05, -0.02, 0.03), seed: int = 1) -> Inertial:
    """A body with all six moments, which can exist."""
    points = np.random.default_rng(seed).normal(size=(8, 3)) * 0.1
    points -= points.mean(axis=0)
    inertia = mass / 8 * sum((p @ p) * np.eye(3) - np.outer(p, p) for p in points)
    return Inertial(mass, np.array(com), inertia)


def two_bodies(kind: str) -> RobotDescription:
    """Two free bodies, a cut of the given type between oblique frames of both."""
    return RobotDescription(
        name=f"two bodies, {kind}",
        links=(Link("base"), Link("one", body()), Link("two", body(0.8, (0.0, 0.06, -0.03), 2))),
        joints=(Joint("f1", JointType.FLOATING, "base", "one"), Joint("f2", JointType.FLOATING, "base", "two")),
        cuts=(
            CutJoint(
                "cut", CutType(kind), Frame("one", FRAME_A), Frame("two", FRAME_B), length=LENGTH * (kind == "distance")
            ),
        ),
        homes=(Home("default", {}, {"f1": (0.0, 0.0, 0.0, 0.1, 0.2, 0.3), "f2": (0.3, 0.1, 0.2, -0.2, 0.5, 0.1)}),),
    )
