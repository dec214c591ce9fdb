"""Robots whose weights are compensated in part, and the loads that do the same to the robots without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cutjoint.description import RobotDescription
from cutjoint.mechanism import Load


def held_up(robot: RobotDescription, rng: np.random.Generator) -> RobotDescription:
    """The robot with some of its weights compensated: of links at random none, a part, all, or more."""
    shares = rng.choice([0.0, rng.uniform(0.1, 0.9), 1.0, 1.0 + rng.uniform()], len(robot.links))
    pairs = zip(robot.links, shares.tolist(), strict=True)
    return replace(robot, links=tuple(replace(link, gravity_compensation=share) for link, share in pairs))


def weighing(robot: RobotDescription) -> RobotDescription:
    """The robot with its whole weight."""
    return replace(robot, links=tuple(replace(link, gravity_compensation=0.0) for link in robot.links))


def lifts(robot: RobotDescription) -> tuple[Load, ...]:
    """What compensates the weights of a robot, as loads."""
    return tuple(
        Load(-link.gravity_compensation * link.inertial.mass * robot.gravity, link=link.name, point=link.inertial.com)
        for link in robot.links
        if link.inertial is not None and link.gravity_compensation
    )
