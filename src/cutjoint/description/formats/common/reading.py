"""What a reader of a file format hands back."""

from __future__ import annotations

from dataclasses import dataclass, field

from cutjoint.description.model import Coupling, Joint, Link, RobotDescription
from cutjoint.errors import Problem


@dataclass(frozen=True)
class Reading:
    """What was read, as far as it could be read, and everything that is wrong with the text of the files.

    Attributes:
        description: None where nothing useful was left.  It is not checked yet; `cutjoint.description.check` does that.
        problems: errors and warnings of the syntax, the numbers and the names of elements and keys.
    """

    description: RobotDescription | None
    problems: tuple[Problem, ...] = ()


@dataclass
class OpenTree:
    """Links and joints as a reader gathers them, and the actuators where the tree's own file names some."""

    name: str
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    couplings: list[Coupling] = field(default_factory=list)
    actuators: tuple[str, ...] = ()
