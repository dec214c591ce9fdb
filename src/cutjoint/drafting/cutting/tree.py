"""The open tree of a description, as questions about it: bodies, ways between links, places at zero."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.model import Joint, Link, RobotDescription

LIGHTEST = 1e-6
"""kg.  Programs give frames that are not meant as bodies 0 or 1e-9; what weighs more is a body."""


class Tree:
    """What is asked of the tree of a robot, whose cuts do not count."""

    def __init__(self, robot: RobotDescription) -> None:
        self.robot = robot
        self.links: Mapping[str, Link] = {one.name: one for one in robot.links}
        self.above: Mapping[str, Joint] = {one.child: one for one in robot.joints}

    def to_root(self, link: str) -> list[Joint]:
        """The joints from a link up to the root."""
        way = []
        while link in self.above:
            way.append(self.above[link])
            link = self.above[link].parent
        return way

    def depth(self, link: str) -> int:
        """How many joints that move lie between a link and the root."""
        return sum(joint.type.moves for joint in self.to_root(link))

    def body(self, link: str) -> str:
        """The link at which the body begins that a link is fixed to."""
        for joint in self.to_root(link):
            if joint.type.moves:
                break
            link = joint.parent
        return link

    def between(self, a: str, b: str) -> list[Joint]:
        """The joints that move on the way from one link to another."""
        ways = self.to_root(a), self.to_root(b)
        shared = {one.name for one in ways[0]} & {one.name for one in ways[1]}
        return [one for way in ways for one in way if one.name not in shared and one.type.moves]

    def is_frame(self, link: str) -> bool:
        """Whether a link is a mere frame: it weighs nothing and is fixed to another."""
        inertial, above = self.links[link].inertial, self.above.get(link)
        return (inertial is None or inertial.mass <= LIGHTEST) and above is not None and not above.type.moves

    @cached_property
    def ends(self) -> tuple[str, ...]:
        """Links of bodies that carry no other body and are not the base, in the order of the file."""
        carrying = {self.body(one.parent) for one in self.robot.joints if one.type.moves}
        root = self.robot.root
        return tuple(one for one in self.links if self.body(one) not in carrying | {root})

    @cached_property
    def on_base(self) -> tuple[str, ...]:
        """Mere frames of the base that carry nothing."""
        parents, root = {one.parent for one in self.robot.joints}, self.robot.root
        return tuple(one for one in self.links if one not in parents and self.is_frame(one) and self.body(one) == root)

    @cached_property
    def at_zero(self) -> Mapping[str, Array]:
        """World placement (4, 4) of every link in the zero configuration."""
        placed: dict[str, Array] = {}
        for link in self.links:
            place = np.eye(4)
            for joint in reversed(self.to_root(link)):
                place = place @ joint.placement
            placed[link] = place
        return placed

    @cached_property
    def size(self) -> float:
        """The largest distance of a link from the root at zero [m]; 1 where all are in one place."""
        origin = self.at_zero[self.robot.root][:3, 3]
        return max((float(np.linalg.norm(one[:3, 3] - origin)) for one in self.at_zero.values()), default=0.0) or 1.0
