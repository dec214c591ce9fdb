"""Blocks on level rails, one an actuator: bodies whose motion under any sampled effort is known in closed form."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.description import Frame, Inertial, Joint, JointType, Link, RobotDescription
from cutjoint.description.model import NO_PHYSICS, JointPhysics, Limits


def blocks(masses: Sequence[float], physics: JointPhysics = NO_PHYSICS, way: float = np.inf) -> ClosedChain:
    """A robot of blocks [kg] on rails along x that are `way` [m] long in both directions."""
    names = [f"rail{i}" for i in range(len(masses))]
    links = [Link("base"), *(Link(f"block{i}", Inertial(mass, inertia=np.eye(3))) for i, mass in enumerate(masses))]
    limits = Limits(-way, way)
    rails = [
        Joint(name, JointType.PRISMATIC, "base", f"block{i}", axis=[1.0, 0.0, 0.0], limits=limits, physics=physics)
        for i, name in enumerate(names)
    ]
    return ClosedChain(
        RobotDescription("blocks", tuple(links), tuple(rails), (), actuators=tuple(names), tool=Frame("block0"))
    )
