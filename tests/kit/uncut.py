"""Closed robots without their cuts: frames where the cuts were, as people and exporters leave them in a URDF."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from cutjoint.chain import ClosedChain
from cutjoint.description import Joint, JointType, Link, RobotDescription, write
from cutjoint.description.transforms import inverse

ENDS = (("_loop_1", "_loop_2"), ("_closed_a", "_closed_b"), ("_cut_parent", "_cut_child"))


def at_zero(chain: ClosedChain) -> RobotDescription:
    """The same robot with its closed home as the zero configuration, without limits and homes."""
    placed = chain.link_placements(chain.home)
    joints = tuple(
        replace(one, placement=inverse(placed[one.parent]) @ placed[one.child], limits=type(one.limits)())
        for one in chain.description.joints
    )
    return replace(chain.description, joints=joints, homes=(), couplings=())


def uncut(robot: RobotDescription, ends: tuple[str, str]) -> RobotDescription:
    """The robot with a frame on either side of every cut instead of the cut; `ends`: of their names."""
    links, joints = list(robot.links), list(robot.joints)
    for cut in robot.cuts:
        for frame, end in ((cut.a, ends[0]), (cut.b, ends[1])):
            name = f"{cut.name}{end}"
            links.append(Link(name))
            joints.append(Joint(f"{name}_mount", JointType.FIXED, frame.link, name, frame.placement))
    return replace(robot, links=tuple(links), joints=tuple(joints), cuts=())


def written(robot: RobotDescription, folder: Path, *, tree_alone: bool) -> Path:
    """The robot on disk: its folder, or the URDF of its tree, without actuators, tool and homes."""
    write(robot, folder, "loops")
    if tree_alone:
        (folder / "loops.toml").unlink()
        return folder / "robot.urdf"
    return folder


def random(seed: int) -> np.random.Generator:
    """A generator of its own for every seed."""
    return np.random.default_rng([20, seed])
