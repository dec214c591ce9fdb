"""Which links are the limb of which actuator, and in which colour.

Base and platform are no limbs: the base is the root with all that is fixed to it, a platform carries the tool, or joins
three limbs or more, and the robot falls apart where it is taken out.  What is left are pieces; a piece that holds one
actuator is its limb.  In a piece with several, as in a serial arm, a link belongs to the last actuator before it, or to
the only one after it.  Pieces without any belong to none.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.cuts import CutType
from cutjoint.description.model import Joint, RobotDescription, Shape
from cutjoint.viewer.picture.shapes import Colour

PALETTE: tuple[Colour, ...] = (
    (0.0, 0.447, 0.698, 1.0),
    (0.902, 0.624, 0.0, 1.0),
    (0.0, 0.62, 0.451, 1.0),
    (0.8, 0.475, 0.655, 1.0),
    (0.835, 0.369, 0.0, 1.0),
    (0.337, 0.706, 0.914, 1.0),
    (0.941, 0.894, 0.259, 1.0),
)
BRANCHES = 3
"""Pieces with actuators that a platform without a tool joins at least."""
AT_PIN = 1e-6
"""Distance of a tool from a joint below which it is on it, in the distances between the body's joints."""


def limb_colours(
    description: RobotDescription, visuals: Mapping[str, Sequence[Shape]], has_own: Callable[[Shape], bool]
) -> dict[str, Colour]:
    """Actuator -> colour of its limb: the most frequent bright one of its links, else the palette's.

    Limbs of which nothing is seen in that colour are not in it: their shapes all have other ones, or there are none.

    Args:
        description: the robot.
        visuals: what is seen of each link.
        has_own: whether a shape has a colour of its own.
    """
    bright: dict[str, Counter[Colour]] = {name: Counter() for name in description.actuators}
    plain: set[str] = set()
    for link, limb in limb_of(description).items():
        for shape in visuals.get(link, ()):
            if not has_own(shape):
                plain.add(limb)
            elif shape.colour is not None and _bright(shape.colour):
                bright[limb][shape.colour] += 1
    found = {}
    for i, (name, counts) in enumerate(bright.items()):
        if counts:
            found[name] = counts.most_common(1)[0][0]
        elif name in plain:
            found[name] = PALETTE[i % len(PALETTE)]
    return found


def limb_of(description: RobotDescription) -> dict[str, str]:
    """Link -> the actuator whose limb it is part of; base, platforms, tool and what is no limb are not in it."""
    bodies = _Bodies(description)
    hubs = {bodies.base} | bodies.platforms()
    found: dict[str, str] = {}
    for piece in bodies.pieces(hubs):
        inside = [name for name in description.actuators if bodies.of[description.joint(name).child] in piece]
        if len(inside) == 1:
            found |= {link: inside[0] for link, body in bodies.of.items() if body in piece}
        elif inside:
            found |= bodies.by_tree(piece)
    tool = description.tool
    if tool is not None and any(joint.child == tool.link and joint.type.dof == 0 for joint in description.joints):
        found.pop(tool.link, None)
    return found


class _Bodies:
    """The links of a robot in bodies, each what is fixed to each other and called by its first link."""

    def __init__(self, description: RobotDescription) -> None:
        self.description = description
        self.joints = _from_root(description)
        self.base = description.root
        self.of: dict[str, str] = {}
        self._placed: dict[str, Array] = {}
        """Placement of each link in its body."""
        self._gather()
        self.beside: dict[str, set[str]] = {body: set() for body in self.of.values()}
        pairs = [(joint.parent, joint.child) for joint in self.joints]
        for a, b in [*pairs, *((cut.a.link, cut.b.link) for cut in description.cuts)]:
            if self.of[a] != self.of[b]:
                self.beside[self.of[a]].add(self.of[b])
                self.beside[self.of[b]].add(self.of[a])

    def _gather(self) -> None:
        """Put every link into a body, over fixed joints and fixed cuts."""
        rigid: dict[str, list[tuple[str, Array]]] = {}
        ties: list[tuple[str, str, Array]] = [
            (joint.parent, joint.child, joint.placement) for joint in self.joints if joint.type.dof == 0
        ]
        for cut in self.description.cuts:
            if cut.type == CutType.FIXED and cut.bushing is None:
                ties.append((cut.a.link, cut.b.link, cut.a.placement @ np.linalg.inv(cut.b.placement)))
        for one, other, placement in ties:
            rigid.setdefault(one, []).append((other, placement))
            rigid.setdefault(other, []).append((one, np.asarray(np.linalg.inv(placement))))
        for link in (self.base, *(joint.child for joint in self.joints)):
            if link in self.of:
                continue
            self.of[link], self._placed[link] = link, np.eye(4)
            stack = [link]
            while stack:
                here = stack.pop()
                for other, placement in rigid.get(here, ()):
                    if other not in self.of:
                        self.of[other], self._placed[other] = link, self._placed[here] @ placement
                        stack.append(other)

    def pieces(self, without: set[str]) -> list[set[str]]:
        """What is connected when some bodies are taken out."""
        left, found = {body for body in self.beside if body not in without}, []
        while left:
            piece, edge = set(), {next(iter(left))}
            while edge:
                piece |= edge
                edge = {other for body in edge for other in self.beside[body]} & left - piece
            left -= piece
            found.append(piece)
        return found

    def platforms(self) -> set[str]:
        """Bodies that carry the tool or join limbs, and are none themselves."""
        tool = self.description.tool
        moved = {self.of[self.description.joint(name).child] for name in self.description.actuators}
        found = set()
        for body, others in self.beside.items():
            if body == self.base or len(others) < 2:
                continue
            apart = [piece for piece in self.pieces({self.base, body}) if piece & others]
            if tool is not None and body == self.of[tool.link]:
                if len(apart) >= 2 and not self._ends_at_pin(body):
                    found.add(body)
            elif sum(not piece.isdisjoint(moved) for piece in apart) >= BRANCHES:
                found.add(body)
        return found

    def _ends_at_pin(self, body: str) -> bool:
        """Whether the tool is on all joints of a body but one, as on the bar of a five-bar that ends at the other's."""
        tool, pins = self.description.tool, []
        if tool is None:
            return False
        for joint in self.joints:
            if joint.type.dof and self.of[joint.child] == body:
                pins.append(self._placed[joint.child][:3, 3])
            if joint.type.dof and self.of[joint.parent] == body:
                pins.append((self._placed[joint.parent] @ joint.placement)[:3, 3])
        for cut in self.description.cuts:
            pins += [(self._placed[f.link] @ f.placement)[:3, 3] for f in (cut.a, cut.b) if self.of[f.link] == body]
        point = (self._placed[tool.link] @ tool.placement)[:3, 3]
        size = max((float(np.linalg.norm(a - b)) for a in pins for b in pins), default=0.0)
        return sum(float(np.linalg.norm(point - pin)) > AT_PIN * size for pin in pins) <= 1

    def by_tree(self, piece: set[str]) -> dict[str, str]:
        """Links of a piece with several actuators."""
        actuators, ahead = set(self.description.actuators), dict[str, set[str]]()
        inside = [joint for joint in self.joints if self.of[joint.child] in piece]
        for joint in reversed(inside):
            beyond = ahead.setdefault(joint.child, set()) | ({joint.name} & actuators)
            ahead.setdefault(joint.parent, set()).update(beyond)
        found: dict[str, str] = {}
        for joint in inside:
            before = found.get(joint.parent)
            if joint.name in actuators:
                found[joint.child] = joint.name
            elif before is not None:
                found[joint.child] = before
            elif len(ahead[joint.child]) == 1:
                found[joint.child] = next(iter(ahead[joint.child]))
        return found


def _from_root(description: RobotDescription) -> list[Joint]:
    """The joints, parents before children."""
    children: dict[str, list[Joint]] = {}
    for joint in description.joints:
        children.setdefault(joint.parent, []).append(joint)
    found: list[Joint] = []
    stack = [description.root]
    while stack:
        own = children.get(stack.pop(), [])
        found += own
        stack += [joint.child for joint in own]
    return found


def _bright(colour: Colour) -> bool:
    return max(colour[:3]) - min(colour[:3]) > 0.25
