"""What of a robot is recorded that names no tool: the end of its longest limb.

A result holds where the tool is, so a robot needs one to be simulated.  Of one that has none the link is taken that the
most joints move, the first of several, with its own axes.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from cutjoint.chain import ClosedChain
from cutjoint.description.model import Frame, RobotDescription


class Watched(NamedTuple):
    """A robot with a tool, and the link that was taken for it; None where the robot names its own."""

    chain: ClosedChain
    link: str | None


def watched(chain: ClosedChain) -> Watched:
    """`chain` where it has a tool, else the same robot with the end of its longest limb for a tool."""
    if chain.description.tool is not None:
        return Watched(chain, None)
    link = _end(chain.description)
    return Watched(chain.rebuilt(replace(chain.description, tool=Frame(link))), link)


def _end(description: RobotDescription) -> str:
    """The link that the most coordinates of joints move."""
    above = {joint.child: joint for joint in description.joints}

    def moving(link: str) -> int:
        count = 0
        while link in above:
            joint = above[link]
            count, link = count + len(joint.type.coordinates), joint.parent
        return count

    return max((link.name for link in description.links), key=moving)
