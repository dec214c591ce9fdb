"""Which cuts and couplings an MJCF says by `<equality>` alone, and which its custom text has to say too.

The reader passes over equalities that are called like something in the text, NAME or NAME/1, NAME/2, ...; so whatever
would be passed over goes into the text as well.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from cutjoint.description.formats.mjcf.cut import SAID
from cutjoint.description.formats.mjcf.ties import tied
from cutjoint.description.model import CutJoint, RobotDescription
from cutjoint.mechanism.physics import NO_PHYSICS


@dataclass(frozen=True)
class Told:
    """What the text says: cuts by name, and whether it has the couplings."""

    cuts: frozenset[str]
    couplings: bool


def told_apart(robot: RobotDescription) -> Told:
    """What of a robot the text has to say: what equalities cannot, and couplings where there are more than gears."""
    cuts = {cut.name for cut in robot.cuts if not _is_equality(cut)}
    ties = tied(robot)
    couplings = {one.name for one in ties}
    gears = all(one.gear or not one.drives for one in ties)
    told = not gears or "" in couplings or bool(couplings & {cut.name for cut in robot.cuts})
    while True:
        names = cuts | couplings if told else cuts
        more = {cut.name for cut in robot.cuts if passed_over(cut.name, names)} - cuts
        again = not told and any(passed_over(one, names) for one in couplings)
        if not more and not again:
            return Told(frozenset(cuts), told)
        cuts, told = cuts | more, told or again


def passed_over(name: str, known: Collection[str]) -> bool:
    """Whether an equality is taken for a part of something that is known otherwise."""
    return name in known or name.rpartition("/")[0] in known


def _is_equality(cut: CutJoint) -> bool:
    return cut.type in SAID and cut.bushing is None and cut.physics == NO_PHYSICS
