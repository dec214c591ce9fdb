"""A robot whose files give no shapes, as sticks: each link a star from its middle to the joints and cuts on it.

Where links meet is a ball.  What slides has a rod as well, back to where it slides on at home.  The base is not drawn.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping

import numpy as np

from cutjoint.arrays import Array
from cutjoint.description.model import Joint, RobotDescription, Shape
from cutjoint.viewer.picture.shapes import along, translation

BALL = 1.5
"""Radius of the balls, in that of the sticks."""


def is_bare(description: RobotDescription) -> bool:
    """Whether there is nothing to be seen of any link."""
    return not any(link.visuals or link.collisions for link in description.links)


def sticks(
    description: RobotDescription, radius: float, placements: Mapping[str, Array]
) -> Mapping[str, tuple[Shape, ...]]:
    """Shapes of links, by their names; `radius` [m] is that of a stick, `placements` (4, 4) are the links' at home."""
    found: dict[str, tuple[Shape, ...]] = {}
    balls = _balls(description)
    for link, points in _points(description, placements).items():
        round_ones = [Shape("sphere", (BALL * radius,), translation(point)) for point in balls[link]]
        straight_ones = [] if link == description.root else _star(np.array(points), radius)
        found[link] = (*round_ones, *straight_ones)
    return found


def _balls(description: RobotDescription) -> Mapping[str, list[Array]]:
    """Where links meet, on one of the two alone, in its frame [m]."""
    found: dict[str, list[Array]] = defaultdict(list)
    for joint in description.joints:
        if not _glides(joint):
            found[joint.child].append(np.zeros(3))
    for cut in description.cuts:
        found[cut.a.link].append(cut.a.placement[:3, 3])
    return found


def _points(description: RobotDescription, placements: Mapping[str, Array]) -> Mapping[str, list[Array]]:
    """Where joints, cuts and the tool are on each link at home, in its frame [m]."""
    found: dict[str, list[Array]] = defaultdict(list)
    for joint in description.joints:
        if not _glides(joint):
            found[joint.parent].append(joint.placement[:3, 3])
            found[joint.child].append(np.zeros(3))
        if joint.type.slides:
            rail = np.linalg.inv(placements[joint.child]) @ placements[joint.parent] @ joint.placement
            found[joint.child].append(rail[:3, 3])
    for cut in description.cuts:
        for frame in (cut.a, cut.b):
            found[frame.link].append(frame.placement[:3, 3])
    if description.tool is not None:
        found[description.tool.link].append(description.tool.placement[:3, 3])
    return found


def _glides(joint: Joint) -> bool:
    """Whether a joint holds its link nowhere: it flies, or glides on a plane."""
    return sum(joint.type.lengths) > 1


def _star(points: Array, radius: float) -> list[Shape]:
    """Sticks from the middle of some points to each of them."""
    shapes, middle = [], points.mean(axis=0)
    for way in points - middle:
        length = float(np.linalg.norm(way))
        if length > radius:
            placement = along(way)
            placement[:3, 3] = middle + 0.5 * way
            shapes.append(Shape("cylinder", (radius, length), placement))
    return shapes
