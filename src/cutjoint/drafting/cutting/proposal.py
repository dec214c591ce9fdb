"""What `cutjoint cut` proposes, as values."""

from __future__ import annotations

from dataclasses import dataclass

from cutjoint.chain.mobility_report import MobilityReport
from cutjoint.description.model import RobotDescription
from cutjoint.drafting.cutting.kinds import TypeChoice


@dataclass(frozen=True)
class Proposed:
    """A cut that is proposed.

    Attributes:
        name, type: of the cut.
        frames: the links that its frames are on.
        why: what tells it: the file's own cut, the names of its frames, or their place at zero.
        distance, angle: between the frames at zero [m], [rad].
        choices: types that it may have, itself first; empty where the file says the type.
        instead: joints of its loop that may be cut instead, the best first.
    """

    name: str
    type: str
    frames: tuple[str, str]
    why: str
    distance: float
    angle: float
    choices: tuple[TypeChoice, ...]
    instead: tuple[str, ...]


@dataclass(frozen=True)
class Proposal:
    """What comes of a file.

    Attributes:
        robot: closed as proposed, with actuators and home; None where nothing is there to close.
        cuts: what is proposed.
        report: mobility of the robot at home; None with the robot.
        told: what was found and not used, or could not be told, a sentence each.
        ends: a link of each body that carries no other: where a loop may be open.
        chose_motors: whether the actuators are chosen here, since the file does not say them.
    """

    robot: RobotDescription | None
    cuts: tuple[Proposed, ...]
    report: MobilityReport | None
    told: tuple[str, ...]
    ends: tuple[str, ...]
    chose_motors: bool
